#pragma once

#include <optional>
#include <string>
#include <vector>

namespace mass_spring {

/// Time integration schemes. Equation numbers are those of the course notes.
enum class Scheme {
  kExplicitEuler,        ///< eq. 10-11
  kSymplecticEuler,      ///< velocities first, then positions with the new velocities; with an
                         ///< accuracy, half a kick at each end of a step (Stoermer-Verlet, order 2)
  kRk4,                  ///< the classical Runge-Kutta method
  kLinearImplicitEuler,  ///< eq. 16/19: implicit Euler after one Newton iteration from x_n
  kImplicitEuler,        ///< eq. 12-13, solved by Newton's method
  kImplicitMidpoint,     ///< keeps energy on linear problems; not stable on stiff nonlinear ones
  kBdf2,                 ///< two-step backward differentiation, for variable steps
  kTrBdf2,               ///< trapezoidal rule, then BDF2, in one step (Bank et al. 1985)
  kRos3,                 ///< Rosenbrock method of three stages (Sandu et al. 1997)
  kXpbd,  ///< one spring after the other: coarse, cheap and stable (Macklin et al. 2019)
  kAuto,  ///< the cheapest of symplectic_euler, tr_bdf2 and, with an accuracy, rk4
};

/// Properties of a scheme.
struct SchemeInfo {
  Scheme scheme;
  std::string name;  ///< as in scene files
  int order;         ///< global error O(h^order)
  bool implicit;     ///< stable at any step on linear problems
  bool estimates;    ///< gives an estimate of each step's error
};

/// All schemes but auto, in the order of the enumeration.
const std::vector<SchemeInfo>& schemes();
/// @param scheme  not auto
const SchemeInfo& info(Scheme scheme);
/// Names as in scene files, auto among them, in the order of the enumeration.
const std::vector<std::string>& schemeNames();
const std::string& name(Scheme scheme);
std::optional<Scheme> schemeFromName(const std::string& name);

/// Linear solvers of the implicit schemes.
enum class LinearSolver {
  kAuto,               ///< a direct factor for small or chain-like systems, else multigrid
  kConjugateGradient,  ///< preconditioned by a block incomplete Cholesky factor
  kCholesky,           ///< sparse factor, for any scene
  kBanded,             ///< factor of a band: for ropes and chains of any kind, slow for the rest
  kMultigrid,          ///< conjugate gradients preconditioned by a multigrid cycle
};

/// Names as in scene files, in the order of the enumeration.
const std::vector<std::string>& linearSolverNames();
const std::string& name(LinearSolver solver);
std::optional<LinearSolver> linearSolverFromName(const std::string& name);

/// The error that a solver.accuracy gave on a scene when it was measured.
struct CalibrationPoint {
  double accuracy;  ///< m, asked for, > 0
  double error;     ///< m, RMS against a reference, > 0
};

struct SolverOptions {
  Scheme scheme = Scheme::kTrBdf2;
  int substeps = 1;                ///< equal sub-steps of each step, [1, 100000]
  double newton_tolerance = 1e-6;  ///< error of a displacement / mean rest length, (0, 1)
  int max_newton_iterations = 20;  ///< [1, 1000]
  LinearSolver linear_solver = LinearSolver::kAuto;
  /// m, > 0: sub-steps are chosen so that the estimated errors of one second add up to no more. For
  /// schemes with an estimate, and auto, which scene files mean where they name no scheme.
  std::optional<double> accuracy;
  std::string calibration_file;  ///< as the scene names it; "" = none; only with an accuracy
  /// Measured for the scheme by accuracy_study: the accuracy then is the error of the positions, on
  /// this scene.
  std::vector<CalibrationPoint> calibration;  // by ascending accuracy
  /// s per step, > 0: as many sub-steps as fit into that time; not together with an accuracy.
  std::optional<double> budget;
  double linear_tolerance = 1e-6;    ///< |b - A x| / |b|, (0, 1)
  int max_linear_iterations = 1000;  ///< [1, 1000000]
  int threads = 0;                   ///< at most, [0, 256]; 0 = all cores; more than 2 are not used
};

/// The accuracy [m] that the step control uses: solver.accuracy itself, or, with a calibration, the
/// largest accuracy whose error was no larger than solver.accuracy. Between two points of the
/// calibration, the error is a power of the accuracy; below the smallest point, it is proportional;
/// above the largest point, the accuracy stays that of this point.
std::optional<double> controlledAccuracy(const SolverOptions& options);

}  // namespace mass_spring

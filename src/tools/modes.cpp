#include "tools/modes.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>

#include "effects/effect.h"

namespace mass_spring {
namespace {

constexpr Eigen::Index kMostParticles = 300;  // free ones: some seconds for a dense matrix
constexpr double kNear = 0.1;       // of a spring's length, by which its ends part from the rest
constexpr double kNotable = 0.01;   // share of the energy
constexpr std::size_t kModes = 5;   // at the most
constexpr double kPredicted = 0.1;  // error of the linearization, and what it may leave unexplained
constexpr double kFewestSamples = 4.0;  // per period, in frames of the reference

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// The scene as y'' = f(y, y') in the coordinates y of its free particles times sqrt(mass).
class FreeModel {
 public:
  FreeModel(const Scene& scene, const std::vector<char>& pinned)
      : model_(buildModel(scene)), workspace_(model_) {
    for (Eigen::Index i = 0; i < model_.masses.size(); ++i) {
      if (!pinned[static_cast<std::size_t>(i)]) free_.push_back(i);
    }
  }
  const Model& model() const { return model_; }
  Eigen::Index particles() const { return static_cast<Eigen::Index>(free_.size()); }

  Vector gather(const Vectors& values, double power) const {
    Vector y(3 * particles());
    for (Eigen::Index k = 0; k < particles(); ++k) {
      y.segment<3>(3 * k) = std::pow(model_.masses[free_[k]], power) * values.col(free_[k]);
    }
    return y;
  }
  Vectors scatter(const Vector& y, double power) const {
    Vectors values = zero();
    for (Eigen::Index k = 0; k < particles(); ++k) {
      values.col(free_[k]) = std::pow(model_.masses[free_[k]], power) * y.segment<3>(3 * k);
    }
    return values;
  }
  Vector acceleration(const Vectors& positions) {
    Vectors forces = zero();
    const Vectors none = zero();
    sumForces(workspace_, nullptr, at(positions, none), forces);
    return gather(forces, -0.5);
  }
  /// -df/dy, or -df/dy' if `damping`.
  Matrix derivative(const Vectors& positions, bool damping) {
    const Eigen::Index n = 3 * particles();
    const Vectors none = zero();
    Matrix result(n, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const Vectors unit = scatter(Vector::Unit(n, k), -0.5);
      Vectors change = zero();
      addForceDerivative(workspace_, at(positions, none), damping ? none : unit,
                         damping ? unit : none, change);
      result.col(k) = -gather(change, -0.5);
    }
    return result;
  }

 private:
  Vectors zero() const { return Vectors::Zero(3, model_.masses.size()); }
  Point at(const Vectors& positions, const Vectors& velocities) const {
    return {positions, velocities, 0.0, model_.start.effects};
  }
  Model model_;
  Workspace workspace_;
  std::vector<Eigen::Index> free_;
};

/// The shape at rest that Newton's method finds from some positions; nullopt if it finds none.
std::optional<Vectors> findRest(FreeModel& free, Vectors positions) {
  const double size = (positions.rowwise().maxCoeff() - positions.rowwise().minCoeff()).norm();
  for (int iteration = 0; iteration < 20; ++iteration) {
    Matrix stiffness = free.derivative(positions, false);
    // What nothing holds, and nothing pushes, stays where it is.
    stiffness.diagonal().array() += 1e-9 * stiffness.diagonal().cwiseAbs().maxCoeff();
    const Vector step = stiffness.ldlt().solve(free.acceleration(positions));
    if (!step.allFinite()) return std::nullopt;
    const Vectors moved = free.scatter(step, -0.5);
    positions += moved;
    if (moved.cwiseAbs().maxCoeff() <= 1e-6 * size) return positions;
  }
  return std::nullopt;
}

/// Whether no spring is turned or stretched much from its place at rest.
bool isNear(const Model& model, const Vectors& rest, const Vectors& positions) {
  return std::all_of(model.springs.begin(), model.springs.end(), [&](const Spring& spring) {
    const Eigen::Vector3d at_rest = rest.col(spring.j) - rest.col(spring.i);
    const Eigen::Vector3d now = positions.col(spring.j) - positions.col(spring.i);
    return (now - at_rest).norm() <= kNear * at_rest.norm();
  });
}

std::vector<double> amplitudes(const Mode& mode, const Reference& reference, std::size_t first,
                               std::size_t frames) {
  std::vector<double> result;
  for (std::size_t n = first; n < frames; ++n) {
    result.push_back(mode.amplitude(reference.frames[n].positions));
  }
  return result;
}

bool predicted(const Mode& mode) {
  return std::abs(mode.truth.frequency - mode.linear.frequency) <=
             kPredicted * mode.linear.frequency &&
         std::abs(mode.truth.damping - mode.linear.damping) <= kPredicted &&
         mode.truth.misfit <= kPredicted;
}

}  // namespace

// A damped oscillation about a mean, sampled, obeys x[n + 1] = a x[n] - b x[n - 1] + c exactly, and
// a linear one-step scheme does so too: a = tr R, b = det R by Cayley and Hamilton.
std::optional<Oscillation> fitOscillation(const std::vector<double>& samples, double interval,
                                          std::size_t stride) {
  const std::size_t span = 2 * stride;
  if (samples.size() < span + 4) return std::nullopt;
  const auto count = static_cast<Eigen::Index>(samples.size() - span);
  const Eigen::Map<const Vector> x(samples.data(), static_cast<Eigen::Index>(samples.size()));
  const auto shift = static_cast<Eigen::Index>(stride);
  const double mean = x.mean();
  const double size = (x.array() - mean).matrix().norm() / std::sqrt(static_cast<double>(x.size()));
  if (!(size > 0.0) || !std::isfinite(size)) return std::nullopt;
  Matrix system(count, 3);
  system.col(0) = (x.segment(shift, count).array() - mean) / size;
  system.col(1) = -(x.head(count).array() - mean) / size;
  system.col(2).setOnes();
  const Vector next = (x.tail(count).array() - mean) / size;
  const Eigen::ColPivHouseholderQR<Matrix> factor(system);
  if (factor.rank() < 3) return std::nullopt;
  const Vector abc = factor.solve(next);
  using Complex = std::complex<double>;
  const Complex root = std::sqrt(Complex(abc[0] * abc[0] / 4.0 - abc[1], 0.0));
  const Complex lambda = 0.5 * abc[0] + (abc[0] < 0.0 && root.imag() == 0.0 ? -root : root);
  if (lambda == 0.0) return std::nullopt;
  const Complex s = std::log(lambda) / (interval * static_cast<double>(stride));
  Oscillation oscillation;
  oscillation.frequency = std::abs(s.imag()) / (2.0 * M_PI);
  oscillation.damping = -s.real() / std::abs(s);
  oscillation.misfit = (system * abc - next).norm() / std::sqrt(static_cast<double>(count));
  return oscillation;
}

Modes findModes(const Scene& scene, const Reference& reference, double frame_rate,
                std::size_t frames) {
  Modes result;
  const auto none = [&](const std::string& reason) {
    result.reason = reason;
    return result;
  };
  if (!scene.timeline.empty()) return none("its timeline moves it");
  FreeModel free(scene, reference.pinned);
  if (free.particles() == 0) return none("nothing is free");
  if (free.particles() > kMostParticles) {
    return none("it has more than " + std::to_string(kMostParticles) + " free particles");
  }
  // If it comes to rest, it does so late.
  Vectors mean = Vectors::Zero(3, free.model().masses.size());
  for (std::size_t n = frames / 2; n < frames; ++n) mean += reference.frames[n].positions;
  mean /= static_cast<double>(frames - frames / 2);
  const std::optional<Vectors> rest = findRest(free, mean);
  result.first = frames;
  while (rest && result.first > 0 &&
         isNear(free.model(), *rest, reference.frames[result.first - 1].positions)) {
    --result.first;
  }
  const std::size_t near = frames - result.first;
  if (2 * near < frames) return none("it does not stay near a shape at rest");

  const Matrix damping = free.derivative(*rest, true);
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(free.derivative(*rest, false));
  const Matrix& shapes = eigen.eigenvectors();
  const Vector squares = eigen.eigenvalues().cwiseMax(0.0);  // w^2; what does not swing has none
  Vector energies = Vector::Zero(squares.size());
  for (std::size_t n = result.first; n < frames; ++n) {
    const State& state = reference.frames[n];
    const Vector q = shapes.transpose() * free.gather(state.positions - *rest, 0.5);
    const Vector speed = shapes.transpose() * free.gather(state.velocities, 0.5);
    energies += 0.5 * (speed.cwiseAbs2() + squares.cwiseProduct(q.cwiseAbs2()));
  }
  const double least = 1e-9 * squares.maxCoeff();
  energies = (squares.array() > least).select(energies, 0.0);
  if (!(energies.sum() > 0.0)) return none("nothing swings");
  for (Eigen::Index k = 0; k < squares.size() && result.modes.size() < kModes; ++k) {
    Mode mode;
    mode.share = energies[k] / energies.sum();
    const double w = std::sqrt(squares[k]);
    const double ratio = 0.5 * shapes.col(k).dot(damping * shapes.col(k)) / w;
    if (!(mode.share >= kNotable) || !(ratio < 1.0)) continue;
    mode.linear.damping = ratio;
    mode.linear.frequency = w * std::sqrt(1.0 - ratio * ratio) / (2.0 * M_PI);
    const double samples = frame_rate / mode.linear.frequency;  // per period
    if (samples < kFewestSamples || samples > static_cast<double>(near)) continue;
    // A sixth of a period apart, samples differ by more than other modes leave in them.
    mode.stride = static_cast<std::size_t>(std::max(1.0, std::round(samples / 6.0)));
    mode.weights = free.scatter(shapes.col(k), 0.5);
    const auto truth = fitOscillation(amplitudes(mode, reference, result.first, frames),
                                      1.0 / frame_rate, mode.stride);
    if (!truth) continue;
    mode.truth = *truth;
    if (predicted(mode)) result.modes.push_back(std::move(mode));
  }
  if (result.modes.empty()) {
    return none("none of its modes can be told from the frames that are compared");
  }
  return result;
}

ModeErrors compare(const Modes& modes, const std::vector<std::vector<double>>& amplitudes,
                   double frame_rate) {
  ModeErrors errors;
  for (std::size_t k = 0; k < modes.modes.size(); ++k) {
    const Mode& mode = modes.modes[k];
    const auto seen = fitOscillation(amplitudes[k], 1.0 / frame_rate, mode.stride);
    if (!seen) return {INFINITY, INFINITY};
    errors.frequency =
        std::max(errors.frequency, std::abs(seen->frequency / mode.truth.frequency - 1.0));
    errors.damping = std::max(errors.damping, std::abs(seen->damping - mode.truth.damping));
  }
  return errors;
}

}  // namespace mass_spring

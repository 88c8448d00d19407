#include "solvers/direct_solver.h"

#include "solvers/ordering.h"
#include "solvers/sparse_cholesky.h"
#ifdef MASS_SPRING_WITH_CHOLMOD
#include "solvers/cholmod_cholesky.h"
#endif

namespace mass_spring {
namespace {

// Block products of one factorization per block of the matrix, up to which a band is taken without
// looking further. Ropes have 0.5, with skip-one springs 1, a chain whose links reach six others 3:
// there no order fills in less. A strip of cloth five particles wide has 12 in a band, 9.5 by
// minimum degree.
constexpr double kBandWork = 4.0;

#ifdef MASS_SPRING_WITH_CHOLMOD
// From here on CHOLMOD is faster. Measured on cloth of n x n, one thread, ms (own / CHOLMOD): n =
// 30 (109) 5.6 / 7.3, n = 50 (209) 30 / 20, n = 100 (541) 340 / 180, n = 200 (1396) 5200 / 960.
constexpr double kCholmodWork = 150.0;
#endif

}  // namespace

std::unique_ptr<DirectSolver> makeDirectSolver(LinearSolver solver,
                                               std::shared_ptr<const BlockPattern> pattern) {
  const double blocks = static_cast<double>(pattern->size() + pattern->blocks());
  if (solver != LinearSolver::kCholesky) {
    auto band = reverseCuthillMcKeeOrder(*pattern);
    if (solver == LinearSolver::kBanded || bandProducts(*pattern, band) <= kBandWork * blocks) {
      return std::make_unique<SparseCholesky>(pattern, std::move(band));
    }
  }
  auto sparse = std::make_unique<SparseCholesky>(pattern, minimumDegreeOrder(*pattern));
#ifdef MASS_SPRING_WITH_CHOLMOD
  if (sparse->blockProducts() > kCholmodWork * blocks) {
    return std::make_unique<CholmodCholesky>(pattern, sparse->blockProducts());
  }
#endif
  return sparse;
}

}  // namespace mass_spring

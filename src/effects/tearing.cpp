#include "effects/tearing.h"

#include <algorithm>
#include <cstdint>

namespace mass_spring {
namespace {

bool tooLong(const Spring& spring, double longest, const Vectors& positions) {
  if (spring.kind == SpringKind::kBending || spring.rest_length == 0.0) return false;
  const double most = longest * spring.rest_length;
  return (positions.col(spring.j) - positions.col(spring.i)).squaredNorm() > most * most;
}

/// Which particles structural springs join each with.
class Neighbors {
 public:
  Neighbors(const Model& model, const std::vector<char>& gone)
      : first_(model.particleCount() + 1, 0) {
    const auto forEachEnd = [&](auto visit) {
      for (std::size_t s = 0; s < model.springs.size(); ++s) {
        const Spring& spring = model.springs[s];
        if (spring.kind != SpringKind::kStructural || gone[s]) continue;
        visit(spring.i, spring.j);
        visit(spring.j, spring.i);
      }
    };
    forEachEnd([&](std::uint32_t i, std::uint32_t) { ++first_[i + 1]; });
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    all_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    forEachEnd([&](std::uint32_t i, std::uint32_t j) { all_[next[i]++] = j; });
  }

  /// By at most so many springs one after the other.
  bool joined(std::uint32_t i, std::uint32_t j, int springs) const {
    for (std::uint32_t n = first_[i]; n < first_[i + 1]; ++n) {
      if (all_[n] == j || (springs > 1 && joined(all_[n], j, springs - 1))) return true;
    }
    return false;
  }

 private:
  std::vector<std::uint32_t> first_, all_;
};

}  // namespace

std::vector<char> findBreaking(const TearingOptions& options, const Model& model,
                               const Vectors& positions) {
  const double longest = 1.0 + options.max_strain;
  const auto breaks = [&](const Spring& spring) { return tooLong(spring, longest, positions); };
  if (std::none_of(model.springs.begin(), model.springs.end(), breaks)) return {};
  std::vector<char> gone(model.springs.size());
  std::transform(model.springs.begin(), model.springs.end(), gone.begin(), breaks);
  const Neighbors neighbors(model, gone);
  for (std::size_t s = 0; s < gone.size(); ++s) {
    const Spring& spring = model.springs[s];
    if (spring.kind == SpringKind::kStructural) continue;
    gone[s] = gone[s] || !neighbors.joined(spring.i, spring.j, 3);
  }
  return gone;
}

}  // namespace mass_spring

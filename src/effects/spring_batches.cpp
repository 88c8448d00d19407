#include "effects/spring_batches.h"

#include <algorithm>
#include <cstdlib>
#include <tuple>

namespace mass_spring {
namespace {

// A shorter run, or one with more gaps than springs, is no faster than gathering.
constexpr std::size_t kFewestSprings = 6;
constexpr std::uint32_t kLongestGap = 8;

/// Springs of one run have the offset and the copy in common and ascend in i.
struct Candidate {
  Spring spring;
  std::int64_t offset;  // j - i
  std::uint32_t copy;   // 0 for the first spring from i to j, 1 for the second ...
};

std::vector<Candidate> sortedCandidates(const std::vector<Spring>& springs) {
  std::vector<Candidate> sorted;
  for (const Spring& s : springs) {
    if (s.stiffness > 0.0 || s.damping > 0.0) {
      sorted.push_back({s, std::int64_t{s.j} - std::int64_t{s.i}, 0});
    }
  }
  const auto key = [](const Candidate& c) { return std::make_tuple(c.offset, c.copy, c.spring.i); };
  const auto before = [&](const Candidate& a, const Candidate& b) { return key(a) < key(b); };
  std::stable_sort(sorted.begin(), sorted.end(), before);
  for (std::size_t k = 1; k < sorted.size(); ++k) {
    const Candidate& last = sorted[k - 1];
    if (last.offset == sorted[k].offset && last.spring.i == sorted[k].spring.i) {
      sorted[k].copy = last.copy + 1;
    }
  }
  std::stable_sort(sorted.begin(), sorted.end(), before);
  return sorted;
}

bool sameValues(const Spring& a, const Spring& b) {
  return a.stiffness == b.stiffness && a.damping == b.damping && a.rest_length == b.rest_length;
}

std::uint32_t roundedUp(std::size_t lanes) {
  constexpr std::size_t width = SpringBatch::kLaneWidth;
  return static_cast<std::uint32_t>((lanes + width - 1) / width * width);
}

}  // namespace

SpringBatches::SpringBatches(const std::vector<Spring>& springs) {
  const std::vector<Candidate> candidates = sortedCandidates(springs);
  for (const Candidate& c : candidates) {
    elastic_ = elastic_ || c.spring.stiffness > 0.0;
    damped_ = damped_ || c.spring.damping > 0.0;
  }
  std::vector<Spring> run, rest;
  for (std::size_t k = 0; k < candidates.size();) {
    const Candidate& first = candidates[k];
    run.clear();
    for (; k < candidates.size(); ++k) {
      const Candidate& next = candidates[k];
      if (next.offset != first.offset || next.copy != first.copy) break;
      if (next.spring.i - first.spring.i >= SpringBatch::kMaxLanes) break;
      if (!run.empty() && next.spring.i - run.back().i > kLongestGap) break;
      run.push_back(next.spring);
    }
    if (run.size() >= kFewestSprings && 2 * run.size() > run.back().i - run.front().i) {
      addRun(run);
    } else {
      rest.insert(rest.end(), run.begin(), run.end());
    }
  }
  std::stable_sort(runs_.begin(), runs_.end(),
                   [](const SpringBatch& a, const SpringBatch& b) { return a.i < b.i; });
  findRanges();
  std::stable_sort(rest.begin(), rest.end(), [](const Spring& a, const Spring& b) {
    return std::minmax(a.i, a.j) < std::minmax(b.i, b.j);
  });
  for (std::size_t k = 0; k < rest.size(); k += SpringBatch::kMaxLanes) {
    const std::size_t end = std::min<std::size_t>(rest.size(), k + SpringBatch::kMaxLanes);
    gather({rest.begin() + static_cast<std::ptrdiff_t>(k),
            rest.begin() + static_cast<std::ptrdiff_t>(end)});
  }
  for (auto* batches : {&runs_, &gathered_}) {
    for (SpringBatch& batch : *batches) {
      batch.first_lane = lanes_;
      lanes_ += batch.lanes;
    }
  }
}

void SpringBatches::findRanges() {
  std::uint32_t needed = 0;
  for (SpringBatch& run : runs_) {
    needed = std::max(needed, std::max(run.i, run.j) + run.lanes);
    run.needed = needed;
  }
  std::uint32_t finished = needed;
  for (auto run = runs_.rbegin(); run != runs_.rend(); ++run) {
    run->finished = finished;
    finished = std::min(finished, std::min(run->i, run->j));
  }
}

void SpringBatches::addRun(const std::vector<Spring>& springs) {
  const Spring& first = springs.front();
  SpringBatch batch;
  batch.i = first.i;
  batch.j = first.j;
  batch.lanes = roundedUp(springs.back().i - first.i + 1);
  batch.first_value = stiffness_.size();
  batch.uniform = std::all_of(springs.begin(), springs.end(),
                              [&](const Spring& s) { return sameValues(s, first); });
  auto next = springs.begin();
  for (std::uint32_t s = 0; s < batch.lanes; ++s) {
    const bool gap = next == springs.end() || next->i - first.i != s;
    if (gap) {
      batch.gaps.push_back(s);
    } else {
      batch.damped = batch.damped || next->damping > 0.0;
    }
    if (!batch.uniform || s == 0) addValues(gap ? Spring{} : *next);
    if (!gap) ++next;
  }
  runs_.push_back(std::move(batch));
}

void SpringBatches::gather(const std::vector<Spring>& springs) {
  SpringBatch batch;
  batch.lanes = roundedUp(springs.size());
  batch.first_value = stiffness_.size();
  for (const Spring& s : springs) {
    batch.ends_i.push_back(s.i);
    batch.ends_j.push_back(s.j);
    batch.damped = batch.damped || s.damping > 0.0;
    addValues(s);
  }
  for (std::size_t s = springs.size(); s < batch.lanes; ++s) addValues(Spring{});
  gathered_.push_back(std::move(batch));
}

void SpringBatches::addValues(const Spring& spring) {
  stiffness_.push_back(spring.stiffness);
  rest_length_.push_back(spring.rest_length);
  if (damped_) damping_.push_back(spring.damping);
}

}  // namespace mass_spring

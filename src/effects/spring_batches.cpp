#include "effects/spring_batches.h"

#include <algorithm>
#include <cstdlib>
#include <tuple>

namespace mass_spring {
namespace {

// A shorter run, or one with more gaps than springs, is no faster than gathering.
constexpr std::size_t kFewestSprings = 6;
constexpr std::uint32_t kLongestGap = 8;

bool sameValues(const Spring& a, const Spring& b) {
  return a.stiffness == b.stiffness && a.damping == b.damping && a.rest_length == b.rest_length;
}

std::uint32_t roundedUp(std::size_t lanes) {
  constexpr std::size_t width = SpringBatch::kLaneWidth;
  return static_cast<std::uint32_t>((lanes + width - 1) / width * width);
}

}  // namespace

/// Springs of one run have the offset and the copy in common and ascend in i.
struct SpringBatches::Candidate {
  Spring spring{};
  bool exists = false;
  std::int64_t offset = 0;  // j - i
  std::uint32_t copy = 0;   // 0 for the first spring from i to j, 1 for the second ...
};

std::vector<SpringBatches::Candidate> SpringBatches::sortedCandidates(
    const std::vector<Spring>& springs) {
  std::vector<Candidate> sorted;
  for (const Spring& s : springs) {
    if (s.stiffness > 0.0 || s.damping > 0.0) {
      sorted.push_back({s, true, std::int64_t{s.j} - std::int64_t{s.i}, 0});
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

SpringBatches::SpringBatches(const std::vector<Spring>& springs, bool apart) {
  const std::vector<Candidate> candidates = sortedCandidates(springs);
  for (const Candidate& c : candidates) {
    elastic_ = elastic_ || c.spring.stiffness > 0.0;
    damped_ = damped_ || c.spring.damping > 0.0;
  }
  std::vector<Candidate> run, rest;
  for (std::size_t k = 0; k < candidates.size();) {
    const Candidate& first = candidates[k];
    run.clear();
    for (; k < candidates.size(); ++k) {
      const Candidate& next = candidates[k];
      if (next.offset != first.offset || next.copy != first.copy) break;
      if (next.spring.i - first.spring.i >= SpringBatch::kMaxLanes) break;
      if (!run.empty() && next.spring.i - run.back().spring.i > kLongestGap) break;
      run.push_back(next);
    }
    if (run.size() >= kFewestSprings &&
        2 * run.size() > run.back().spring.i - run.front().spring.i) {
      addRun(run, apart);
    } else {
      rest.insert(rest.end(), run.begin(), run.end());
    }
  }
  std::stable_sort(runs_.begin(), runs_.end(),
                   [](const SpringBatch& a, const SpringBatch& b) { return a.i < b.i; });
  findRanges();
  std::stable_sort(rest.begin(), rest.end(), [](const Candidate& a, const Candidate& b) {
    return std::minmax(a.spring.i, a.spring.j) < std::minmax(b.spring.i, b.spring.j);
  });
  for (std::size_t k = 0; k < rest.size(); k += SpringBatch::kMaxLanes) {
    const std::size_t end = std::min<std::size_t>(rest.size(), k + SpringBatch::kMaxLanes);
    gather({rest.begin() + static_cast<std::ptrdiff_t>(k),
            rest.begin() + static_cast<std::ptrdiff_t>(end)},
           apart);
  }
  for (auto* batches : {&runs_, &gathered_}) {
    for (SpringBatch& batch : *batches) {
      batch.first_lane = lanes_;
      lanes_ += batch.lanes;
    }
  }
}

void SpringBatches::findRanges() {
  // Many particles at a time, so that few vectors stay unfilled.
  constexpr std::uint32_t many = SpringBatch::kMaxLanes / 2;
  std::uint32_t needed = 0;
  for (SpringBatch& run : runs_) {
    needed = std::max(needed, (std::max(run.i, run.j) + run.lanes + many - 1) / many * many);
    run.needed = needed;
  }
  std::uint32_t finished = needed;
  for (auto run = runs_.rbegin(); run != runs_.rend(); ++run) {
    run->finished = finished;
    finished = std::min(finished, std::min(run->i, run->j) / many * many);
  }
}

void SpringBatches::addRun(const std::vector<Candidate>& springs, bool apart) {
  const Spring& first = springs.front().spring;
  SpringBatch batch;
  batch.i = first.i;
  batch.j = first.j;
  batch.lanes = roundedUp(springs.back().spring.i - first.i + 1);
  batch.first_value = stiffness_.size();
  batch.uniform = !apart && std::all_of(springs.begin(), springs.end(), [&](const Candidate& c) {
    return sameValues(c.spring, first);
  });
  auto next = springs.begin();
  for (std::uint32_t s = 0; s < batch.lanes; ++s) {
    const bool gap = next == springs.end() || next->spring.i - first.i != s;
    if (gap) {
      batch.gaps.push_back(s);
    } else {
      batch.damped = batch.damped || next->spring.damping > 0.0;
    }
    if (!batch.uniform || s == 0) addValues(gap ? Candidate() : *next, apart);
    if (!gap) ++next;
  }
  runs_.push_back(std::move(batch));
}

void SpringBatches::gather(const std::vector<Candidate>& springs, bool apart) {
  SpringBatch batch;
  batch.lanes = roundedUp(springs.size());
  batch.first_value = stiffness_.size();
  for (const Candidate& c : springs) {
    batch.ends_i.push_back(c.spring.i);
    batch.ends_j.push_back(c.spring.j);
    batch.damped = batch.damped || c.spring.damping > 0.0;
    addValues(c, apart);
  }
  for (std::size_t s = springs.size(); s < batch.lanes; ++s) addValues(Candidate(), apart);
  gathered_.push_back(std::move(batch));
}

void SpringBatches::addValues(const Candidate& candidate, bool apart) {
  stiffness_.push_back(candidate.spring.stiffness);
  rest_length_.push_back(candidate.spring.rest_length);
  if (damped_) damping_.push_back(candidate.spring.damping);
  if (apart) {
    number_of_value_.push_back(candidate.exists ? candidate.spring.number : kNoSpring);
  }
}

const double* SpringBatches::gatherRestLengths(const SpringBatch& batch,
                                               const std::vector<double>& current,
                                               RestLengths& room) const {
  const std::uint32_t* const numbers = number_of_value_.data() + batch.first_value;
  for (std::uint32_t s = 0; s < batch.lanes; ++s) {
    room.values[s] = numbers[s] == kNoSpring ? 0.0 : current[numbers[s]];
  }
  return room.values;
}

}  // namespace mass_spring

#pragma once

#include <chrono>

namespace mass_spring {

/// What a wall-clock budget per step can buy: keeps the cost of one sub-step of the scheme asked
/// for and of a cheaper one, as upper values that are forgotten slowly. Results then depend on the
/// machine's speed; nothing else in the library does.
class StepBudget {
 public:
  explicit StepBudget(double seconds) : seconds_(seconds) {}

  void start() { start_ = Clock::now(); }
  /// s since start()
  double spent() const;
  double seconds() const { return seconds_; }

  /// Does one sub-step of the scheme asked for fit into a step?
  bool affordable() const { return cost_ <= kUse * seconds_; }
  /// Sub-steps that the time left in this step buys, at least 1.
  int affordableSubsteps(bool cheap, int most) const;
  void learn(bool cheap, double seconds);
  /// While the cheaper scheme is used, the memory of the other's cost fades, so that it is tried
  /// again once in some hundred steps.
  void forget() { cost_ *= kForgetting; }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr double kUse = 0.9;  // of the budget: the rest is for what no sub-step does
  static constexpr double kForgetting = 0.995;

  double seconds_;
  Clock::time_point start_;
  double cost_ = 0.0, cheap_cost_ = 0.0;  // s per sub-step
};

}  // namespace mass_spring

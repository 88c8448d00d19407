#pragma once

#include <chrono>

namespace mass_spring {

/// What a wall-clock budget per step can buy: keeps the cost of one sub-step of the scheme asked
/// for and of a cheaper one, and how far it varies. Results then depend on the machine's speed;
/// nothing else in the library does.
class StepBudget {
 public:
  explicit StepBudget(double seconds) : seconds_(seconds) {}

  void start() { start_ = Clock::now(); }
  /// s since start()
  double spent() const;
  double seconds() const { return seconds_; }

  /// Does one sub-step of the scheme asked for fit into a step?
  bool affordable() const { return asked_.upper() <= kUse * seconds_; }
  /// Sub-steps that the time left in this step buys, at least 1.
  int affordableSubsteps(bool cheap, int most) const;
  void learn(bool cheap, double seconds);
  /// One more step was left to the cheaper scheme. What the other one costs is forgotten after a
  /// while, so that it is tried again: less often each time.
  void forget();

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr double kUse = 0.9;  // of the budget: the rest is for what no sub-step does
  // 64, 256, 1024 ... steps: attempts that are too expensive stay below one in a hundred steps.
  static constexpr int kFirstPause = 64, kPauseGrowth = 4, kLongestPause = 4096;

  struct Cost {
    double mean = 0.0, deviation = 0.0;  // s per sub-step; moving averages
    double upper() const;                // that few sub-steps exceed
    void learn(double seconds);
  };

  double seconds_;
  Clock::time_point start_;
  Cost asked_, cheap_;
  int waited_ = 0, pause_ = kFirstPause;  // steps
};

}  // namespace mass_spring

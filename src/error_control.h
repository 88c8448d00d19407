#pragma once

namespace mass_spring {

/// Chooses sub-steps h / 2^level so that the estimated errors of one simulated second add up to no
/// more than the accuracy asked for: a proportional-integral controller (Gustafsson 1991; Hairer
/// and Wanner 1996, IV.2) whose steps are powers of 2, so that each frame is filled exactly.
class ErrorControl {
 public:
  static constexpr int kFinest = 12;  ///< the highest level

  /// @param accuracy  m, > 0
  /// @param order     of the estimate per unit of time: it falls as step^order
  ErrorControl(double accuracy, int order) : accuracy_(accuracy), order_(order) {}

  int level() const { return level_; }
  /// Judges a sub-step and moves the level for what follows.
  /// @param error  m, its estimate; infinite where it did not converge
  /// @return whether it may stay; always true at the finest level for a finite error
  bool accepts(double error, double substep);
  /// The last step gained energy, or could not be made: start finer.
  void refine();
  /// A sub-step twice as long must start on a multiple of its length.
  void keepAligned(bool aligned) {
    if (!aligned && coarsened_) ++level_;
    coarsened_ = false;
  }

 private:
  double accuracy_;
  int order_;
  int level_ = 0;
  double wanted_ = 0.0;  // the level as a real number, by which small changes add up
  bool coarsened_ = false;
  double ratio_before_ = 1.0;  // error / tolerance of the last accepted sub-step
};

}  // namespace mass_spring

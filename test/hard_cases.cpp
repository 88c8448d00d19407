#include "hard_cases.h"

#include <cstdio>

#include "hard_cases_checks.h"
#include "sanitizers.h"

namespace mass_spring {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

bool applies(const HardCase& row, const SchemeInfo& scheme) {
  switch (row.applies) {
    case Applies::kToNone:
      return scheme.scheme == Scheme::kImplicitEuler;
    case Applies::kToAll:
      return true;
    case Applies::kToSummers:
      return scheme.scheme != Scheme::kXpbd;
    case Applies::kToImplicit:
      return scheme.implicit;
    case Applies::kToSolvers:
      return solvesSprings(scheme.scheme);
    case Applies::kToDamping:
      return dampsWhatIsStiff(scheme.scheme);
  }
  return false;
}

/// Is a run of the sweep made? Under the sanitizers, which make everything ten times slower, only
/// the ends of each range are, and of two ends by two those on one diagonal: one or the other from
/// scheme to scheme. So it is with the two ends of a single range.
bool isMade(const HardCase& row, const SchemeInfo& scheme, double stiffness, double h) {
  if (!underSanitizers()) return true;
  const auto end = [](const std::vector<double>& values, double value) {
    return value == values.front() ? 0 : value == values.back() ? 1 : -1;
  };
  const int stiff = end(row.stiffness, stiffness), slow = end(row.steps, h);
  if (!scheme.implicit) return true;
  if (stiff < 0 || slow < 0) return false;
  if (row.stiffness.size() == 1 && row.steps.size() == 1) return true;
  return (stiff + slow + static_cast<int>(scheme.scheme)) % 2 == 0;
}

}  // namespace

const std::vector<HardCase>& hardCases() {
  using A = Applies;
  // Here, as the table is read before main().
  static const std::vector<double> kOne = {1.0};
  static const std::vector<double> kFirm = {1.0, 1e3};
  static const std::vector<double> kStiff = {1.0, 1e3, 1e6};
  static const std::vector<double> kFrame = {1.0 / 60.0};
  static const std::vector<double> kHalfSecond = {0.5};
  static const std::vector<double> kTenSeconds = {10.0};
  static const std::vector<double> kSteps = {1.0 / 60.0, 0.1, 1.0};
  // number, what it guards against and the input, what plain code does,
  // schemes, stiffness x, steps [s], step of explicit schemes [s], the check
  // clang-format off
  static const std::vector<HardCase> table = {
      { 1, "SofaPr5822_Newton1562_CoincidentEnds", "NaN, or a spring that stays dead",
       A::kToImplicit, kStiff, kSteps, 0, coincidentEnds},
      { 2, "ZeroOverZero_RestLengthZero", "0/0",
       A::kToAll, kStiff, kSteps, 0.005, restLengthZero},
      { 3, "NaN_AllParticlesAtOnePoint", "NaN",
       A::kToImplicit, kStiff, kSteps, 0, allAtOnePoint},
      { 4, "BulletReturnsRightSide_CompressedToOnePercent", "conjugate gradients break down, x = b",
       A::kToImplicit, kStiff, kSteps, 0, compressedToOnePercent},
      { 5, "HiddenIndefiniteness_FlatSheetCompressed", "an indefinite matrix, unnoticed",
       A::kToImplicit, kStiff, kSteps, 0, flatSheetCompressed},
      { 6, "Explosion_ScrambledStart", "explodes",
       A::kToImplicit, kStiff, kSteps, 0, scrambledStart},
      { 7, "Explosion_FlattenedStart", "explodes",
       A::kToImplicit, kStiff, kSteps, 0, flattenedStart},
      { 8, "StalledCg_StiffnessRatio1e8_Chain", "conjugate gradients stall",
       A::kToSolvers, kOne, kSteps, 0, stiffnessRatioInChain},
      { 8, "StalledCg_StiffnessRatio1e8_Sheet", "conjugate gradients stall",
       A::kToSolvers, kOne, kSteps, 0, stiffnessRatioInSheet},
      { 9, "Glitches_MassRatio1e6", "glitches, sags too far",
       A::kToSolvers, kOne, kSteps, 0, loadOnLightRope},
      {10, "MidpointAndRosenbrockExplode_LongStep", "explodes",
       A::kToImplicit, kStiff, kSteps, 0, longStep},
      {11, "Overflow_BillionNewtons", "overflows",
       A::kToImplicit, kStiff, kSteps, 0, billionNewtons},
      {12, "Bullet3Pr4687_PinTeleported", "blows up",
       A::kToImplicit, kStiff, kSteps, 0, pinTeleported},
      {13, "Mujoco2562_Mujoco3364_RotatedScene", "diverges in some directions",
       A::kToAll, kStiff, kFrame, 0.001, rotatedScene},
      {14, "EmptySystem_AllPinned", "crashes on an empty system",
       A::kToAll, kStiff, kSteps, 0.01, allPinned},
      {15, "Newton3451_IsolatedParticle", "NaN",
       A::kToAll, kStiff, kSteps, 0.001, isolatedParticle},
      {16, "PatternBugs_SpringBothWays", "one of the two is lost",
       A::kToSummers, kFirm, kFrame, 0.001, springBothWays},
      {17, "CoupledByOneCg_ThousandComponents", "one stopping test for all",
       A::kToSolvers, kOne, kFrame, 0, thousandComponents},
      {18, "Accepted_BadValues", "takes them",
       A::kToNone, kOne, kFrame, 0, badValuesRefused},
      {19, "PositionBasedDynamics_StiffnessZero", "rigid",
       A::kToAll, kStiff, kFrame, 0.001, stiffnessZero},
      {20, "TenThousandIterations_LongRope", "10,000 iterations",
       A::kToDamping, kOne, kTenSeconds, 0, longRope},
      {21, "RosenbrockDiverges_SpinningRing", "diverges",
       A::kToImplicit, kStiff, kSteps, 0, spinningRing},
      {22, "Drift_MillionSteps", "drifts",
       A::kToAll, kOne, kFrame, 1.0 / 60, millionSteps},
      {23, "Denormals_LongRest", "10 to 100 times slower",
       A::kToAll, kOne, kFrame, 1.0 / 60, longRest},
      {24, "WrongStop_WarmStart", "stops at the wrong place",
       A::kToSolvers, kStiff, kFrame, 0, warmStart},
      {25, "SofaCapsAt20_CappedConjugateGradients", "wrong, and silent",
       A::kToSolvers, kStiff, kSteps, 0, cappedConjugateGradients},
      {26, "Warp189_ZeroRightSide", "NaN",
       A::kToAll, kStiff, kSteps, 0.001, zeroRightSide},
      {27, "Warp642_StiffSheetInFreeFall", "explodes",
       A::kToAll, kStiff, kSteps, 0.001, stiffSheetInFreeFall},
      {28, "SofaAbsoluteThresholds_OtherUnits", "absolute thresholds trip",
       A::kToAll, kStiff, kFrame, 0.001, otherUnits},
      {29, "Newton108_HeldAtOneCorner", "spins for ever",
       A::kToDamping, kStiff, kHalfSecond, 0, heldAtOneCorner},
      {30, "Bullet4538_GripperSqueezesShut", "explodes",
       A::kToImplicit, kStiff, kSteps, 0, gripperSqueezesShut},
  };
  // clang-format on
  return table;
}

std::vector<Trial> trials(const HardCase& row) {
  std::vector<Trial> list;
  for (const SchemeInfo& scheme : schemes()) {
    if (!applies(row, scheme)) continue;
    if (!scheme.implicit && row.explicit_step == 0.0) continue;
    for (const double stiffness : scheme.implicit ? row.stiffness : std::vector<double>{1.0}) {
      for (const double h : scheme.implicit ? row.steps : std::vector<double>{row.explicit_step}) {
        if (!isMade(row, scheme, stiffness, h)) continue;
        Trial trial;
        trial.name = row.name + "." + scheme.name + "/k" + number(stiffness) + "/h" + number(h);
        trial.scheme = scheme.scheme;
        trial.stiffness = stiffness;
        trial.h = h;
        list.push_back(std::move(trial));
      }
    }
  }
  return list;
}

}  // namespace mass_spring

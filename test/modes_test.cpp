#include "tools/modes.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <complex>

#include "mass_spring_sim/scene_reader.h"
#include "stability_function.h"
#include "studies.h"
#include "tools/set_path.h"
#include "tools/study_run.h"

namespace mass_spring {
namespace {

/// The oscillation of e^(s t).
Oscillation oscillationOf(const std::complex<double>& s) {
  return {std::abs(s.imag()) / (2.0 * M_PI), -s.real() / std::abs(s)};
}

TEST(Modes, FindADampedOscillationExactly) {
  const double d = 0.7, w = 9.0, interval = 0.02;
  std::vector<double> samples;
  for (int n = 0; n < 50; ++n) {
    const double t = n * interval;
    samples.push_back(3.0 + 0.01 * std::exp(-d * t) * std::cos(w * t + 0.4));
  }
  const Oscillation truth = oscillationOf({-d, w});
  for (const std::size_t stride : {1, 5}) {
    const auto found = fitOscillation(samples, interval, stride);
    ASSERT_TRUE(found);
    // Rounding of 3 is 1e-14 of the swing, and some h w = 0.18 to the second power is taken of it.
    EXPECT_NEAR(found->frequency, truth.frequency, 1e-10);
    EXPECT_NEAR(found->damping, truth.damping, 1e-10);
    EXPECT_LT(found->misfit, 1e-12);
  }
  EXPECT_FALSE(fitOscillation(std::vector<double>(50, 3.0), interval, 1));
  samples.resize(5);
  EXPECT_FALSE(fitOscillation(samples, interval, 1));
}

TEST(Modes, ErrAsTheTheoryOfEachScheme) {
  const Study study = studyOf(kBouncing, 1.0);
  ASSERT_EQ(study.modes.modes.size(), 1u) << study.modes.reason;
  const double w2 = 50.0 / 0.1, c = 0.3 / 0.1;
  const Oscillation exact = oscillationOf({-0.5 * c, std::sqrt(w2 - 0.25 * c * c)});
  const Mode& mode = study.modes.modes[0];
  // A closed form, and a matrix of one spring: rounding, over the digits that differences cost.
  for (const Oscillation& known : {mode.linear, mode.truth}) {
    EXPECT_NEAR(known.frequency / exact.frequency, 1.0, 1e-10);
    EXPECT_NEAR(known.damping, exact.damping, 1e-10);  // the same digits
  }
  for (const SchemeInfo& scheme : schemes()) {
    for (const double rate : {60.0, 240.0}) {
      const double h = 1.0 / rate;
      std::complex<double> lambda;  // over one step
      if (const auto r = stabilityFunction(scheme.scheme, h, w2, c)) {
        lambda = r->eigenvalues()[0];
      } else {
        // bdf2: 3/2 l^2 - 2 l + 1/2 = h s l^2, and the root that tends to 1.
        ASSERT_EQ(scheme.name, "bdf2");
        const std::complex<double> s(-0.5 * c, std::sqrt(w2 - 0.25 * c * c));
        const std::complex<double> a = 1.5 - h * s;
        lambda = (2.0 + std::sqrt(4.0 - 2.0 * a)) / (2.0 * a);
      }
      const Oscillation theory = oscillationOf(std::log(lambda) * rate);
      const StudyRow row = measure(study, {scheme.scheme, rate, 1, {}, {}}, INFINITY);
      ASSERT_TRUE(row.mode_errors) << scheme.name;
      // One-step schemes obey the recurrence exactly, to Newton's tolerance and rounding. bdf2's
      // other root, about 1/3, and its first step add something for the first few frames.
      const double tolerance = scheme.name == "bdf2" ? 1e-3 : 1e-9;
      EXPECT_NEAR(row.mode_errors->frequency, std::abs(theory.frequency / exact.frequency - 1.0),
                  tolerance)
          << scheme.name << ' ' << rate;
      EXPECT_NEAR(row.mode_errors->damping, std::abs(theory.damping - exact.damping), tolerance)
          << scheme.name << ' ' << rate;
    }
  }
}

// N beads on a string of tension T, a apart: w_j = 2 sqrt(T / (a m)) sin(j pi / (2 (N + 1))).
TEST(Modes, MeetTheStringWithBeads) {
  const int n = 9;
  const double a = 0.1, m = 0.01, k = 100.0, rest_length = 0.09;
  std::string positions, springs;
  for (int i = 0; i <= n + 1; ++i) {
    const double phase = M_PI * i / (n + 1);
    const double y = i <= n ? 1e-4 * std::sin(phase) + 5e-5 * std::sin(2.0 * phase) : 0.0;
    positions += (i ? ", [" : "[") + std::to_string(a * i) + ", " + std::to_string(y) + ", 0.0]";
    if (i <= n) {
      springs += (i ? ", [" : "[") + std::to_string(i) + ", " + std::to_string(i + 1) + "]";
    }
  }
  std::ostringstream scene;
  scene << "{rate: 60.0, solver: {threads: 1, newton_tolerance: 1.0e-10}, objects: {string: {type: "
           "particles, positions: ["
        << positions << "], springs: [" << springs << "], masses: " << m << ", stiffness: " << k
        << ", rest_lengths: " << rest_length << "}}, pins: {ends: {object: string, particles: [0, "
        << n + 1 << "]}}}";
  const Study study = studyOf(scene.str(), 1.0);
  ASSERT_GE(study.modes.modes.size(), 2u) << study.modes.reason;
  double shares[2] = {};
  double largest = 0.0;  // error of implicit_midpoint: tan(w' h / 2) = w h / 2
  for (const Mode& mode : study.modes.modes) {
    // Across the string each mode is there twice, in any two directions.
    const int j = 2.0 * M_PI * mode.linear.frequency < 15.0 ? 1 : 2;
    const double w =
        2.0 * std::sqrt(k * (a - rest_length) / (a * m)) * std::sin(j * M_PI / (2.0 * (n + 1)));
    EXPECT_NEAR(2.0 * M_PI * mode.linear.frequency / w, 1.0, 1e-9);  // rest to 1e-6, squared
    // The tension grows by k / T = 10 / a^2 times the squared slope, (1e-4 pi / 1)^2 = 1e-7.
    EXPECT_NEAR(2.0 * M_PI * mode.truth.frequency / w, 1.0, 1e-5);
    EXPECT_NEAR(mode.truth.damping, 0.0, 1e-5);
    shares[j - 1] += mode.share;
    largest = std::max(largest, 1.0 - 120.0 * std::atan(w / 120.0) / w);
  }
  for (const double share : shares) EXPECT_NEAR(share, 0.5, 0.02);  // (j times half) squared
  const StudyRow row = measure(study, {Scheme::kImplicitMidpoint, 60.0, 1, {}, {}}, INFINITY);
  ASSERT_TRUE(row.mode_errors);
  EXPECT_NEAR(row.mode_errors->frequency, largest, 2e-5);  // both as above
  EXPECT_NEAR(row.mode_errors->damping, 0.0, 2e-5);
}

TEST(Modes, AreThoseNearRestOnly) {
  EXPECT_NE(studyOf(kPendulum, 1.0).modes.reason, "");  // it swings by a right angle
  // Let go far off, it comes near: what it swings by falls by e^-5 in a second.
  Tree tree = readYamlText(kBouncing, "bouncing");
  setPath(tree, "objects.bob.positions.1=[0.0, 0.0, 0.8]");
  setPath(tree, "objects.bob.damping=1.0");
  const Study study = studyOf(readScene(tree, ""), 1.0);
  EXPECT_EQ(study.modes.modes.size(), 1u) << study.modes.reason;
  EXPECT_GT(study.modes.first, 5u);
}

}  // namespace
}  // namespace mass_spring

#include "tools/reference.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mass_spring_sim/measures.h"
#include "mass_spring_sim/scene_reader.h"
#include "studies.h"
#include "tools/closed_form.h"
#include "tools/set_path.h"
#include "tools/study_end.h"

namespace mass_spring {
namespace {

TEST(Reference, EndsItsHorizonWhereTwoStartsPart) {
  Reference reference;
  reference.spread = {1e-9, 1e-6, 1e-4, 1e-5, 1e-2};
  EXPECT_EQ(reference.horizon(1e-4), 2u);  // what falls again does not bring knowledge back
  EXPECT_EQ(reference.horizon(1.0), 5u);
  EXPECT_EQ(reference.horizon(1e-10), 0u);
}

// A triple pendulum forgets its start within seconds.
constexpr const char* kTriplePendulum = R"(
rate: 60.0
solver: {scheme: tr_bdf2, threads: 1}
objects:
  chain:
    type: particles
    positions: [[0.0, 0.0, 0.0], [0.1, 0.0, 0.02], [0.2, 0.01, 0.0], [0.3, 0.0, 0.05]]
    masses: 0.1
    springs: [[0, 1], [1, 2], [2, 3]]
    stiffness: 300.0
pins: {nail: {object: chain, particles: [0]}}
effects: {gravity: {acceleration: [0.0, 0.0, -9.81]}}
)";

TEST(End, TellsTheSpreadOfStartsBeyondTheHorizon) {
  Study study = studyOf(kTriplePendulum, 8.0);
  const Reference& reference = study.reference;
  ASSERT_LT(reference.horizon(1e-3), reference.frames.size());
  ASSERT_EQ(reference.ends.size(), kStarts);
  for (std::size_t a = 0; a < kStarts; ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      EXPECT_GT(reference.distance(reference.ends[a].positions, reference.ends[b].positions), 1e-3);
    }
  }
  StudyRow row;
  row.setting = {Scheme::kRk4, 60.0, 1, {}, {}};
  row.status = "converged";
  row.end_height = 100.0;
  EXPECT_NE(endText(study, {row}).find("| rk4, 60 Hz | "), std::string::npos);
  EXPECT_NE(endText(study, {row}).find(" m | no |"), std::string::npos);
  row.end_height = meanHeight(study.scene, reference.ends[0]);
  row.end_energy = energy(buildModel(study.scene), reference.ends[0]).total();
  EXPECT_EQ(endText(study, {row}).find("| no |"), std::string::npos);  // it is one of them
  study = studyOf(kBouncing, 0.2);
  EXPECT_EQ(study.reference.ends.size(), 1u);
}

TEST(End, KnowsTheStatisticsOfAFew) {
  const Statistics some = statistics({1.0, 2.0, 3.0, 6.0});
  EXPECT_DOUBLE_EQ(some.mean, 3.0);
  EXPECT_DOUBLE_EQ(some.deviation, std::sqrt(14.0 / 3.0));
  EXPECT_DOUBLE_EQ(some.deviations(3.0), 0.0);
  EXPECT_DOUBLE_EQ(some.deviations(3.0 - 2.0 * some.deviation), -2.0);
  EXPECT_LT(usualDeviations(4), usualDeviations(3));
}

// Three particles on their own: one on a damped spring, one overdamped and thrown, one that falls.
TEST(ClosedForm, AgreesWithRk4) {
  constexpr const char* kScene = R"(
rate: 50.0
objects:
  net:
    type: particles
    positions: [[0.0, 0.0, 1.0], [0.0, 0.0, 0.7], [1.0, 0.0, 1.0], [1.0, 0.0, 0.6], [2.0, 0.0, 0.0]]
    velocities: [[0, 0, 0], [0, 0, 0.2], [0, 0, 0], [0, 0, -0.5], [1.0, 0.0, 2.0]]
    masses: 0.1
    springs: [[0, 1], [3, 2]]
    stiffness: 50.0
    damping: [0.3, 9.0]
    rest_lengths: 0.35
pins: {nails: {object: net, particles: [0, 2]}}
effects: {gravity: {acceleration: [0.0, 0.0, -9.81]}}
)";
  const Tree tree = readYamlText(kScene, "net");
  ReferenceOptions options;
  options.duration = 1.0;
  options.frame_rate = 50.0;
  const Reference reference = findReference(readScene(tree, ""), options);
  ASSERT_TRUE(reference.exact);
  ASSERT_EQ(reference.frames.size(), 50u);
  // h = 1/2000 s at 22 rad/s, and 90 1/s: (h w)^4 = 1e-8 and 4e-6 of some centimeters, decaying.
  EXPECT_LT(reference.largestDoubt(50), 1e-9);
  EXPECT_GT(reference.distance(reference.frames[0].positions, reference.frames[9].positions), 0.01);
  // Whatever couples particles, or acts across a spring, has none.
  for (const char* change :
       {"objects.net.springs=[[0, 1], [1, 3]]", "objects.net.springs=[[0, 1], [3, 4]]",
        "effects.gravity.acceleration=[1.0, 0.0, -9.81]", "objects.net.rest_lengths=0.0"}) {
    Tree other = tree;
    setPath(other, change);
    EXPECT_FALSE(closedForm(readScene(other, ""), {0.1})) << change;
  }
}

}  // namespace
}  // namespace mass_spring

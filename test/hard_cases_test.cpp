#include "hard_cases.h"

#include <gtest/gtest.h>

#include "sanitizers.h"

// Every row of the table, with every scheme and every parameter, is a test of its own:
// Row.scheme/stiffness/step.
namespace mass_spring {
namespace {

class HardCaseTest : public testing::Test {
 public:
  HardCaseTest(const HardCase& row, Trial trial) : row_(row), trial_(std::move(trial)) {}

  void TestBody() override {
    Trial again = trial_;
    row_.run(trial_);
    // The sanitizers would see in a second run what they saw in the first.
    if (HasFailure() || underSanitizers()) return;
    row_.run(again);
    EXPECT_EQ(trial_.fingerprint, again.fingerprint) << "other bytes on the second run";
  }

 private:
  const HardCase& row_;
  Trial trial_;
};

const bool hard_cases_registered = [] {
  for (const HardCase& row : hardCases()) {
    for (const Trial& trial : trials(row)) {
      testing::RegisterTest(
          row.name.c_str(), trial.name.substr(row.name.size() + 1).c_str(), nullptr, nullptr,
          __FILE__, __LINE__,
          [&row, trial]() -> testing::Test* { return new HardCaseTest(row, trial); });
    }
  }
  return true;
}();

TEST(HardCases, AreSeveralHundredRunsOfThirtyCases) {
  EXPECT_TRUE(hard_cases_registered);
  std::vector<char> seen(31, 0);
  std::size_t runs = 0;
  for (const HardCase& row : hardCases()) {
    seen.at(static_cast<std::size_t>(row.number)) = 1;
    runs += trials(row).size();
  }
  for (int number = 1; number <= 30; ++number) EXPECT_TRUE(seen[number]) << number;
  if (!underSanitizers()) {
    EXPECT_GE(runs, 300u);
  }
}

}  // namespace
}  // namespace mass_spring

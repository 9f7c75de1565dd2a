// Pitch error and backlash in a line description.
#include <gmock/gmock.h>

#include <string>
#include <utility>

#include "driveline/motion/axis/axis_compensation.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::runtime {
namespace {

class CompensationConfig : public test::TemporaryDirectory {
 protected:
  void SetUp() override {
    TemporaryDirectory::SetUp();
    write(directory / "flat.csv", "position[mm],correction[um]\n0,0\n500,20\n1000,0\n");
    write(directory / "steep.csv", "position[mm],correction[um]\n0,0\n1,0\n2,900\n");
    write(directory / "bent.csv", "position[mm],correction[um]\n0,0\n5,50\n10,0\n15,50\n20,0\n");
    write(directory / "angle.csv", "position[deg],correction[deg]\n0,0\n360,0.01\n");
  }
  [[nodiscard]] Result<LineConfig> config_of(const std::string& rest) {
    return parse_line_config(
        "[[slave]]\nname = \"x\"\n[[axis]]\nname = \"x\"\nfeed_mm_per_revolution = 10\nunit = \"mm\"\n"
        "max_velocity = 500\nmax_acceleration = 5000\n" +
            rest,
        directory / "line.toml");
  }
  [[nodiscard]] std::string sentence(const std::string& rest) {
    const auto config = config_of(rest);
    return config ? "" : describe(config.error()).substr((directory / "line.toml").string().size());
  }
};

TEST_F(CompensationConfig, LeavesTheMotionsWhatItDoesNotNeedOfTheLimits) {
  const auto config = must(config_of("compensation = \"flat.csv\"\nbacklash = 0.02\nbacklash_velocity = 20\n"));
  const auto& axis = config->axes.front();
  ASSERT_TRUE(axis.compensation);
  EXPECT_DOUBLE_EQ(axis.compensation->take_up_velocity, 0.02);
  EXPECT_DOUBLE_EQ(axis.compensation->take_up_acceleration, 0.5) << "a tenth of the limit";
  EXPECT_FALSE(axis.compensation->when_homed);
  EXPECT_NEAR(axis.limits.max_velocity, 0.48, 1e-4);
  EXPECT_LT(axis.limits.max_velocity, 0.48);
  EXPECT_NEAR(axis.limits.max_acceleration, 4.5, 2e-3);
  EXPECT_LT(axis.limits.max_acceleration, 4.5);
  EXPECT_NEAR(axis.compensation->correction.drive(0.5, 0.0).position, 0.5 + 20e-6 - 20e-6, 1e-12);
}

TEST_F(CompensationConfig, WithoutItNothingIsDifferent) {
  const auto config = must(config_of(""));
  EXPECT_FALSE(config->axes.front().compensation);
  EXPECT_DOUBLE_EQ(config->axes.front().limits.max_velocity, 0.5);
}

TEST_F(CompensationConfig, BadInputHasOneSentence) {
  const auto path = (directory / "").string();
  const std::pair<std::string, std::string> cases[] = {
      {"compensation = \"none.csv\"\n",
       ":9: [axis 1] compensation: " + path + "none.csv: cannot be read: No such file or directory"},
      {"compensation = \"angle.csv\"\n",
       ":9: [axis 1] compensation: " + path + "angle.csv is in deg, but the axis is linear"},
      {"backlash = -1\n", ":9: [axis 1] backlash: is -1, 0 to 1000 is expected"},
      {"backlash = 0.02\nbacklash_velocity = 251\n",
       ":10: [axis 1] backlash_velocity: is 251, 1e-09 to 250 is expected"},
      {"backlash_velocity = 5\n", ":9: [axis 1] backlash_velocity: has no effect without compensation or backlash"},
      {"compensate = \"homed\"\n", ":9: [axis 1] compensate: has no effect without compensation or backlash"},
      {"backlash = 0.02\ncompensate = \"never\"\n",
       ":10: [axis 1] compensate: is \"never\", one of \"always\", \"homed\" is expected"},
      {"backlash = 0.02\ncompensate = \"homed\"\n[path]\nfile = \"p.csv\"\n",
       ":3: axis: \"x\" is compensated only after homing, and axes of a [path] are not homed: compensate = \"always\" "
       "is "
       "expected"},
  };
  for (const auto& [rest, wanted] : cases) EXPECT_EQ(sentence(rest), wanted);
  const std::string begin = ":9: [axis 1] compensation: ";
  EXPECT_THAT(sentence("compensation = \"steep.csv\"\n"),
              testing::StartsWith(begin + path + "steep.csv:3: the correction has a slope of "));
  EXPECT_THAT(sentence("compensation = \"bent.csv\"\n"),
              testing::StartsWith(begin + "is so curved that at max_velocity it needs "));
}

}  // namespace
}  // namespace driveline::runtime

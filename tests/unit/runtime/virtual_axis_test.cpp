// [[virtual_axis]] of a line description, and a line with one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/line.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::runtime {
namespace {

using testing::HasSubstr;

const std::string kDrive = "[[slave]]\nname = \"x\"\n[[axis]]\nname = \"x\"\n";
const std::string kVirtual = "[[virtual_axis]]\nname = \"belt\"\n";
const std::string kLimits = "max_velocity = 500\nmax_acceleration = 2000\n";

auto parsed(const std::string& behind) {
  return parse_line_config(kDrive + behind, "line.toml");
}

std::string refusal(const std::string& behind) {
  const auto config = parsed(behind);
  return config ? std::string{} : describe(config.error());
}

class VirtualAxisConfig : public test::TemporaryDirectory {};

TEST_F(VirtualAxisConfig, HasANameAUnitAndLimits) {
  const auto config =
      must(parsed(kVirtual + "unit = \"mm\"\nmin_position = -10\nmax_position = 90\n" + kLimits + "max_jerk = 8e4\n"));
  ASSERT_EQ(config->axes.size(), 2U);
  const auto& axis = config->axes[1];
  EXPECT_TRUE(axis.is_virtual());
  EXPECT_FALSE(config->axes[0].is_virtual());
  EXPECT_EQ(axis.name, "belt");
  EXPECT_TRUE(axis.linear());
  EXPECT_DOUBLE_EQ(axis.limits.max_velocity, 0.5);
  EXPECT_DOUBLE_EQ(axis.limits.max_acceleration, 2.0);
  EXPECT_DOUBLE_EQ(axis.max_jerk.value(), 80.0);
  EXPECT_DOUBLE_EQ(axis.software_limits->max, 0.09);
  EXPECT_FALSE(parsed(kVirtual + kLimits)->axes[1].linear()) << "rad, without a unit";
}

TEST_F(VirtualAxisConfig, RefusesWhatCannotBe) {
  EXPECT_THAT(refusal(kVirtual), HasSubstr("line.toml:5: [virtual_axis 1] max_velocity: is missing"));
  EXPECT_THAT(refusal(kVirtual + "max_velocity = 0\n"), HasSubstr("line.toml:7: [virtual_axis 1] max_velocity"));
  EXPECT_THAT(refusal(kVirtual + "max_velocity = nan\n"), HasSubstr("line.toml:7: [virtual_axis 1] max_velocity"));
  EXPECT_THAT(refusal(kVirtual + kLimits + "unit = \"inch\"\n"),
              HasSubstr("line.toml:9: [virtual_axis 1] unit: is \"inch\""));
  EXPECT_THAT(refusal(kVirtual + kLimits + "slave = \"x\"\n"), HasSubstr("slave: unknown key"));
  EXPECT_THAT(refusal("[[virtual_axis]]\nname = \"x\"\n" + kLimits), HasSubstr("line.toml:6: [virtual_axis 1] name"));
  EXPECT_THAT(refusal(kVirtual + kLimits + "[path]\nfile = \"p.csv\"\n"), HasSubstr("remove [path]"));
}

/// Requests a motion of the virtual axis when the line is in operation.
class Mover final : public Observer {
 public:
  explicit Mover(Line& line) : line_(line) {}
  void poll() override {
    const auto status = line_.axes().status(1);
    if (!status.report) return;
    if (status.report->state == motion::PlcopenState::kStandstill && !asked) {
      motion::AxisRequest request;
      request.command = motion::AxisCommand::kMoveAbsolute;
      request.target_si = 0.02;
      AxisCaller caller;
      caller.name = "test";
      asked = line_.axes().submit(caller, 1, request).has_value();
    }
    place = status.report->position;
  }
  bool asked = false;
  double place = 0.0;

 private:
  Line& line_;
};

TEST_F(VirtualAxisConfig, ALineRunsWithOne) {
  auto config = must(parsed(kVirtual + "unit = \"mm\"\n" + kLimits));
  config->output.directory = directory / "out";
  config->output.plots = false;
  Line::Options options;
  options.virtual_time = true;
  auto line = must(Line::from_config(std::move(*config), options));
  Mover mover(**line);
  (*line)->observe(mover);
  Line::RunSettings settings;
  settings.duration_s = 0.6;
  const auto report = must((*line)->run(settings));
  EXPECT_EQ(report->failure(), nullptr);
  EXPECT_TRUE(mover.asked);
  EXPECT_NEAR(mover.place, 0.02, 1e-9);
  ASSERT_EQ(report->axes.size(), 2U);
  EXPECT_EQ(report->axes[0].slave, 0U);
  EXPECT_FALSE(report->axes[1].slave);
  EXPECT_NEAR(report->axes[1].following_error_max, 0.0, 1e-3);
}

/// Couples x to the virtual axis and y to the encoder that reads x, then moves the virtual axis.
class Coupler final : public Observer {
 public:
  explicit Coupler(Line& line) : line_(line) {}
  void poll() override {
    for (std::size_t axis = 0; axis < last.size(); ++axis) last[axis] = line_.axes().status(axis);
    const bool ready = last[0].report && std::all_of(last.begin(), last.end(), [](const AxisStatus& one) {
                         return one.report->state != motion::PlcopenState::kDisabled;
                       });
    // The filter of the encoder must have settled.
    if (!ready || ++looks_ < 20) return;
    AxisCaller caller;
    caller.name = "test";
    if (looks_ == 20) {
      CouplingOrder order;
      order.text = "gear-in";
      order.ratio = trajectory::GearRatio::make(1, 2).value();
      coupled = line_.axes().submit(caller, 0, order).has_value();
      order.ratio = trajectory::GearRatio::make(-1, 1).value();
      coupled = line_.axes().submit(caller, 1, order).has_value() && coupled;
      if (const auto refused = line_.axes().submit(caller, 2, order); !refused) no_master = refused.error().why;
      for (std::size_t axis = 0; axis < 2; ++axis) first[axis] = last[axis].report->position;
    }
    if (looks_ == 30) {
      motion::AxisRequest request;
      request.command = motion::AxisCommand::kMoveAbsolute;
      request.target_si = 3.0;
      static_cast<void>(line_.axes().submit(caller, 2, request));
    }
  }
  std::array<AxisStatus, 3> last;
  std::array<double, 2> first{};
  bool coupled = false;
  AxisRefusal::Why no_master = AxisRefusal::Why::kNotRunning;

 private:
  Line& line_;
  int looks_ = 0;
};

class CoupledLine : public test::TemporaryDirectory {};

TEST_F(CoupledLine, GearsOfADescriptionFollowAVirtualAxisAndAnEncoder) {
  auto config = must(parse_line_config(
      kDrive + "[[slave]]\nname = \"y\"\n[[axis]]\nname = \"y\"\n" + kVirtual +
          "max_velocity = 20\nmax_acceleration = 200\n[[encoder]]\nname = \"wheel\"\nposition = \"x.6064h\"\n"
          "increments_per_revolution = 1048576\nmax_velocity = 50\n[[coupling]]\nslave = \"x\"\nmaster = \"belt\"\n"
          "[[coupling]]\nslave = \"y\"\nmaster = \"wheel\"\n",
      "line.toml"));
  config->output.directory = directory / "out";
  config->output.plots = false;
  Line::Options options;
  options.virtual_time = true;
  auto line = must(Line::from_config(std::move(*config), options));
  Coupler coupler(**line);
  (*line)->observe(coupler);
  Line::RunSettings settings;
  settings.duration_s = 2.0;
  const auto report = must((*line)->run(settings));
  EXPECT_EQ(report->failure(), nullptr);
  EXPECT_TRUE(coupler.coupled);
  EXPECT_EQ(coupler.no_master, AxisRefusal::Why::kNoMaster);
  for (std::size_t slave = 0; slave < 2; ++slave) {
    ASSERT_TRUE(coupler.last[slave].coupling);
    EXPECT_EQ(coupler.last[slave].coupling->state, trajectory::CouplingState::kInSync) << slave;
  }
  EXPECT_EQ(coupler.last[0].coupling->master, "belt");
  EXPECT_EQ(coupler.last[1].coupling->master, "wheel");
  EXPECT_NEAR(coupler.last[2].report->position, 3.0, 1e-9);
  const double way = coupler.last[0].report->position - coupler.first[0];
  EXPECT_NEAR(way, 1.5, 1e-4);
  EXPECT_NEAR(coupler.last[1].report->position - coupler.first[1], -way, 1e-3);
}

}  // namespace
}  // namespace driveline::runtime

// Seven-segment display (MSD manual 4.7, 5.6) and LEDs (5.3) as functions of time.
#include "driveline/slaves/msd/indicators.hpp"

#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

std::string shown(const DisplayContent& content, std::chrono::nanoseconds time) {
  return to_text(display_frame(content, time));
}

TEST(Display, ResetAndStart) {
  EXPECT_EQ(shown({.reset = true, .starting = true}, 0ms), "8.8.");
  EXPECT_EQ(shown({.starting = true}, 0ms), " 0");
}

TEST(Display, StatesOneToSeven) {
  for (int state = 1; state <= 7; ++state) {
    const DisplayContent content{.state = static_cast<PowerState>(state)};
    const std::string digit(1, static_cast<char>('0' + state));
    const bool active = state >= 4;
    EXPECT_EQ(shown(content, 0ms), " " + digit + (active ? "." : ""));
    EXPECT_EQ(shown(content, 499ms), " " + digit + (active ? "." : ""));
    EXPECT_EQ(shown(content, 500ms), " " + digit) << "the dot flashes";
    EXPECT_EQ(shown(content, 1000ms), " " + digit + (active ? "." : ""));
  }
}

TEST(Display, SFlashesWhileSafeTorqueOffIsActive) {
  const DisplayContent content{.state = PowerState::kSwitchOnDisabled, .safe_torque_off = true};
  EXPECT_EQ(shown(content, 0ms), "S.2");
  EXPECT_EQ(shown(content, 500ms), " 2");
  EXPECT_EQ(shown(content, 1000ms), "S.2");
}

TEST(Display, FaultIsErNumberLocationAgainAndAgain) {
  DisplayContent content{.state = PowerState::kFault};
  content.fault = DisplayContent::FaultCode{2, 5, false};
  for (int round = 0; round < 3; ++round) {
    const auto start = std::chrono::milliseconds(round * 3000);
    EXPECT_EQ(shown(content, start), "Er");
    EXPECT_EQ(shown(content, start + 1000ms), "02");
    EXPECT_EQ(shown(content, start + 2000ms), "05");
  }
  content.fault = DisplayContent::FaultCode{14, 1, true};
  EXPECT_EQ(shown(content, 0ms), "Er.") << "with a point: only after the cause is gone";
  EXPECT_EQ(shown(content, 1000ms), "14");
  EXPECT_EQ(shown(content, 2000ms), "01");
}

/// Share of the time the LED is lit and how often it is switched on, in 12 s.
std::pair<double, int> watch_led(auto&& led) {
  int lit = 0;
  int flashes = 0;
  bool before = false;
  for (int ms = 0; ms < 12000; ++ms) {
    const bool now = led(std::chrono::milliseconds(ms));
    lit += now ? 1 : 0;
    flashes += now && !before ? 1 : 0;
    before = now;
  }
  return {lit / 12000.0, flashes};
}

TEST(RunLed, ShowsTheAlState) {
  const auto in = [](AlState state) { return watch_led([state](auto time) { return run_led(state, time); }); };
  EXPECT_EQ(in(AlState::kInit), std::pair(0.0, 0));
  EXPECT_EQ(in(AlState::kPreOp), std::pair(0.5, 30)) << "200 ms on, 200 ms off";
  EXPECT_EQ(in(AlState::kSafeOp), std::pair(2000.0 / 12000.0, 10)) << "single flash: 200 ms on, 1 s off";
  EXPECT_EQ(in(AlState::kOp), std::pair(1.0, 1));
}

TEST(LinkActivityLed, OffOnAndFlashing) {
  const auto with = [](LinkState link) {
    return watch_led([link](auto time) { return link_activity_led(link, time); });
  };
  EXPECT_EQ(with({.link = false, .traffic = true}), std::pair(0.0, 0));
  EXPECT_EQ(with({.link = true}), std::pair(1.0, 1));
  EXPECT_EQ(with({.link = true, .traffic = true}), std::pair(0.5, 120));
}

TEST(BottomLed, IsRunAtX15NothingAtX16AndLinkOnTheCompact) {
  const auto at = [](Series series, Connector connector, LinkState link, AlState state) {
    return watch_led([=](auto time) { return bottom_led(series, connector, link, state, time); });
  };
  const LinkState traffic{true, true};
  EXPECT_EQ(at(Series::kSingleMultiAxis, Connector::kX15, traffic, AlState::kPreOp), std::pair(0.5, 30));
  EXPECT_EQ(at(Series::kSingleMultiAxis, Connector::kX16, traffic, AlState::kOp), std::pair(0.0, 0));
  for (const auto connector : {Connector::kX15, Connector::kX16}) {
    EXPECT_EQ(at(Series::kCompact, connector, traffic, AlState::kInit), std::pair(1.0, 1));
    EXPECT_EQ(at(Series::kCompact, connector, {}, AlState::kOp), std::pair(0.0, 0));
  }
}

TEST(MsdDisplay, StartsWithResetAndZero) {
  MsdParameters parameters;
  parameters.start_up_time = 40ms;
  MsdDrive device(parameters);
  const DriveCore& drive = device.core();
  std::chrono::nanoseconds now{0};
  const auto after = [&](std::chrono::nanoseconds time) {
    now += time;
    device.advance(now);
    return to_text(drive.display_now());
  };
  EXPECT_EQ(after(0ms), "8.8.");
  EXPECT_EQ(after(10ms), "8.8.");
  EXPECT_EQ(after(20ms), " 0");
  EXPECT_EQ(drive.state(), PowerState::kNotReadyToSwitchOn);
  EXPECT_EQ(after(20ms), " 2");
}

TEST(MsdDisplay, FollowsTheDriveInTime) {
  OperatingRig rig;
  EXPECT_TRUE(rig.device.run_led_now());
  rig.enable(9);
  const auto dots = watch_led([&](auto) {
    rig.pass(1ms);
    return rig.drive.display_now().second.point;
  });
  EXPECT_NEAR(dots.second, 12, 1) << "once per second";
  rig.device.fall_back(AlState::kOp, AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
  rig.pass(1s);
  ASSERT_EQ(rig.drive.state(), PowerState::kFault);
  std::vector<std::string> sequence;
  for (int ms = 0; ms < 6000; ++ms) {
    rig.pass(1ms);
    const auto now = to_text(rig.drive.display_now());
    if (sequence.empty() || sequence.back() != now) sequence.push_back(now);
  }
  EXPECT_THAT(std::vector(sequence.begin() + 1, sequence.begin() + 6),
              testing::IsSupersetOf({std::string("Er"), std::string("14"), std::string("01")}));
}

}  // namespace
}  // namespace driveline::slaves::msd

// [dc] and the `dc` tables of the slaves, from the file to the plan of the clocks.
#include <gtest/gtest.h>

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/setup/clock_plan.hpp"
#include "driveline/slaves/msd/core/variant.hpp"
#include "support/must.hpp"

namespace driveline::runtime {
namespace {

using ecat_master::dc::FollowMode;
using std::chrono::microseconds;
using std::chrono::nanoseconds;

LineConfig parse(const std::string& text) {
  auto config = parse_line_config(text, "line.toml");
  if (!config) throw std::runtime_error(describe(config.error()));
  return *config;
}

std::string refusal(const std::string& text) {
  const auto config = parse_line_config(text, "line.toml");
  return config ? std::string{} : describe(config.error());
}

/// Slaves as found, with the operation modes of a drive in their EEPROMs.
std::vector<ecat_master::ConfiguredSlave> found(std::size_t count) {
  esi::DcOpMode sync;
  sync.name = "DC-Synchronous";
  sync.assign_activate = 0x0300;
  sync.cycle_time_sync0_factor = 1;
  esi::DcOpMode half;
  half.name = "Half";
  half.assign_activate = 0x0300;
  half.cycle_time_sync0_factor = -2;
  std::vector<ecat_master::ConfiguredSlave> slaves(count);
  for (auto& slave : slaves) slave.info.description.dc_modes = {sync, half};
  return slaves;
}

TEST(ClockConfig, WithoutItTheDrivesRunFree) {
  EXPECT_FALSE(parse("[[slave]]\nname = \"x\"\n").clocks);
}

TEST(ClockConfig, DefaultsAreTheFirstClockAndHalfAPeriod) {
  const auto config = parse("[line]\ncycle_us = 250\n[dc]\n[[slave]]\nname = \"x\"\n");
  ASSERT_TRUE(config.clocks);
  EXPECT_EQ(config.clocks->mode, FollowMode::kMasterFollows);
  EXPECT_FALSE(config.clocks->reference);
  EXPECT_EQ(config.clocks->frame_lead, microseconds{125});
  const auto plan = must(make_clock_plan(config, found(1)));
  EXPECT_EQ(plan->slaves.at(0).signals.sync0_cycle, microseconds{250});
  EXPECT_EQ(plan->slaves.at(0).signals.assign_activate, 0x0300);
  EXPECT_EQ(plan->slaves.at(0).base, microseconds{125});
}

TEST(ClockConfig, WhoIsFoundByItsAliasHasItsSignalsWhereverItIs) {
  const auto config = parse(
      "[dc]\nreference = \"b\"\n[[slave]]\nname = \"a\"\nalias = 7\nhot_connect = true\n"
      "[slave.dc]\nsync0_shift_us = 20\n[[slave]]\nname = \"b\"\n");
  auto slaves = found(2);
  for (auto& slave : slaves) {
    slave.info.description.vendor_id = slaves::msd::kVendorId;
    slave.info.description.product_code = slaves::msd::facts(slaves::msd::Variant::kMsd).product_code;
  }
  slaves[1].info.alias = 7;
  const auto plan = must(make_clock_plan(config, slaves));
  EXPECT_EQ(plan->reference, 0);
  EXPECT_EQ(plan->slaves.at(0).signals.sync0_shift, microseconds{0});
  EXPECT_EQ(plan->slaves.at(1).signals.sync0_shift, microseconds{20});
}

TEST(ClockConfig, WhoJoinsLaterGetsItsSignalsThen) {
  const auto config = parse(
      "[dc]\n[[slave]]\nname = \"b\"\n[[slave]]\nname = \"a\"\nalias = 7\nhot_connect = true\n"
      "[slave.dc]\nop_mode = \"Half\"\n");
  const auto plan = must(make_clock_plan(config, found(1)));
  const auto joining = must(plan->joining(1, found(1).front().info.description));
  EXPECT_EQ(joining->signals.sync0_cycle, std::chrono::nanoseconds{62'500});
  EXPECT_FALSE(plan->joining(1, {})) << "a description without that mode";
}

TEST(ClockConfig, TheTimeToShowAndTheControllersOfTheSlaves) {
  const auto with = [](const std::string& time) {
    return parse("[dc]\n" + time + "[[slave]]\nname = \"x\"\ndc = { processing_extra_ns = 17.5 }\n");
  };
  EXPECT_EQ(make_clock_plan(with(""), found(1))->time, nullptr);
  EXPECT_EQ(make_clock_plan(with("time = \"monotonic\"\n"), found(1))->time, nullptr);
  const auto utc = make_clock_plan(with("time = \"system\"\n"), found(1));
  const auto tai = make_clock_plan(with("time = \"tai\"\n"), found(1));
  ASSERT_NE(utc->time, nullptr);
  ASSERT_NE(tai->time, nullptr);
  EXPECT_NE(utc->time, tai->time);
  EXPECT_EQ(utc->slaves.at(0).processing_extra_ns, 17.5);
  EXPECT_EQ(make_clock_plan(with("time = \"system\"\n"), found(1), true)->time, nullptr) << "on virtual time";
  EXPECT_EQ(refusal("[dc]\ntime = \"gps\"\n[[slave]]\nname = \"x\"\n"),
            "line.toml:2: [dc] time: is \"gps\", one of \"monotonic\", \"system\", \"tai\" is expected");
}

TEST(ClockConfig, EveryKeyArrives) {
  const auto config = parse(
      "[line]\ncycle_us = 250\n"
      "[dc]\nmode = \"reference_follows\"\nreference = \"y\"\nframe_lead_us = 40.5\n"
      "[[slave]]\nname = \"x\"\ndc = { synchronous = false, drift_ppm = -20.5 }\n"
      "[[slave]]\nname = \"y\"\ndc = { op_mode = \"Half\", sync0_shift_us = -10 }\n"
      "[[slave]]\nname = \"z\"\ndc = { sync0_cycle_us = 125, sync1_cycle_us = 250, sync1_shift_us = 3.5 }\n");
  EXPECT_EQ(config.slaves[0].dc.drift_ppm, -20.5);
  const auto plan = must(make_clock_plan(config, found(3)));
  EXPECT_EQ(plan->mode, FollowMode::kReferenceFollows);
  EXPECT_EQ(plan->reference, 1);
  EXPECT_EQ(plan->period, microseconds{250});
  EXPECT_EQ(plan->frame_lead, nanoseconds{40'500});
  EXPECT_FALSE(plan->slaves[0].signals.active());
  EXPECT_EQ(plan->slaves[1].signals.sync0_cycle, microseconds{125});
  EXPECT_EQ(plan->slaves[1].signals.sync0_shift, microseconds{-10});
  EXPECT_EQ(plan->slaves[2].signals,
            (ecat_master::dc::SyncSignals{0x0700, microseconds{125}, {}, microseconds{250}, nanoseconds{3500}}));
}

TEST(ClockConfig, MistakesHaveASentence) {
  const std::string slave = "\n[[slave]]\nname = \"x\"\n";
  EXPECT_EQ(refusal("[dc]\nreference = \"q\"" + slave),
            "line.toml:2: [dc] reference: there is no [[slave]] named \"q\"");
  EXPECT_NE(refusal("[dc]\nframe_lead_us = 126" + slave), "");
  EXPECT_NE(refusal("[dc]\nmode = \"free\"" + slave), "");
  EXPECT_NE(refusal("[dc]\nshift = 3" + slave), "");
  EXPECT_NE(refusal("[dc]" + slave + "dc = { sync0_shift = 3 }"), "");
}

TEST(ClockConfig, AModeThatTheSlaveDoesNotHaveIsRefused) {
  const auto config = parse("[dc]\n[[slave]]\nname = \"x\"\ndc = { op_mode = \"DC\" }\n");
  const auto plan = make_clock_plan(config, found(1));
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().kind, ErrorKind::kSetting);
  EXPECT_EQ(describe(plan.error()),
            "slave x: has no operation mode \"DC\", its description knows \"DC-Synchronous\", \"Half\"");
}

TEST(ClockConfig, ExampleIsSynchronousWithClocksOfUnequalSpeed) {
  const auto config = must(load_line_config(DRIVELINE_EXAMPLES_DIR "/line8-dc.toml"));
  ASSERT_TRUE(config->clocks);
  EXPECT_EQ(config->clocks->frame_lead, microseconds{60});
  for (const auto& slave : config->slaves) EXPECT_NE(slave.dc.drift_ppm, 0.0) << slave.name;
}

}  // namespace
}  // namespace driveline::runtime

// A slave that answers for another one: the working counter is higher than possible.
#include <gmock/gmock.h>

#include <cmath>

#include "drive_line.hpp"
#include "driveline/ecat_master/diagnosis/diagnosis.hpp"
#include "driveline/wire/fmmu.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CyclicEvent;
using motion::MotionFailure;
using motion::MotionPhase;
using slaves::PowerState;

/// Four drives on their path, in two groups: drives 0 and 2, drives 1 and 3. An unplanned FMMU of drive 1 overwrites
/// the status word of drive 0 with two bytes of its registers.
class ForeignFmmu : public testing::Test {
 protected:
  static constexpr std::size_t kDrives = 4;
  static constexpr std::uint16_t kFreeFmmu = 7;
  static constexpr std::uint16_t kLimit = 8;  ///< cycles, see Motion::Settings::bad_cycle_limit

  ForeignFmmu() {
    RunOptions options;
    options.groups = 2;
    options.layout.groups = {{1, 0}, {1, 0}};
    options.amplitude_rad = 0.5;
    operation = std::make_unique<LineOperation>(drives, options);
  }
  void SetUp() override {
    ASSERT_EQ(sentence(operation->to_motion()), "");
    ASSERT_TRUE(operation->run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
    operation->run(milliseconds{80});
    ASSERT_EQ(operation->statistics().wkc_errors, 0U);
    CyclicEvent event;
    while (core().take_event(event)) {
    }
    operation->axis_samples.clear();
  }
  void map_over_status_word(bool active) {
    wire::FmmuEntity fmmu;
    const auto& place = operation->master().image().places()[0];
    fmmu.logical_start = ecat_master::ProcessImage::logical_address(place.input_offset);
    fmmu.length = 2;
    fmmu.physical_start = wire::reg::kStationAddress.address;
    fmmu.type = wire::FmmuEntity::kTypeRead;
    fmmu.active = active;
    std::array<std::byte, wire::FmmuEntity::kSize> raw{};
    fmmu.encode(raw);
    const auto address = static_cast<std::uint16_t>(wire::reg::kFmmu.at(kFreeFmmu));
    ASSERT_EQ(sentence(operation->master().bus().write(operation->master().slaves()[1].info.ref, address, raw)), "");
  }
  std::vector<std::string> working_counter_events() {
    std::vector<std::string> sentences;
    CyclicEvent event;
    while (core().take_event(event)) {
      if (event.kind != CyclicEvent::Kind::kWorkingCounter) continue;
      const auto sentence = describe(event);
      sentences.push_back(sentence.substr(sentence.find(" s ") + 3));
    }
    return sentences;
  }
  /// Expects that no demand of a drive changed more than its limits allow, and that no status word was the foreign one.
  void expect_no_leap() {
    const auto& limits = operation->motion().axes()[0].config().limits;
    std::array<double, kDrives> before{};
    std::array<bool, kDrives> known{};
    for (const auto& sample : operation->axis_samples) {
      const auto station = operation->master().slaves()[1].info.ref.station;
      ASSERT_NE(sample.status_word, station) << "cycle " << sample.cycle;
      if (known[sample.axis]) {
        const double step = std::abs(sample.target_position - before[sample.axis]);
        ASSERT_LE(step, limits.max_velocity * 125e-6 * 1.01) << "axis " << sample.axis << ", cycle " << sample.cycle;
      }
      before[sample.axis] = sample.target_position;
      known[sample.axis] = true;
    }
  }
  ecat_master::CyclicCore& core() { return *operation->master().core(); }

  DriveLine drives{kDrives};
  std::unique_ptr<LineOperation> operation;
};

TEST_F(ForeignFmmu, MakesItsGroupInvalidIsNamedAndStopsTheAxes) {
  map_over_status_word(true);
  operation->run(microseconds{125} * 4);
  for (const std::size_t i : {0U, 2U}) EXPECT_FALSE(core().slave_report(i).valid) << i;
  for (const std::size_t i : {1U, 3U}) EXPECT_TRUE(core().slave_report(i).valid) << i;
  EXPECT_GE(operation->statistics().wkc_errors, 3U);
  EXPECT_THAT(working_counter_events(), testing::ElementsAre("group 0: working counter 7 of 6"));
  operation->run(milliseconds{500});
  const auto failure = operation->motion().failure();
  EXPECT_EQ(failure.cause, MotionFailure::Cause::kAxisLost);
  EXPECT_EQ(failure.axis, 0);
  for (std::size_t i = 0; i < kDrives; ++i) {
    EXPECT_EQ(drives.drive(i).state(), PowerState::kSwitchOnDisabled) << i;
    EXPECT_NEAR(drives.drive(i).velocity_rad_s(), 0.0, 0.05) << i;
  }
  expect_no_leap();
}

TEST_F(ForeignFmmu, ForAFewCyclesCostsThoseAndNothingElse) {
  map_over_status_word(true);
  for (unsigned cycle = 0; cycle + 4 < kLimit; ++cycle) operation->cycle();
  map_over_status_word(false);
  operation->run(milliseconds{50});
  EXPECT_GE(operation->statistics().wkc_errors, 3U);
  EXPECT_LT(operation->statistics().wkc_errors, kLimit);
  EXPECT_THAT(working_counter_events(),
              testing::ElementsAre("group 0: working counter 7 of 6", "group 0: working counter 6 of 6"));
  EXPECT_EQ(operation->motion().failure().cause, MotionFailure::Cause::kNone);
  EXPECT_EQ(operation->motion().phase(), MotionPhase::kFollowing);
  expect_no_leap();
}

}  // namespace
}  // namespace driveline::bus_test

#include "driveline/slaves/can/error_counters.hpp"

#include <gtest/gtest.h>

#include "driveline/slaves/can/bus_off_recovery.hpp"
#include "driveline/slaves/can/wiring.hpp"

namespace driveline::slaves::can {
namespace {

// C10: error active < 128 <= passive < 256 = off; warning at 96.
TEST(ErrorCounters, C10Limits) {
  ErrorCounters counters;
  const auto at = [&](unsigned errors) {
    counters.reset();
    for (unsigned i = 0; i < errors; ++i) counters.transmit_error();
    return counters;
  };
  EXPECT_FALSE(at(11).warning());
  EXPECT_TRUE(at(12).warning());
  EXPECT_EQ(at(15).state(), ErrorState::kActive);
  EXPECT_EQ(at(16).state(), ErrorState::kPassive);
  EXPECT_EQ(at(31).state(), ErrorState::kPassive);
  EXPECT_EQ(at(32).state(), ErrorState::kBusOff);
}

TEST(ErrorCounters, C10GoodFramesCountDown) {
  ErrorCounters counters;
  counters.transmit_error();
  counters.sent();
  EXPECT_EQ(counters.transmit(), 7U);
  counters.receive_error(5);
  counters.received();
  EXPECT_EQ(counters.receive(), 4U);
  counters.receive_error(1000);
  EXPECT_EQ(counters.receive(), 255U);
  EXPECT_EQ(counters.state(), ErrorState::kPassive);  // receive errors never lead to bus off
  counters.received();
  EXPECT_EQ(counters.receive(), 127U);
  EXPECT_EQ(counters.state(), ErrorState::kActive);
  counters.reset();
  counters.sent();
  counters.received();
  EXPECT_EQ(counters.transmit(), 0U);
  EXPECT_EQ(counters.receive(), 0U);
}

// C8: 128 times 11 recessive bits; at 500 kbit/s 2.816 ms of an idle bus.
TEST(BusOffRecovery, C8CountsRecessiveBits) {
  const nanoseconds bit{2000};
  BusOffRecovery recovery;
  recovery.wire_recessive(nanoseconds{5000});
  EXPECT_EQ(recovery.finished_at(bit), kNever);
  recovery.start(nanoseconds{7000});
  EXPECT_EQ(recovery.finished_at(bit), nanoseconds{7000 + 128 * 11 * 2000});
  recovery.wire_dominant(nanoseconds{7000 + 22'000 * 3 + 21'000},
                         bit);  // three sequences, and a part that does not count
  EXPECT_EQ(recovery.finished_at(bit), kNever);
  recovery.wire_recessive(nanoseconds{1'000'000});
  EXPECT_EQ(recovery.finished_at(bit), nanoseconds{1'000'000 + 125 * 22'000});
}

// MSD manual 4.6.3, Table 4.8, typed a second time.
TEST(CanWiring, CableLengthsOfTheManual) {
  EXPECT_EQ(longest_cable_m(1'000'000), 25);
  EXPECT_EQ(longest_cable_m(500'000), 100);
  EXPECT_EQ(longest_cable_m(250'000), 250);
  EXPECT_EQ(longest_cable_m(125'000), 500);
  EXPECT_EQ(longest_cable_m(50'000), 1000);
  EXPECT_EQ(longest_cable_m(20'000), 2500);
  EXPECT_EQ(longest_cable_m(800'000), 25);
  EXPECT_EQ(longest_cable_m(10'000), 2500);
}

}  // namespace
}  // namespace driveline::slaves::can

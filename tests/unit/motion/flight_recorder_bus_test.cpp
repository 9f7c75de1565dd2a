#include <gtest/gtest.h>

#include <sstream>

#include "driveline/motion/cycle/flight_recorder.hpp"

namespace driveline::motion {
namespace {

std::string csv_of(const snapshot::LineSample& sample) {
  FlightRecorder recorder(0, 4);
  recorder.record(sample, {});
  std::ostringstream out;
  recorder.write_csv(out, {});
  return out.str();
}

TEST(FlightRecorderColumns, HaveTheLoadOfABusThatMeasuresIt) {
  snapshot::LineSample sample;
  sample.cycle = 17;
  sample.working_counter = 7;
  sample.expected_working_counter = 8;
  sample.bus_load = 0.7325F;
  sample.bus_send_errors = 96;
  sample.bus_receive_errors = 5;
  EXPECT_EQ(csv_of(sample),
            "cycle,time_ns,wake_latency_ns,cost_ns,round_trip_ns,missed_periods,frames_received,working_counter,"
            "expected_working_counter,bus_load,bus_send_errors,bus_receive_errors\n"
            "17,0,0,0,0,0,0,7,8,0.7325,96,5\n");
}

TEST(FlightRecorderColumns, HaveNoLoadWithoutOne) {
  EXPECT_EQ(csv_of({}).find("bus_load"), std::string::npos);
}

}  // namespace
}  // namespace driveline::motion

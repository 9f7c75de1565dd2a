// Stops, halts and switch-offs reach the axes in the next cycle, whatever else waits, and in the order of the requests.
#include "single_axis/stop_lane.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "driveline/motion/single_axis/single_axes.hpp"

namespace driveline::motion {
namespace {

enum class Kind : std::uint8_t { kWeak, kStrong };
using Lane = StopLane<int, Kind, 2>;
using Taken = std::vector<std::tuple<std::size_t, std::uint64_t, bool>>;

Taken take(Lane& lane) {
  Taken taken;
  lane.take_all([&taken](std::size_t receiver, const Lane::Stop& stop, bool superseded) {
    EXPECT_EQ(stop.request, static_cast<int>(stop.id) * 10);
    taken.emplace_back(receiver, stop.id, superseded);
  });
  return taken;
}

std::uint64_t put(Lane& lane, std::size_t receiver, Kind kind, std::uint64_t id) {
  return lane.put(receiver, kind, {id, static_cast<int>(id) * 10});
}

TEST(StopLane, GivesTheStopsOfEachReceiverInTheOrderOfTheirNumbers) {
  Lane lane(3);
  EXPECT_EQ(take(lane), Taken{});
  put(lane, 2, Kind::kStrong, 1);
  put(lane, 0, Kind::kWeak, 2);
  put(lane, 2, Kind::kWeak, 3);
  EXPECT_EQ(take(lane), (Taken{{0, 2, false}, {2, 1, false}, {2, 3, false}})) << "a weaker one replaces nothing";
  EXPECT_EQ(take(lane), Taken{});
  put(lane, 2, Kind::kWeak, 4);
  put(lane, 2, Kind::kStrong, 5);
  EXPECT_EQ(take(lane), (Taken{{2, 4, true}, {2, 5, false}}));
  EXPECT_EQ(lane.taken(2, Kind::kWeak), 4U);
  EXPECT_EQ(lane.taken_from(2, Kind::kWeak), 5U);
  EXPECT_EQ(lane.taken_from(0, Kind::kStrong), 0U);
}

TEST(StopLane, AStopReplacesTheOneOfItsKindThatHasNotBeenTaken) {
  Lane lane(1);
  EXPECT_EQ(put(lane, 0, Kind::kWeak, 1), 0U);
  EXPECT_EQ(put(lane, 0, Kind::kWeak, 2), 1U);
  EXPECT_EQ(put(lane, 0, Kind::kStrong, 3), 0U);
  EXPECT_EQ(take(lane), (Taken{{0, 2, true}, {0, 3, false}}));
  EXPECT_EQ(lane.puts(), 3U);
  EXPECT_EQ(lane.puts_taken(), 3U);
}

/// Whatever the cycle sees of a submitting thread: numbers rise, and the last stop of each kind arrives.
TEST(StopLane, BetweenTwoThreadsNoLastStopIsLost) {
  constexpr std::uint64_t kStops = 20'000;
  Lane lane(4);
  std::thread client([&lane] {
    for (std::uint64_t id = 1; id <= kStops; ++id) put(lane, id % 4, id % 3 == 0 ? Kind::kStrong : Kind::kWeak, id);
  });
  std::vector<std::uint64_t> last(4);
  const auto cycle = [&lane, &last] {
    for (const auto& [receiver, id, superseded] : take(lane)) {
      EXPECT_GT(id, last[receiver]);
      last[receiver] = id;
    }
  };
  while (lane.taken_from(0, Kind::kWeak) < kStops) {
    cycle();
    std::this_thread::yield();
  }
  client.join();
  cycle();
  for (std::size_t receiver = 0; receiver < 4; ++receiver)
    EXPECT_EQ(last[receiver], receiver == 0 ? kStops : kStops - 4 + receiver);
}

/// Enabled axes without drives.
class AxesWithoutDrives {
 public:
  explicit AxesWithoutDrives(std::size_t count) : axes(make(count), {}), count_(count) {
    for (std::size_t i = 0; i < count; ++i) static_cast<void>(axes.submit_in_cycle(i, ask(AxisCommand::kPower)));
    cycles(200);
    EXPECT_EQ(in(PlcopenState::kStandstill), count);
  }
  static AxisRequest ask(AxisCommand command, double target = 0.0, double velocity = 0.0) {
    AxisRequest request;
    request.command = command;
    request.target_si = target;
    request.velocity_si = velocity;
    return request;
  }
  static AxisRequest off() {
    auto request = ask(AxisCommand::kPower);
    request.on = false;
    return request;
  }
  static AxisRequest buffered(AxisRequest request) {
    request.buffer = BufferMode::kBuffered;
    return request;
  }
  void cycles(int number) {
    for (int i = 0; i < number; ++i) {
      axes.read_inputs({}, {}, {}, {}, {});
      axes.update(++cycle_, {});
    }
  }
  [[nodiscard]] std::size_t in(PlcopenState state) const {
    std::size_t sum = 0;
    for (std::size_t i = 0; i < count_; ++i) sum += axes.axis_report(i).state == state ? 1U : 0U;
    return sum;
  }
  [[nodiscard]] std::uint64_t planned() const {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < count_; ++i) sum += axes.axis(i).planned();
    return sum;
  }
  std::uint64_t submit(const AxisRequest& request, std::size_t axis = 0) { return axes.submit(axis, request); }
  /// Tries to queue as many requests of the last axis; returns the number of the last one that was accepted.
  std::uint64_t flood(int requests) {
    std::uint64_t last = 0;
    for (int i = 0; i < requests; ++i) {
      if (const auto id = submit(ask(AxisCommand::kSetOverride, 1.0), count_ - 1); id != 0) last = id;
    }
    return last;
  }
  [[nodiscard]] RequestReport report(std::uint64_t id) const { return axes.report(id); }
  [[nodiscard]] RequestPhase phase(std::uint64_t id) const { return report(id).phase; }
  [[nodiscard]] PlcopenState state(std::size_t axis = 0) const { return axes.axis_report(axis).state; }

  SingleAxes axes;

 private:
  static std::vector<Axis> make(std::size_t count) {
    std::vector<Axis> made;
    for (std::size_t i = 0; i < count; ++i) {
      AxisConfig config;
      config.name = "axis" + std::to_string(i);
      config.slave = AxisConfig::kNoSlave;
      config.limits = {50.0, 1000.0};
      made.emplace_back(config);
    }
    return made;
  }
  std::size_t count_;
  std::int64_t cycle_ = 0;
};

using Line = AxesWithoutDrives;

TEST(StopsOfAxes, EveryAxisOfALineOf256IsStoppedInOneCycleWhateverWaits) {
  constexpr std::size_t kAxes = 256;
  Line line(kAxes);
  for (std::size_t i = 0; i < kAxes; ++i) {
    line.axes.submit_in_cycle(i, Line::ask(AxisCommand::kMoveVelocity, 10.0));
    line.axes.submit_in_cycle(i, Line::buffered(Line::ask(AxisCommand::kMoveRelative, 100.0, 20.0)));
  }
  // The motions of the axes wait for their plans now, four in a cycle.
  line.cycles(84);
  EXPECT_GT(line.in(PlcopenState::kContinuousMotion), kAxes / 2);
  line.flood(10'000);
  std::vector<std::uint64_t> stops;
  for (std::size_t i = 0; i < kAxes; ++i) stops.push_back(line.submit(Line::ask(AxisCommand::kStop), i));
  const auto planned = line.planned();
  line.cycles(1);
  EXPECT_EQ(line.in(PlcopenState::kStopping), kAxes);
  for (const auto id : stops) EXPECT_EQ(line.phase(id), RequestPhase::kActive);
  EXPECT_LE(line.planned() - planned, kAxes + 4) << "one plan per stop, and those of any cycle";
  line.cycles(1000);
  for (const auto id : stops) EXPECT_EQ(line.phase(id), RequestPhase::kDone);
  EXPECT_EQ(line.in(PlcopenState::kStopping), kAxes) << "until they are released";
}

TEST(StopsOfAxes, TenThousandStopsOfOneAxisNeitherFillTheLaneNorCostMoreThanOne) {
  Line line(2);
  line.submit(Line::ask(AxisCommand::kMoveVelocity, 10.0));
  line.cycles(200);
  std::uint64_t before = 0;
  std::uint64_t last = 0;
  for (int i = 0; i < 10'000; ++i) {
    before = std::exchange(last, line.submit(Line::ask(AxisCommand::kHalt)));
    ASSERT_NE(last, 0U);
    if (i > 0) {
      ASSERT_EQ(line.phase(before), RequestPhase::kAborted);
    }
  }
  const auto other = line.submit(Line::ask(AxisCommand::kHalt), 1);
  const auto planned = line.planned();
  line.cycles(1);
  EXPECT_EQ(line.planned() - planned, 2U);
  EXPECT_EQ(line.phase(last), RequestPhase::kActive);
  line.cycles(1000);
  EXPECT_EQ(line.phase(last), RequestPhase::kDone);
  EXPECT_EQ(line.phase(other), RequestPhase::kDone);
}

TEST(StopsOfAxes, AMotionThatWasAskedForBeforeAStopDoesNotBeginAfterIt) {
  for (const auto& stop : {Line::ask(AxisCommand::kHalt), Line::ask(AxisCommand::kStop), Line::off()}) {
    Line line(2);
    line.flood(200);
    const auto older = line.submit(Line::ask(AxisCommand::kMoveRelative, 1.0));
    static_cast<void>(line.submit(stop));
    line.cycles(100);
    EXPECT_EQ(line.phase(older), RequestPhase::kAborted);
    EXPECT_EQ(line.report(older).error, AxisError::kNone);
    EXPECT_EQ(line.axes.axis_report(0).setpoint, 0.0);
  }
}

TEST(StopsOfAxes, AMotionThatIsAskedForAfterAHaltReplacesIt) {
  Line line(2);
  line.submit(Line::ask(AxisCommand::kMoveVelocity, 10.0));
  line.cycles(200);
  const auto halt = line.submit(Line::ask(AxisCommand::kHalt));
  const auto younger = line.submit(Line::ask(AxisCommand::kMoveRelative, 1.0));
  line.cycles(1);
  EXPECT_EQ(line.phase(halt), RequestPhase::kAborted);
  EXPECT_EQ(line.phase(younger), RequestPhase::kActive);
}

TEST(StopsOfAxes, TheReleaseOfAnEarlierStopDoesNotReleaseALaterOne) {
  Line line(2);
  line.submit(Line::ask(AxisCommand::kStop));
  line.cycles(10);
  line.flood(200);
  const auto release = line.submit(Line::ask(AxisCommand::kReleaseStop));
  const auto stop = line.submit(Line::ask(AxisCommand::kStop));
  line.cycles(100);
  EXPECT_EQ(line.phase(release), RequestPhase::kDone);
  EXPECT_EQ(line.phase(stop), RequestPhase::kDone);
  EXPECT_EQ(line.state(), PlcopenState::kStopping);
  line.submit(Line::ask(AxisCommand::kReleaseStop));
  line.cycles(1);
  EXPECT_EQ(line.state(), PlcopenState::kStandstill);
}

TEST(StopsOfAxes, ThoseOfOneCycleActAsIfTakenOneByOne) {
  Line line(1);
  line.submit(Line::ask(AxisCommand::kMoveVelocity, 10.0));
  line.cycles(200);
  auto halt = line.submit(Line::ask(AxisCommand::kHalt));
  auto stop = line.submit(Line::ask(AxisCommand::kStop));
  line.cycles(1);
  EXPECT_EQ(line.phase(halt), RequestPhase::kAborted);
  EXPECT_EQ(line.phase(stop), RequestPhase::kActive);
  stop = line.submit(Line::ask(AxisCommand::kStop));
  halt = line.submit(Line::ask(AxisCommand::kHalt));
  line.cycles(1);
  EXPECT_EQ(line.phase(stop), RequestPhase::kActive);
  EXPECT_EQ(line.report(halt).error, AxisError::kStopping);
  const auto off = line.submit(Line::off());
  stop = line.submit(Line::ask(AxisCommand::kStop));
  line.cycles(1);
  EXPECT_EQ(line.phase(off), RequestPhase::kActive);
  EXPECT_EQ(line.report(stop).error, AxisError::kNotEnabled);
  line.cycles(1000);
  EXPECT_EQ(line.phase(off), RequestPhase::kDone);
  EXPECT_EQ(line.state(), PlcopenState::kDisabled);
}

TEST(StopsOfAxes, ASwitchOffOvertakesTheSwitchOnBeforeIt) {
  Line line(2);
  line.submit(Line::off());
  line.cycles(200);
  ASSERT_EQ(line.state(), PlcopenState::kDisabled);
  line.flood(200);
  const auto on = line.submit(Line::ask(AxisCommand::kPower));
  const auto off = line.submit(Line::off());
  line.cycles(1);
  EXPECT_EQ(line.phase(off), RequestPhase::kDone) << "it is off";
  line.cycles(200);
  EXPECT_EQ(line.phase(on), RequestPhase::kAborted);
  EXPECT_EQ(line.state(), PlcopenState::kDisabled);
}

TEST(StopsOfAxes, ABufferedHaltWaitsForTheEndOfTheMotion) {
  Line line(1);
  const auto motion = line.submit(Line::ask(AxisCommand::kMoveRelative, 1.0, 10.0));
  const auto halt = line.submit(Line::buffered(Line::ask(AxisCommand::kHalt)));
  line.cycles(10);
  EXPECT_EQ(line.phase(motion), RequestPhase::kActive);
  EXPECT_EQ(line.phase(halt), RequestPhase::kWaiting);
  const auto at_once = line.submit(Line::ask(AxisCommand::kHalt));
  line.cycles(1);
  EXPECT_EQ(line.phase(motion), RequestPhase::kAborted);
  EXPECT_EQ(line.phase(halt), RequestPhase::kAborted);
  EXPECT_EQ(line.phase(at_once), RequestPhase::kActive);
}

/// Random requests, more than the cycle takes: after a stop no motion that is older than it is under way.
class AnyOrder {
 public:
  explicit AnyOrder(unsigned seed) : random_(seed) {}

  void execute() {
    for (int step = 0; step < 2000; ++step) {
      const auto requests = random_() % 8 == 0 ? 40 : random_() % 4;
      for (std::size_t i = 0; i < requests; ++i) ask(random_() % kAxes);
      line_.cycles(1 + static_cast<int>(random_() % 3));
      for (std::size_t axis = 0; axis < kAxes; ++axis) judge(axis, step);
    }
  }
  [[nodiscard]] int under_way() const noexcept { return under_way_; }

 private:
  static constexpr std::size_t kAxes = 3;

  void ask(std::size_t axis) {
    switch (random_() % 12) {
      case 0:
        return stop(axis, Line::ask(AxisCommand::kHalt));
      case 1:
        return random_() % 4 == 0 ? stop(axis, Line::ask(AxisCommand::kStop)) : void();
      case 2:
        return random_() % 8 == 0 ? stop(axis, Line::off()) : void();
      case 3:
        return static_cast<void>(line_.submit(Line::ask(AxisCommand::kReleaseStop), axis));
      case 4:
        return static_cast<void>(line_.submit(Line::ask(AxisCommand::kPower), axis));
      case 5:
        return static_cast<void>(line_.submit(Line::ask(AxisCommand::kSetOverride, 1.0), axis));
      case 6:
        return move(axis, Line::ask(AxisCommand::kMoveVelocity, 5.0));
      case 7:
        return move(axis, Line::buffered(Line::ask(AxisCommand::kMoveRelative, -0.1)));
      default:
        return move(axis, Line::ask(AxisCommand::kMoveRelative, 0.1));
    }
  }
  void stop(std::size_t axis, const AxisRequest& request) { last_stop_.at(axis) = line_.submit(request, axis); }
  void move(std::size_t axis, const AxisRequest& request) {
    if (const auto id = line_.submit(request, axis); id != 0) motions_.at(axis).push_back(id);
  }
  void judge(std::size_t axis, int step) {
    const auto stop = last_stop_.at(axis);
    const auto phase = stop == 0 ? RequestPhase::kUnknown : line_.phase(stop);
    const bool accepted = phase != RequestPhase::kUnknown && phase != RequestPhase::kError;
    EXPECT_NE(phase, RequestPhase::kWaiting) << "the next cycle takes it";
    auto& motions = motions_.at(axis);
    for (const auto id : motions) {
      const auto now = line_.phase(id);
      const bool moves = now == RequestPhase::kActive || now == RequestPhase::kReached;
      under_way_ += moves ? 1 : 0;
      EXPECT_FALSE(moves && accepted && id < stop) << "motion " << id << ", stop " << stop << ", step " << step;
    }
    std::erase_if(motions, [this](std::uint64_t id) { return line_.report(id).over(); });
  }

  Line line_{kAxes};
  std::mt19937 random_;
  std::array<std::uint64_t, kAxes> last_stop_{};
  std::array<std::vector<std::uint64_t>, kAxes> motions_{};
  int under_way_ = 0;
};

TEST(StopsOfAxes, NoOlderMotionIsUnderWayAfterAStopInAnyOrderOfRequests) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    AnyOrder any(seed);
    any.execute();
    EXPECT_GT(any.under_way(), 500) << "the axes hardly moved: nothing was judged";
  }
}

TEST(StopsOfAxes, ARequestThatIsNotAcceptedTakesNoNumber) {
  Line line(2);
  const auto last = line.flood(10'000);
  EXPECT_EQ(line.submit(Line::ask(AxisCommand::kMoveRelative, 1.0)), 0U);
  EXPECT_EQ(line.submit(Line::ask(AxisCommand::kReleaseStop)), last + 1) << "there is room to end a stop";
  EXPECT_EQ(line.submit(Line::ask(AxisCommand::kStop)), last + 2);
}

}  // namespace
}  // namespace driveline::motion

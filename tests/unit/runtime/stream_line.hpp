// A line of axes that follow streams without delay, with its server, on its own time.
#pragma once

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <memory>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/runtime/axes/axis_authority.hpp"
#include "driveline/stream/client.hpp"
#include "stream/stream_server.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::runtime {

inline constexpr auto kPeriod = std::chrono::microseconds{125};

/// Axes without inertia that follow their feeds, and take ten cycles to come to rest.
class StreamedAxes final : public StreamAxes {
 public:
  struct One {
    View view{};
    bool asked = false;
    bool halted = false;
    int halts = 0;
    int resting = 0;
    std::vector<double> demands{};
  };

  explicit StreamedAxes(std::size_t count) : all(count) {}

  [[nodiscard]] View view(std::size_t axis) const noexcept override { return all[axis].view; }
  void follow(std::size_t axis) noexcept override { all[axis].asked = true; }
  void halt(std::size_t axis) noexcept override {
    all[axis].halted = true;
    ++all[axis].halts;
  }
  void power_on(std::size_t axis) noexcept override { all[axis].view.state = stream::MotionState::kStandstill; }

  /// The motion of the axes, after the task.
  void update(StreamHub& hub) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      auto& one = all[i];
      auto& feed = hub.feed(i);
      if (std::exchange(one.halted, false) && one.view.state != stream::MotionState::kDisabled) {
        if (one.view.state == stream::MotionState::kSynchronizedMotion) feed.leave(0);
        one.view.state = stream::MotionState::kDiscreteMotion;
        one.resting = 10;
      }
      if (std::exchange(one.asked, false)) {
        feed.join(0, {one.view.setpoint, 0.0, 0.0});
        one.view.state = stream::MotionState::kSynchronizedMotion;
      }
      std::array<trajectory::AxisSetpoint, 1> setpoint{};
      if (one.view.state == stream::MotionState::kSynchronizedMotion) {
        if (feed.next(125e-6, setpoint)) {
          one.view.setpoint = setpoint[0].position;
        } else {
          one.view.state = stream::MotionState::kDiscreteMotion;
          one.resting = 10;
        }
      } else if (one.resting > 0 && --one.resting == 0) {
        one.view.state = stream::MotionState::kStandstill;
      }
      one.demands.push_back(one.view.setpoint);
    }
  }
  /// Another motion takes over an axis.
  void take_away(StreamHub& hub, std::size_t axis) {
    hub.feed(axis).leave(0);
    all[axis].view.state = stream::MotionState::kDiscreteMotion;
  }

  std::vector<One> all;
};

/// A line of three axes in this process, on its own time, with its server.
class StreamLine {
 public:
  explicit StreamLine(StreamConfig config = {}) {
    config.socket = folder.path / "stream.sock";
    config.axes = {0, 1, 2};
    std::vector<StreamAxis> offered;
    for (std::size_t i = 0; i < 3; ++i) {
      offered.push_back({std::string(1, static_cast<char>('x' + i)),
                         i,
                         {-100.0, 100.0, 10.0, 100.0},
                         *trajectory::find_position_unit("deg")});
      inputs.emplace_back(motion::AxisConfig{}, motion::ImagePlace{}, motion::axis_pdo_configuration());
    }
    auto opened = StreamServer::open(config, std::move(offered), hub, authority, kPeriod);
    if (!opened) throw std::runtime_error(describe(opened.error()));
    server = std::move(*opened);
    path = config.socket.string();
  }

  void cycle() {
    motion::TaskCycle now;
    now.cycle = ++number;
    now.grid = number * std::chrono::nanoseconds{kPeriod};
    now.elapsed = kPeriod;
    now.axes = inputs;
    hub.update(now);
    axes.update(hub);
  }
  void run(std::chrono::nanoseconds duration) {
    for (auto left = duration; left > std::chrono::nanoseconds{0}; left -= kPeriod) cycle();
  }
  void poll() {
    for (auto& event : server->poll()) told.push_back(describe(event));
  }
  /// Polls the server repeatedly while `work` runs in another thread.
  template <typename Work>
  auto beside(Work work) {
    auto done = std::async(std::launch::async, work);
    while (done.wait_for(std::chrono::milliseconds{1}) != std::future_status::ready) poll();
    poll();
    return done.get();
  }
  std::variant<stream::Client, std::string> connect(const stream::Wish& wish) {
    return beside([&] { return stream::Client::connect(path, wish); });
  }
  /// @throws std::bad_variant_access if the connection is refused.
  stream::Client client(const stream::Wish& wish) { return std::get<stream::Client>(connect(wish)); }
  std::string refusal(const stream::Wish& wish) { return std::get<std::string>(connect(wish)); }

  /// Lets another caller command an axis from now on.
  tl::expected<std::uint64_t, LeaseRefusal> take(std::size_t axis, const std::string& owner, bool take_over = false) {
    LeaseTerms terms;
    terms.owner = owner;
    terms.take_over = take_over;
    return authority.take(axis, terms);
  }

  test::TemporaryFolder folder{};
  std::vector<motion::Axis> inputs{};
  AxisAuthority authority{3};
  StreamedAxes axes{3};
  StreamHub hub{axes, 3};
  std::unique_ptr<StreamServer> server{};
  std::string path{};
  std::int64_t number = 0;
  std::vector<std::string> told{};
};

/// A motion of 1 rad in half a second that starts at 0: at most 6.3 rad/s and 79 rad/s^2.
inline stream::AxisTarget swing(double seconds) {
  const double omega = 2.0 * std::numbers::pi * 2.0;
  return {0.5 - 0.5 * std::cos(omega * seconds), 0.5 * omega * std::sin(omega * seconds),
          0.5 * omega * omega * std::cos(omega * seconds)};
}

/// Sends the setpoints of the next `cycles`, one every `step` cycles, and runs these cycles.
inline void stream_swing(StreamLine& line, stream::Client& client, int cycles, int step, int& sent) {
  for (int i = 0; i < cycles; ++i) {
    if (i % step == 0) {
      const auto time = sent++ * step * std::chrono::nanoseconds{kPeriod};
      const auto target = swing(std::chrono::duration<double>(time).count());
      const std::array targets{target, target};
      EXPECT_TRUE(client.send(time, std::span(targets).first(client.axis_count())));
    }
    line.cycle();
  }
}

/// The largest step between two consecutive demands.
inline double largest_step(const std::vector<double>& demands) {
  double step = 0.0;
  for (std::size_t i = 1; i < demands.size(); ++i) step = std::max(step, std::abs(demands[i] - demands[i - 1]));
  return step;
}

}  // namespace driveline::runtime

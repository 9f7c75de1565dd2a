// A separate program that moves two axes of a running line through shared memory: sines at 1 kHz, or at the given
// number of setpoints per second. It needs the headers of the stream and links no library
// (share/driveline/stream_client of the installation).
//   driveline run --config stream.toml              in one terminal: the axes wait
//   10_stream_client /tmp/driveline-stream.sock x y 5        in another one: for five seconds
//   10_stream_client /tmp/driveline-stream.sock x y 5 8000

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <string>
#include <thread>
#include <variant>

#include "driveline/stream/client.hpp"

using namespace driveline;
using namespace std::chrono_literals;

namespace {

constexpr auto kPause = 1ms;        // interval of polling
constexpr auto kLate = 8ms;         // how late this program may be
constexpr double kSwing = 0.5;      // rad
constexpr double kFrequency = 0.5;  // Hz

int fail(const std::string& sentence) {
  std::fprintf(stderr, "10_stream_client: %s\n", sentence.c_str());
  return 1;
}

/// Waits until both axes have power; none: they do not get it.
std::optional<stream::StatusRecord> wait_for_power(stream::Client& client) {
  for (int i = 0; i < 5000; ++i, std::this_thread::sleep_for(1ms)) {
    client.heartbeat();
    const auto status = client.status();
    const auto ready = [](const stream::ClientAxisStatus& axis) {
      return axis.state == stream::MotionState::kStandstill;
    };
    if (status && ready(status->axes[0]) && ready(status->axes[1])) return status;
  }
  return std::nullopt;
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 5 || count > 6) return fail("usage: 10_stream_client SOCKET AXIS AXIS SECONDS [SETPOINTS-PER-SECOND]");
  auto connected =
      stream::Client::connect(arguments[1], {.name = "sine", .axes = {arguments[2], arguments[3]}, .power = true});
  if (const auto* refusal = std::get_if<std::string>(&connected)) return fail(*refusal);
  auto& client = *std::get_if<stream::Client>(&connected);
  const auto begin = wait_for_power(client);
  if (!begin) return fail("the axes are not switched on");

  const auto duration = std::chrono::duration<double>(std::atof(arguments[4]));
  const auto step = std::chrono::nanoseconds{1s} / std::clamp(count == 6 ? std::atoi(arguments[5]) : 1000, 10, 8000);
  // The curve through the setpoints (cubic) needs two of them beyond the present of the line, whose time is known here
  // as of its last cycle.
  const auto lead = kLate + 2 * step + std::chrono::nanoseconds{client.line().period_ns};
  const double omega = 2.0 * std::numbers::pi * kFrequency;
  for (std::chrono::nanoseconds time{0}; time < duration;) {
    const auto status = client.status();
    if (!status || status->state >= stream::SessionState::kEnding || !client.connected()) break;
    if (status->count(stream::Refusal::kOutsideRange) > 0) {
      client.end();
      return fail("the line refuses a setpoint: it is outside the range of an axis");
    }
    // The line reports its time on the time axis of this program, so nothing drifts, whatever the clocks do.
    const bool streaming = status->state == stream::SessionState::kStreaming;
    const std::chrono::nanoseconds now{streaming ? status->stream_ns : status->newest_ns};
    for (; time - now < lead && time < duration; time += step) {
      const double angle = omega * std::chrono::duration<double>(time).count();
      const double way = kSwing * (1.0 - std::cos(angle));
      const double velocity = kSwing * omega * std::sin(angle);
      const stream::AxisTarget targets[] = {{begin->axes[0].setpoint + way, velocity},
                                            {begin->axes[1].setpoint - way, -velocity}};
      if (!client.send(time, targets)) break;
    }
    std::this_thread::sleep_for(kPause);
  }
  client.end();
  for (int i = 0; i < 2000 && client.connected(); ++i, std::this_thread::sleep_for(1ms)) {
    if (client.status()->state == stream::SessionState::kOver) break;
  }
  const auto status = client.status();
  if (!status) return fail("the line did not answer");
  if (status->state != stream::SessionState::kOver) return fail("the line closed the connection");
  std::printf("%llu setpoints taken, %llu late, used up %llu times; %s\n",
              static_cast<unsigned long long>(status->taken),
              static_cast<unsigned long long>(status->count(stream::Refusal::kLate)),
              static_cast<unsigned long long>(status->starved), std::string(to_text(status->reason)).c_str());
  return status->reason == stream::EndReason::kEnded ? 0 : 1;
}

// Streams oscillations into axes of a running line and prints events on stdout, one line each, for test_stream.py:
// "connected", "AXIS follows", "AXIS lost", "over: REASON". Reads "follow" and "end" from stdin.
//   stream_probe SOCKET SETPOINTS-PER-SECOND [wait] [take-over] AXIS...
// wait: retries while another caller commands the axes.
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "driveline/stream/client.hpp"

using namespace driveline;
using namespace std::chrono_literals;

namespace {

constexpr auto kTimeout = 60s;
constexpr auto kLead = 8ms;
constexpr double kSwing = 0.3;      // rad
constexpr double kFrequency = 2.0;  // Hz

void say(const std::string& what) {
  std::printf("%s\n", what.c_str());
  std::fflush(stdout);
}

/// Connects, or returns the refusal of the line as a sentence.
std::variant<stream::Client, std::string> connect(const std::string& socket, const stream::Wish& wish, bool wait) {
  const auto deadline = std::chrono::steady_clock::now() + kTimeout;
  for (;;) {
    auto connected = stream::Client::connect(socket, wish, std::chrono::duration_cast<std::chrono::milliseconds>(10s));
    const auto* refusal = std::get_if<std::string>(&connected);
    const bool again = refusal != nullptr && wait && refusal->find("is commanded by") != std::string::npos;
    if (!again || std::chrono::steady_clock::now() > deadline) return connected;
    std::this_thread::sleep_for(1ms);
  }
}

class Probe {
 public:
  Probe(stream::Client client, std::vector<std::string> axes)
      : client_{std::move(client)}, axes_{std::move(axes)}, told_(axes_.size()) {}

  /// Runs the program; returns its exit status.
  int run(std::chrono::nanoseconds step) {
    while (client_.connected()) {
      std::this_thread::sleep_for(500us);
      hear();
      const auto status = client_.status();
      if (!status) continue;
      tell(*status);
      if (status->state == stream::SessionState::kOver) {
        say("over: " + std::string(to_text(status->reason)));
        return 0;
      }
      if (status->state == stream::SessionState::kEnding) continue;
      if (ready(*status)) send(*status, step);
      client_.heartbeat();
    }
    say("the line is gone");
    return 1;
  }

 private:
  void hear() {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (::poll(&input, 1, 0) != 1) return;
    std::array<char, 64> bytes{};
    const auto count = ::read(STDIN_FILENO, bytes.data(), bytes.size());
    const std::string words(bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    if (words.find("follow") != std::string::npos) client_.follow();
    if (words.find("end") != std::string::npos) client_.end();
  }

  void tell(const stream::StatusRecord& status) {
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      const auto& axis = status.axes[i];
      const auto* now = axis.leased == 0 ? "lost" : axis.following == 1 ? "follows" : "waits";
      if (told_[i] == now) continue;
      told_[i] = now;
      say(axes_[i] + " " + now);
    }
  }

  /// Whether the axes are ready; the oscillations start at their positions.
  bool ready(const stream::StatusRecord& status) {
    if (begun_) return true;
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      if (status.axes[i].state != stream::MotionState::kStandstill) return false;
      begin_[i] = status.axes[i].setpoint;
    }
    begun_ = true;
    return true;
  }

  void send(const stream::StatusRecord& status, std::chrono::nanoseconds step) {
    const bool streaming = status.state == stream::SessionState::kStreaming;
    const std::chrono::nanoseconds now{streaming ? status.stream_ns : status.newest_ns};
    const double side = ::getpid() % 2 == 0 ? kSwing : -kSwing;
    for (; time_ - now < kLead; time_ += step) {
      const double omega = 2.0 * std::numbers::pi * kFrequency;
      const double angle = omega * std::chrono::duration<double>(time_).count();
      std::array<stream::AxisTarget, stream::kMaxAxes> targets{};
      for (std::size_t i = 0; i < axes_.size(); ++i) {
        targets[i] = {begin_[i] + side * (1.0 - std::cos(angle)), side * omega * std::sin(angle), 0.0};
      }
      if (!client_.send(time_, std::span(targets).first(axes_.size()))) return;
    }
  }

  stream::Client client_;
  std::vector<std::string> axes_;
  std::vector<std::string> told_;
  std::array<double, stream::kMaxAxes> begin_{};
  bool begun_ = false;
  std::chrono::nanoseconds time_{0};
};

}  // namespace

int main(int count, char** arguments) {
  stream::Wish wish;
  wish.name = "probe";
  wish.power = true;
  bool wait = false;
  for (int i = 3; i < count; ++i) {
    const std::string word = arguments[i];
    if (word == "wait") {
      wait = true;
    } else if (word == "take-over") {
      wish.take_over = true;
    } else {
      wish.axes.push_back(word);
    }
  }
  if (wish.axes.empty()) {
    std::fprintf(stderr, "usage: stream_probe SOCKET SETPOINTS-PER-SECOND [wait] [take-over] AXIS...\n");
    return 2;
  }
  auto connected = connect(arguments[1], wish, wait);
  if (const auto* refusal = std::get_if<std::string>(&connected)) {
    say("refused: " + *refusal);
    return 2;
  }
  say("connected");
  return Probe(std::move(*std::get_if<stream::Client>(&connected)), wish.axes)
      .run(std::chrono::nanoseconds{1s} / std::max(std::atoi(arguments[2]), 1));
}

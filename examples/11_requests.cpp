// Requests to an axis: a program enables, homes and moves it, in a thread of its own, while the library runs the line.
// There are three ways to follow a request: wait for it, be called back, or look at its progress.
//   11_requests by_hand.toml            the simulated line of the description, on virtual time
//   11_requests by_hand.toml eth1       the same axes on a network interface, in real time

#include <chrono>
#include <csignal>
#include <cstdio>
#include <numbers>
#include <string>
#include <thread>

#include "driveline/runtime/line.hpp"

using namespace driveline;
using namespace std::chrono_literals;
using motion::AxisCommand;
using motion::AxisRequest;
using motion::RequestPhase;

namespace {

constexpr std::size_t kAxis = 0;                            // the first axis of the description
constexpr double kQuarterTurnRad = std::numbers::pi / 2.0;  // requests are in rad and rad/s, or m and m/s

volatile std::sig_atomic_t interrupted = 0;

int fail(const std::string& sentence) {
  std::fprintf(stderr, "11_requests: %s\n", sentence.c_str());
  return 1;
}

/// Moves the axis. Its thread may wait: the cycle runs in another one, and the line in a third.
class Client {
 public:
  explicit Client(runtime::Line& line) : line_(line), axes_(line.axes()) {}

  void work() {
    done_ = finish({.command = AxisCommand::kPower, .on = true}) && finish({.command = AxisCommand::kHome}) &&
            finish({.command = AxisCommand::kMoveAbsolute, .target_si = kQuarterTurnRad}) && move_back() &&
            finish({.command = AxisCommand::kPower, .on = false});
    line_.request_stop();
  }
  [[nodiscard]] bool done() const noexcept { return done_; }

 private:
  /// Sends a request and waits until it is over.
  bool finish(const AxisRequest& request) {
    const auto number = axes_.submit(caller_, kAxis, request);
    if (!number) return refused(number.error());
    const auto progress = axes_.wait(kAxis, *number, 60s);
    if (progress.refusal) return refused(*progress.refusal);
    std::printf("%s: %s, at %.4f rad\n", std::string(to_text(request.command)).c_str(),
                std::string(to_text(progress.report.phase)).c_str(), position());
    return progress.report.phase == RequestPhase::kDone;
  }

  /// Gets a call-back at the end, and meanwhile polls the position of the axis.
  bool move_back() {
    const auto number = axes_.submit(
        caller_, kAxis, {.command = AxisCommand::kMoveRelative, .target_si = -kQuarterTurnRad, .velocity_si = 3.0});
    if (!number) return refused(number.error());
    axes_.when_settled(kAxis, *number, [](const runtime::AxisProgress& progress) {
      std::printf("called back: %s\n", std::string(to_text(progress.report.phase)).c_str());
    });
    RequestPhase phase = RequestPhase::kWaiting;
    while (!runtime::has_settled(phase = axes_.progress(kAxis, *number).report.phase)) {
      std::printf("  on its way, at %.4f rad\n", position());
      std::this_thread::sleep_for(50ms);
    }
    return phase == RequestPhase::kDone;
  }

  [[nodiscard]] double position() const {
    const auto report = axes_.status(kAxis).report;
    return report ? report->position : 0.0;
  }
  [[nodiscard]] bool refused(const runtime::AxisRefusal& refusal) const {
    fail(runtime::describe(axes_.status(kAxis).axis, refusal));
    return false;
  }

  runtime::Line& line_;
  runtime::AxisRequests& axes_;
  runtime::AxisCaller caller_{.name = "11_requests"};
  bool done_ = false;
};

/// Starts the client when the line is in operation.
class Start final : public runtime::Observer {
 public:
  Start(runtime::Line& line, Client& client) : line_(line), client_(client) {}
  void event(const runtime::Event& event) override { std::fprintf(stderr, "%s\n", runtime::describe(event).c_str()); }
  void poll() override {
    if (interrupted != 0) line_.request_stop();
    if (!thread_.joinable() && line_.axes().status(kAxis).report) thread_ = std::thread([this] { client_.work(); });
  }
  /// Waits until the client has ended. When the line is out of operation, its requests have ended, too.
  void join() {
    if (thread_.joinable()) thread_.join();
  }

 private:
  runtime::Line& line_;
  Client& client_;
  std::thread thread_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 3) {
    std::fputs("usage: 11_requests FILE [INTERFACE]\n", stderr);
    return 2;
  }
  for (const int number : {SIGINT, SIGTERM}) std::signal(number, [](int) { interrupted = 1; });
  runtime::Line::Options options;
  if (argc > 2) options.interface = argv[2];
  options.virtual_time = argc == 2;
  const auto line = runtime::Line::from_file(argv[1], options);
  if (!line) return fail(runtime::describe(line.error()));
  if ((*line)->config().axes.empty()) return fail("the line description has no [[axis]]");

  Client client(**line);
  Start start(**line, client);
  (*line)->observe(start);
  runtime::Line::RunSettings settings;
  settings.enable = false;  // the client enables its axis
  const auto report = (*line)->run(settings);
  start.join();
  if (!report) return fail(runtime::describe(report.error()));
  if (const auto* failure = report->failure()) return fail(runtime::describe(*failure));
  return client.done() ? 0 : fail("the axis has not done what was requested");
}

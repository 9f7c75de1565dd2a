// The telemetry of a line towards its bridge, which here is a thread that reads the feed.
#include "telemetry/telemetry_service.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "driveline/snapshot/feed/feed_reader.hpp"
#include "support/must.hpp"

namespace driveline::runtime {
namespace {

using namespace std::chrono_literals;

/// Descriptor of a part of the feed in this process, as driveline-bridge finds it in that of the line.
int feed_descriptor(const std::string& part) {
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code gone;
    const auto target = std::filesystem::read_symlink(entry.path(), gone).string();
    if (target.starts_with("/memfd:driveline-feed-" + part)) return std::stoi(entry.path().filename().string());
  }
  return -1;
}

/// A thread that waits once for the feed, without a time limit that could end the wait, and then takes what is there.
class WaitingReader {
 public:
  explicit WaitingReader(snapshot::FeedReader reader) : reader_(std::move(reader)), thread_([this] { wait(); }) {}
  ~WaitingReader() { thread_.join(); }

  /// Whether the thread sleeps, as the kernel sees it; a thread that has been woken does not, even before it runs.
  [[nodiscard]] bool asleep() const {
    std::ifstream file("/proc/self/task/" + std::to_string(id_) + "/stat");
    std::string text;
    std::getline(file, text);
    const auto name_end = text.rfind(") ");
    return id_ != 0 && name_end != std::string::npos && text[name_end + 2] == 'S';
  }
  [[nodiscard]] int taken() const { return taken_; }

 private:
  void wait() {
    id_ = ::gettid();
    reader_.wait(std::chrono::hours{1});
    int taken = 0;
    while (reader_.take()) ++taken;
    taken_ = taken;
  }

  snapshot::FeedReader reader_;
  std::atomic<pid_t> id_{0};
  std::atomic<int> taken_{0};  ///< after the wait
  std::thread thread_;
};

template <typename Condition>
bool eventually(const Condition& holds) {
  const auto limit = std::chrono::steady_clock::now() + 10s;
  while (!holds() && std::chrono::steady_clock::now() < limit) std::this_thread::yield();
  return holds();
}

TEST(TelemetryServiceTest, WakesTheBridgeWhenABatchIsCompleteAndNotBefore) {
  LineConfig config;
  config.period = 250us;  // four cycles to a batch of a millisecond
  config.axes.emplace_back().name = "x";
  config.slaves.emplace_back().name = "x";
  const auto service = must(TelemetryService::start(config, false, {}));
  auto feed = must(snapshot::FeedReader::open(feed_descriptor("description"), feed_descriptor("status"),
                                              feed_descriptor("cycles"), feed_descriptor("events")));
  WaitingReader bridge(*std::move(feed));
  ASSERT_TRUE(eventually([&] { return bridge.asleep(); }));

  const auto run_cycle = [&](std::uint64_t cycle) {
    snapshot::LineSample line;
    line.cycle = cycle;
    snapshot::AxisSample axis;
    axis.cycle = cycle;
    (*service)->lines({&line, 1});
    (*service)->axes({&axis, 1});
    (*service)->pass_done({});
  };
  for (std::uint64_t cycle = 0; cycle < 3; ++cycle) {
    run_cycle(cycle);
    EXPECT_TRUE(bridge.asleep()) << "cycle " << cycle;
    EXPECT_EQ(bridge.taken(), 0) << "cycle " << cycle;
  }
  run_cycle(3);
  EXPECT_TRUE(eventually([&] { return bridge.taken() == 4; }));
  (*service)->finish({});  // wakes a bridge that still waits
}

}  // namespace
}  // namespace driveline::runtime

// Programs that stream setpoints into a line: how they are let in, what they are told, and what becomes of their axes.
#include "stream/stream_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <memory>
#include <numbers>
#include <optional>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/runtime/axes/axis_authority.hpp"
#include "driveline/stream/client.hpp"

namespace driveline::runtime {
namespace {

using namespace std::chrono_literals;
using ecat_master::TaskCycle;
using stream::AxisState;
using stream::AxisTarget;
using stream::EndReason;
using stream::Refusal;
using stream::SessionState;
using stream::StatusRecord;
using testing::HasSubstr;

constexpr auto kPeriod = std::chrono::microseconds{125};

/// Axes that follow their feeds without inertia, and take ten cycles to come to rest.
class FakeAxes final : public StreamAxes {
 public:
  struct One {
    View view{};
    bool asked = false;
    bool halted = false;
    int halts = 0;
    int resting = 0;
    std::vector<double> demands{};
  };

  explicit FakeAxes(std::size_t count) : all(count) {}

  [[nodiscard]] View view(std::size_t axis) const noexcept override { return all[axis].view; }
  void follow(std::size_t axis) noexcept override { all[axis].asked = true; }
  void halt(std::size_t axis) noexcept override {
    all[axis].halted = true;
    ++all[axis].halts;
  }
  void power_on(std::size_t axis) noexcept override { all[axis].view.state = AxisState::kStandstill; }

  /// What the axes do behind the task.
  void update(StreamHub& hub) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      auto& one = all[i];
      auto& feed = hub.feed(i);
      if (std::exchange(one.halted, false) && one.view.state != AxisState::kDisabled) {
        if (one.view.state == AxisState::kSynchronizedMotion) feed.leave(0);
        one.view.state = AxisState::kDiscreteMotion;
        one.resting = 10;
      }
      if (std::exchange(one.asked, false)) {
        feed.join(0, {one.view.setpoint, 0.0, 0.0});
        one.view.state = AxisState::kSynchronizedMotion;
      }
      std::array<trajectory::AxisSetpoint, 1> setpoint{};
      if (one.view.state == AxisState::kSynchronizedMotion) {
        if (feed.next(125e-6, setpoint)) {
          one.view.setpoint = setpoint[0].position;
        } else {
          one.view.state = AxisState::kDiscreteMotion;
          one.resting = 10;
        }
      } else if (one.resting > 0 && --one.resting == 0) {
        one.view.state = AxisState::kStandstill;
      }
      one.demands.push_back(one.view.setpoint);
    }
  }
  /// Another motion takes an axis.
  void take_away(StreamHub& hub, std::size_t axis) {
    hub.feed(axis).leave(0);
    all[axis].view.state = AxisState::kDiscreteMotion;
  }

  std::vector<One> all;
};

/// A folder that goes with it.
class Folder {
 public:
  Folder() {
    std::string pattern = std::filesystem::temp_directory_path() / "driveline-stream-XXXXXX";
    if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("mkdtemp");
    path = pattern;
  }
  ~Folder() { std::filesystem::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::filesystem::path path;
};

/// A line of three axes in this process, on a time of its own, with its server.
class Line {
 public:
  explicit Line(StreamConfig config = {}) {
    config.socket = folder.path / "stream.sock";
    config.axes = {0, 1, 2};
    std::vector<StreamAxis> offered;
    for (std::size_t i = 0; i < 3; ++i) {
      offered.push_back({std::string(1, static_cast<char>('x' + i)), i, {-100.0, 100.0, 10.0, 100.0}});
      inputs.emplace_back(ecat_master::AxisConfig{}, ecat_master::ProcessDataPlace{},
                          ecat_master::axis_pdo_configuration());
    }
    auto opened = StreamServer::open(config, std::move(offered), hub, authority, kPeriod);
    if (!opened) throw std::runtime_error(describe(opened.error()));
    server = std::move(*opened);
    path = config.socket.string();
  }

  void cycle() {
    TaskCycle now;
    now.cycle = ++number;
    now.grid = number * std::chrono::nanoseconds{kPeriod};
    now.elapsed = kPeriod;
    now.axes = inputs;
    hub.update(now);
    axes.update(hub);
  }
  void run(std::chrono::nanoseconds duration) {
    for (auto left = duration; left > 0ns; left -= kPeriod) cycle();
  }
  void poll() {
    for (auto& event : server->poll()) told.push_back(describe(event));
  }
  /// The owner looks again and again while `work` runs in another thread.
  template <typename Work>
  auto beside(Work work) {
    auto done = std::async(std::launch::async, work);
    while (done.wait_for(1ms) != std::future_status::ready) poll();
    poll();
    return done.get();
  }
  std::variant<stream::Client, std::string> connect(const stream::Wish& wish) {
    return beside([&] { return stream::Client::connect(path, wish); });
  }
  /// @throws std::bad_variant_access if it is refused.
  stream::Client client(const stream::Wish& wish) { return std::get<stream::Client>(connect(wish)); }
  std::string refusal(const stream::Wish& wish) { return std::get<std::string>(connect(wish)); }

  /// Somebody else commands an axis from now on.
  tl::expected<std::uint64_t, LeaseRefusal> take(std::size_t axis, const std::string& owner, bool take_over = false) {
    LeaseTerms terms;
    terms.owner = owner;
    terms.take_over = take_over;
    return authority.take(axis, terms);
  }

  Folder folder{};
  std::vector<ecat_master::Axis> inputs{};
  AxisAuthority authority{3};
  FakeAxes axes{3};
  StreamHub hub{axes, 3};
  std::unique_ptr<StreamServer> server{};
  std::string path{};
  std::int64_t number = 0;
  std::vector<std::string> told{};
};

/// A swing of 1 rad in half a second that begins at 0: no faster than 6.3 rad/s and 79 rad/s^2.
AxisTarget swing(double seconds) {
  const double omega = 2.0 * std::numbers::pi * 2.0;
  return {0.5 - 0.5 * std::cos(omega * seconds), 0.5 * omega * std::sin(omega * seconds),
          0.5 * omega * omega * std::cos(omega * seconds)};
}

/// Sends what belongs to the next `cycles`, a setpoint every `step` cycles, and runs them.
void stream_swing(Line& line, stream::Client& client, int cycles, int step, int& sent) {
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

double largest_step(const std::vector<double>& demands) {
  double step = 0.0;
  for (std::size_t i = 1; i < demands.size(); ++i) step = std::max(step, std::abs(demands[i] - demands[i - 1]));
  return step;
}

TEST(StreamServer, GivesAxesToAClientThatAsks) {
  Line line;
  auto client = line.client({.name = "sine", .axes = {"y", "x"}});
  EXPECT_EQ(client.line().period_ns, 125'000);
  EXPECT_EQ(client.line().keep_alive_ns, 100'000'000);
  EXPECT_EQ(client.line().bounds[1].max_velocity, 10.0);
  line.run(1ms);
  const auto status = client.status();
  ASSERT_TRUE(status);
  EXPECT_EQ(status->state, SessionState::kWaiting);
  EXPECT_EQ(status->axis_count, 2U);
  EXPECT_EQ(status->cycle, line.number);
  line.poll();
  ASSERT_FALSE(line.told.empty());
  EXPECT_THAT(line.told.back(), HasSubstr("stream client \"sine\" (process "));
  EXPECT_THAT(line.told.back(), HasSubstr("has y, x"));
}

TEST(StreamServer, AnAxisHasOneClient) {
  Line line;
  auto first = std::make_unique<stream::Client>(line.client({.name = "first", .axes = {"x", "y"}}));
  EXPECT_THAT(line.refusal({.name = "second", .axes = {"z", "y"}}),
              HasSubstr("axis y: is commanded by stream client \"first\" (process "));
  auto third = line.client({.name = "third", .axes = {"z"}});
  first.reset();
  line.poll();
  EXPECT_THAT(line.refusal({.axes = {"x"}}), HasSubstr("axis x: is commanded by")) << "the cycle still has it";
  line.run(1ms);
  line.poll();
  EXPECT_THAT(line.told.back(), HasSubstr("\"first\""));
  EXPECT_THAT(line.told.back(), HasSubstr("its connection is gone: 0 setpoints; its axes are free"));
  const auto again = line.client({.axes = {"x"}});
  EXPECT_EQ(again.axis_count(), 1U);
}

TEST(StreamServer, TwoClientsOfOneNameInOneProcessAreTwo) {
  Line line;
  const auto first = line.client({.name = "same", .axes = {"x"}});
  EXPECT_THAT(line.refusal({.name = "same", .axes = {"x"}}), HasSubstr("axis x: is commanded by"));
  EXPECT_THAT(line.refusal({.name = "same", .axes = {"x"}, .take_over = true}), HasSubstr("axis x: is commanded by"));
  auto second = std::make_unique<stream::Client>(line.client({.name = "same", .axes = {"y"}}));
  second.reset();
  line.poll();
  line.run(1ms);
  line.poll();
  EXPECT_NE(line.authority.owner_of(0), "");
  EXPECT_EQ(line.authority.owner_of(1), "");
}

TEST(StreamServer, TakesAnAxisFromSomebodyElseOnlyWhereThatIsAskedFor) {
  Line line;
  ASSERT_TRUE(line.take(0, "hand"));
  line.axes.all[0].view.state = AxisState::kContinuousMotion;
  EXPECT_EQ(line.refusal({.axes = {"y", "x"}}), "axis x: is commanded by hand");
  EXPECT_EQ(line.authority.owner_of(1), "") << "all of them, or none";
  const auto client = line.client({.name = "sine", .axes = {"y", "x"}, .take_over = true});
  EXPECT_THAT(line.authority.owner_of(0), HasSubstr("stream client \"sine\""));
  const auto lost = line.authority.losses({});
  ASSERT_EQ(lost.size(), 1U);
  EXPECT_EQ(lost[0].owner, "hand");
  line.run(1ms);
  EXPECT_EQ(line.axes.all[0].halts, 1) << "what moved it is not heard any more";
  EXPECT_EQ(line.axes.all[1].halts, 0);
}

TEST(StreamServer, NobodyStreamsToAxesThatAreMovedTogether) {
  Line line;
  LeaseTerms path;
  path.owner = "path";
  path.firm = true;
  ASSERT_TRUE(line.authority.take(0, path));
  EXPECT_THAT(line.refusal({.axes = {"x"}, .take_over = true}), HasSubstr("axis x: is moved by the path of this run"));
}

TEST(StreamServer, RefusesWithASentence) {
  Line line;
  EXPECT_EQ(line.refusal({.axes = {"w"}}), "there is no axis \"w\" for streams, but x, y, z");
  EXPECT_EQ(line.refusal({.axes = {"x", "x"}}), "axis x is named twice");
  EXPECT_THAT(line.told.back(), HasSubstr("was sent away: there is no axis \"w\""));
}

/// A client by hand, for what the header does not do.
class RawClient {
 public:
  explicit RawClient(const std::string& path) : socket_(::socket(AF_UNIX, SOCK_SEQPACKET, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy(path.begin(), path.end(), address.sun_path);
    connected = ::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  void send(std::span<const std::byte> bytes) const {
    static_cast<void>(::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL));
  }
  [[nodiscard]] std::string refusal() const {
    stream::Answer answer;
    if (::recv(socket_.get(), &answer, sizeof answer, MSG_DONTWAIT) != sizeof answer) return "(no answer)";
    return std::string(answer.refusal.text());
  }
  bool connected = false;

 private:
  port::FileDescriptor socket_;
};

TEST(StreamServer, AnswersWhatIsNoGreeting) {
  Line line;
  const RawClient nonsense(line.path);
  const std::array<std::byte, 5000> bytes{};
  nonsense.send(bytes);
  line.poll();
  EXPECT_EQ(nonsense.refusal(), "it has not said what it wants in the words of version 1");
  const RawClient newer(line.path);
  stream::Hello hello;
  hello.version = 2;
  newer.send(stream::to_bytes(hello));
  line.poll();
  EXPECT_EQ(newer.refusal(), "it speaks version 2 of the stream, the line 1");
  const RawClient many(line.path);
  hello.version = 1;
  hello.axis_count = 1'000'000;
  many.send(stream::to_bytes(hello));
  line.poll();
  EXPECT_EQ(many.refusal(), "a client has 1 to 16 axes, not 1000000");
  std::mt19937_64 random(3);
  for (int i = 0; i < 200; ++i) {
    const RawClient client(line.path);
    auto greeting = stream::to_bytes(hello);
    for (auto& byte : greeting) byte = i % 2 == 0 ? static_cast<std::byte>(random()) : byte;
    greeting[8 + random() % (greeting.size() - 8)] = static_cast<std::byte>(random());
    client.send(std::span(greeting).first(random() % greeting.size()));
    line.poll();
  }
  EXPECT_TRUE(line.server->idle());
}

TEST(StreamServer, OneWhoSaysNothingIsSentAway) {
  Line line;
  std::vector<std::unique_ptr<RawClient>> silent;
  for (int i = 0; i < 20; ++i) {
    silent.push_back(std::make_unique<RawClient>(line.path));
    line.poll();
  }
  EXPECT_EQ(silent.back()->refusal(), "too many programs connect at once");
  EXPECT_EQ(line.refusal({.axes = {"x"}}), "too many programs connect at once")
      << "also said to one who speaks at once";
  std::this_thread::sleep_for(1100ms);
  line.poll();
  EXPECT_EQ(silent.front()->refusal(), "it has not said what it wants");
  EXPECT_EQ(line.client({.axes = {"x"}}).axis_count(), 1U);
}

TEST(StreamServer, ReplacesTheSocketOfARunThatDiedButNotOfOneThatLives) {
  Line line;
  StreamConfig config;
  config.socket = line.path;
  const auto second = StreamServer::open(config, {}, line.hub, line.authority, kPeriod);
  ASSERT_FALSE(second);
  EXPECT_THAT(describe(second.error()), HasSubstr("another process listens there"));
  const auto file = (line.folder.path / "old.sock").string();
  {
    const port::FileDescriptor old{::socket(AF_UNIX, SOCK_SEQPACKET, 0)};
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy(file.begin(), file.end(), address.sun_path);
    ASSERT_EQ(::bind(old.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  config.socket = file;
  const auto opened = StreamServer::open(config, {}, line.hub, line.authority, kPeriod);
  ASSERT_TRUE(opened) << describe(opened.error());
  struct stat status {};
  ASSERT_EQ(::stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U) << "nobody else may connect";
}

TEST(StreamSession, FollowsTheSetpointsOnTheirTime) {
  for (const int step : {1, 8}) {
    Line line;
    auto client = line.client({.axes = {"x", "y"}, .power = true});
    int sent = 0;
    stream_swing(line, client, 8000, step, sent);
    const auto status = client.status();
    ASSERT_TRUE(status);
    EXPECT_EQ(status->state, SessionState::kStreaming);
    EXPECT_EQ(status->axes[0].following, 1U);
    EXPECT_EQ(status->taken, static_cast<std::uint64_t>(sent));
    for (const auto refused : status->refused) EXPECT_EQ(refused, 0U);
    EXPECT_EQ(status->starved, 0U);
    const auto expected = swing(1e-9 * static_cast<double>(status->stream_ns));
    EXPECT_NEAR(status->axes[0].setpoint, expected.position, 0.002) << "of the cycle before";
    EXPECT_LE(largest_step(line.axes.all[0].demands), 6.3 * 125e-6);
  }
}

TEST(StreamSession, PausesWhenTheSetpointsAreUsedUpAndGoesOn) {
  Line line;
  auto client = line.client({.axes = {"x"}, .power = true});
  int sent = 0;
  stream_swing(line, client, 80 * 5, 8, sent);
  for (int i = 0; i < 5; ++i) {
    client.heartbeat();
    line.run(50ms);
  }
  auto status = client.status();
  ASSERT_TRUE(status);
  EXPECT_EQ(status->state, SessionState::kStarved);
  EXPECT_EQ(status->starved, 1U);
  EXPECT_EQ(status->axes[0].following, 1U);
  const auto held = status->axes[0].setpoint;
  EXPECT_LE(largest_step(line.axes.all[0].demands), 6.3 * 125e-6) << "it has stopped without a leap";
  client.heartbeat();
  line.run(10ms);
  EXPECT_EQ(line.axes.all[0].view.setpoint, held);
  line.poll();
  EXPECT_THAT(line.told.back(), HasSubstr("are used up: its axes come to rest until there are more"));
  // The next ones are a new beginning, on whatever time.
  for (int i = 0; i < 20; ++i) {
    EXPECT_TRUE(client.send(1h + i * 1ms, std::array{AxisTarget{held + 0.0005 * i}}));
    line.run(1ms);
  }
  status = client.status();
  EXPECT_EQ(status->state, SessionState::kStreaming);
  EXPECT_GT(status->axes[0].setpoint, held + 0.004);
  EXPECT_EQ(status->count(Refusal::kLate) + status->count(Refusal::kOutOfOrder), 0U);
}

TEST(StreamSession, ASilentClientLosesItsAxes) {
  Line line;
  auto client = line.client({.name = "stopped", .axes = {"x", "z"}, .power = true});
  int sent = 0;
  stream_swing(line, client, 80 * 5, 8, sent);
  line.run(99ms);
  EXPECT_EQ(client.status()->reason, EndReason::kNone);
  line.run(2ms);
  EXPECT_EQ(client.status()->reason, EndReason::kSilent);
  line.run(10ms);
  EXPECT_EQ(client.status()->state, SessionState::kOver);
  EXPECT_EQ(line.axes.all[0].view.state, AxisState::kStandstill);
  line.poll();
  EXPECT_THAT(line.told.back(), HasSubstr("it was silent for longer than the keep-alive time: 50 setpoints"));
  EXPECT_EQ(line.authority.owner_of(0), "");
  EXPECT_EQ(line.client({.axes = {"x"}}).axis_count(), 1U);
  // It may go on writing for ever: nobody looks.
  EXPECT_TRUE(client.heartbeat());
  EXPECT_EQ(client.status()->state, SessionState::kOver);
}

TEST(StreamSession, EndsWhenTheClientWantsItSo) {
  Line line;
  auto client = line.client({.axes = {"x"}, .power = true});
  int sent = 0;
  stream_swing(line, client, 80 * 5, 8, sent);
  EXPECT_TRUE(client.end());
  EXPECT_TRUE(client.send(10s, std::array{AxisTarget{}}));
  line.run(10ms);
  const auto status = client.status();
  EXPECT_EQ(status->reason, EndReason::kEnded);
  EXPECT_EQ(status->state, SessionState::kOver);
  EXPECT_EQ(status->taken, static_cast<std::uint64_t>(sent));
}

TEST(StreamSession, TheLineEndsIt) {
  Line line;
  auto client = line.client({.axes = {"x"}, .power = true});
  int sent = 0;
  stream_swing(line, client, 80 * 5, 8, sent);
  line.server->close();
  line.run(10ms);
  EXPECT_EQ(client.status()->reason, EndReason::kLine);
  line.poll();
  EXPECT_TRUE(line.server->idle());
  EXPECT_FALSE(client.connected());
  EXPECT_EQ(std::get<std::string>(stream::Client::connect(line.path, {.axes = {"x"}})),
            line.path + ": No such file or directory");
}

TEST(StreamSession, AnAxisThatWasTakenAwayComesBackWhenAsked) {
  Line line;
  auto client = line.client({.axes = {"x", "y"}, .power = true});
  int sent = 0;
  stream_swing(line, client, 80 * 5, 8, sent);
  line.axes.take_away(line.hub, 1);
  stream_swing(line, client, 80 * 5, 8, sent);
  EXPECT_EQ(client.status()->axes[0].following, 1U);
  EXPECT_EQ(client.status()->axes[1].following, 0U);
  EXPECT_TRUE(client.follow());
  stream_swing(line, client, 80, 8, sent);
  EXPECT_EQ(client.status()->axes[1].following, 1U);
}

TEST(StreamSession, AnAxisThatIsTakenOverComesToRestAndIsGivenBackWhenItIsFree) {
  Line line;
  auto client = line.client({.name = "sine", .axes = {"x", "y"}, .power = true});
  int sent = 0;
  stream_swing(line, client, 80 * 5, 8, sent);
  EXPECT_EQ(client.status()->axes[1].leased, 1U);
  ASSERT_TRUE(line.take(1, "hand", true));
  stream_swing(line, client, 80 * 5, 8, sent);
  EXPECT_EQ(client.status()->axes[0].following, 1U) << "each axis by itself";
  EXPECT_EQ(client.status()->axes[1].following, 0U);
  EXPECT_EQ(client.status()->axes[1].leased, 0U);
  EXPECT_EQ(line.axes.all[1].view.state, AxisState::kStandstill);
  line.poll();
  line.authority.release(1, "hand");
  stream_swing(line, client, 80, 8, sent);
  line.poll();
  EXPECT_EQ(line.authority.owner_of(1), "") << "it was not asked for";
  ASSERT_TRUE(line.take(1, "hand"));
  EXPECT_TRUE(client.follow());
  stream_swing(line, client, 80 * 5, 8, sent);
  line.poll();
  stream_swing(line, client, 80, 8, sent);
  EXPECT_EQ(client.status()->axes[1].following, 0U) << "somebody has it";
  line.authority.release(1, "hand");
  line.poll();
  EXPECT_THAT(line.told.back(), HasSubstr("stream client \"sine\""));
  EXPECT_THAT(line.told.back(), HasSubstr("has y"));
  stream_swing(line, client, 80, 8, sent);
  EXPECT_EQ(client.status()->axes[1].following, 1U);
  EXPECT_EQ(client.status()->axes[1].leased, 1U);
}

TEST(StreamSession, OneClientTakesAnAxisFromAnother) {
  Line line;
  auto first = line.client({.name = "first", .axes = {"x"}, .power = true});
  int sent = 0;
  stream_swing(line, first, 80 * 5, 8, sent);
  auto second = line.client({.name = "second", .axes = {"x", "y"}, .power = true, .take_over = true});
  first.heartbeat();
  int sent_by_second = 0;
  stream_swing(line, second, 80 * 5, 8, sent_by_second);
  EXPECT_EQ(first.status()->axes[0].leased, 0U);
  EXPECT_LT(first.status()->state, SessionState::kEnding) << "it may ask for the axis again";
  EXPECT_EQ(second.status()->axes[0].following, 1U);
  EXPECT_TRUE(first.end());
  stream_swing(line, second, 80, 8, sent_by_second);
  EXPECT_EQ(first.status()->state, SessionState::kOver) << "the axis is another's: there is nothing to wait for";
  line.poll();
  EXPECT_EQ(second.status()->axes[0].following, 1U);
  EXPECT_THAT(line.authority.owner_of(0), HasSubstr("\"second\""));
  EXPECT_TRUE(second.end());
  line.run(10ms);
  line.poll();
  EXPECT_EQ(line.authority.owner_of(0), "");
}

TEST(StreamSession, AnAxisWithoutPowerWaits) {
  Line line;
  auto client = line.client({.axes = {"x"}});
  int sent = 0;
  stream_swing(line, client, 80 * 5, 8, sent);
  EXPECT_EQ(client.status()->axes[0].state, AxisState::kDisabled);
  EXPECT_EQ(client.status()->axes[0].following, 0U);
  line.axes.all[0].view.state = AxisState::kStandstill;
  stream_swing(line, client, 80, 8, sent);
  EXPECT_EQ(client.status()->axes[0].following, 1U);
}

TEST(StreamSession, CountsWhatItRefuses) {
  Line line;
  auto client = line.client({.axes = {"x"}, .power = true});
  EXPECT_TRUE(client.send(0ms, std::array{AxisTarget{}}));
  line.run(1ms);
  EXPECT_TRUE(client.send(10ms, std::array{AxisTarget{std::nan("")}}));
  EXPECT_TRUE(client.send(10ms, std::array{AxisTarget{1e9}}));
  EXPECT_TRUE(client.send(10ms, std::array{AxisTarget{}, AxisTarget{}}));
  EXPECT_TRUE(client.send(2h, std::array{AxisTarget{}}));
  EXPECT_TRUE(client.send(-1h, std::array{AxisTarget{}}));
  line.run(1ms);
  const auto status = client.status();
  for (const auto reason : {Refusal::kNotFinite, Refusal::kOutsideRange, Refusal::kAxisCount, Refusal::kTooFarAhead,
                            Refusal::kOutOfOrder}) {
    EXPECT_EQ(status->count(reason), 1U) << to_text(reason);
  }
  EXPECT_EQ(status->taken, 1U);
  line.poll();
  EXPECT_EQ(line.told.size(), 6U) << "one event for each reason";
  EXPECT_THAT(line.told[1], HasSubstr("is not finite; its status counts them"));
}

TEST(StreamSession, TakesABoundedNumberOfRecordsInACycle) {
  Line line;
  auto client = line.client({.axes = {"x"}});
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(client.send(i * 1ms, std::array{AxisTarget{}}));
  line.cycle();
  EXPECT_EQ(client.status()->taken, StreamSession::kRecordsPerCycle);
  line.cycle();
  line.cycle();
  EXPECT_EQ(client.status()->taken, 20U);
  while (client.heartbeat()) continue;
  EXPECT_FALSE(client.heartbeat()) << "the ring is full, and the client knows";
  line.run(10ms);
  EXPECT_TRUE(client.heartbeat());
}

/// The ring of a client that was let in, as a hostile one has it.
class Hostile {
 public:
  explicit Hostile(const std::string& path, Line& line) : socket_(::socket(AF_UNIX, SOCK_SEQPACKET, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy(path.begin(), path.end(), address.sun_path);
    EXPECT_EQ(::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    stream::Hello hello;
    hello.axis_count = 1;
    hello.power = 1;
    hello.axes[0].set("x");
    const auto bytes = stream::to_bytes(hello);
    EXPECT_GT(::send(socket_.get(), bytes.data(), bytes.size(), 0), 0);
    line.poll();
    auto received = stream::client_detail::receive_answer(socket_.get(), 1s);
    auto& answer = std::get<stream::client_detail::Received>(received);
    auto opened = rt::SharedMapping::open(answer.descriptors[0].get(), stream::setpoint_ring());
    memory.emplace(std::move(std::get<rt::SharedMapping>(opened)));
    EXPECT_EQ(::ftruncate(answer.descriptors[0].get(), 0), -1) << "the size is sealed";
    auto status = rt::SharedMapping::open(answer.descriptors[1].get(), stream::status_broadcast());
    broadcast.emplace(std::move(std::get<rt::SharedMapping>(status)));
  }
  std::optional<rt::SharedMapping> memory;
  std::optional<rt::SharedMapping> broadcast;

 private:
  port::FileDescriptor socket_;
};

TEST(StreamSession, SurvivesAnythingInItsMemory) {
  Line line;
  auto decent = line.client({.axes = {"y"}, .power = true});
  const Hostile hostile(line.path, line);
  rt::SharedBroadcastReader<StatusRecord> status(*hostile.broadcast);
  std::mt19937_64 random(5);
  const auto words = hostile.memory->words();
  int sent = 0;
  for (int round = 0; round < 400; ++round) {
    for (int i = 0; i < 200; ++i) words[random() % words.size()] = random();
    words[rt::shared_detail::kHeadWord] =
        round % 3 == 0 ? random() : words[rt::shared_detail::kTailWord] + random() % 9;
    if (round % 2 == 0) {
      // Records that are nearly right.
      for (std::size_t at = rt::shared_detail::kRecordsWord; at + 51 <= words.size(); at += 51) {
        words[at] = static_cast<std::uint64_t>(round);
        words[at + 1] = 1 | std::uint64_t{1} << 32U;
        words[at + 2] = random() % 100'000'000;
      }
    }
    stream_swing(line, decent, 8, 8, sent);
    line.poll();
    const auto& demand = line.axes.all[0].view.setpoint;
    ASSERT_TRUE(std::isfinite(demand) && std::abs(demand) <= 100.0);
  }
  StatusRecord record;
  ASSERT_TRUE(status.latest(record));
  EXPECT_GT(record.count(Refusal::kImpossibleIndex), 100U);
  const auto good = decent.status();
  ASSERT_TRUE(good);
  EXPECT_EQ(good->taken, static_cast<std::uint64_t>(sent)) << "the neighbour is as it was";
  EXPECT_EQ(good->starved, 0U);
}

TEST(StreamSession, AClientThatIsKilledAnywhereLeavesAWholeLine) {
  Line line;
  std::mt19937_64 random(17);
  for (int life = 0; life < 30; ++life) {
    const auto child = ::fork();
    if (child == 0) {
      auto connected = stream::Client::connect(line.path, {.name = "doomed", .axes = {"x"}, .power = true});
      auto* client = std::get_if<stream::Client>(&connected);
      for (std::int64_t i = 0; client != nullptr; ++i) {
        const auto target = swing(1e-3 * static_cast<double>(i));
        client->send(i * 1ms, std::array{target});
        std::this_thread::sleep_for(100us);
      }
      ::_exit(1);
    }
    const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds{random() % 30'000};
    while (std::chrono::steady_clock::now() < end) {
      line.poll();
      line.run(1ms);
      std::this_thread::sleep_for(100us);
    }
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    // Its connection may still have been waiting.
    for (int i = 0; i < 20; ++i) {
      line.poll();
      line.run(5ms);
    }
    line.poll();
    ASSERT_TRUE(line.server->idle()) << "life " << life;
  }
  EXPECT_EQ(line.client({.axes = {"x"}}).axis_count(), 1U);
}

}  // namespace
}  // namespace driveline::runtime

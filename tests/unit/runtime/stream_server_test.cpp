// How programs that stream setpoints are admitted, and what they are told.
#include "stream/stream_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "driveline/runtime/axes/axis_authority.hpp"
#include "driveline/stream/client.hpp"
#include "stream_line.hpp"
#include "support/must.hpp"

namespace driveline::runtime {
namespace {

using namespace std::chrono_literals;
using stream::MotionState;
using stream::SessionState;
using testing::HasSubstr;

TEST(StreamServer, GivesAxesToAClientThatAsks) {
  StreamLine line;
  auto client = line.client({.name = "sine", .axes = {"y", "x"}});
  EXPECT_EQ(client.line().period_ns, 125'000);
  EXPECT_EQ(client.line().keep_alive_ns, 100'000'000);
  EXPECT_EQ(client.line().bounds[1].max_velocity, 10.0);
  line.run(1ms);
  const auto status = must(client.status());
  EXPECT_EQ(status->state, SessionState::kWaiting);
  EXPECT_EQ(status->axis_count, 2U);
  EXPECT_EQ(status->cycle, line.number);
  line.poll();
  ASSERT_FALSE(line.told.empty());
  EXPECT_THAT(line.told.back(), HasSubstr("stream client \"sine\" (process "));
  EXPECT_THAT(line.told.back(), HasSubstr("has y, x"));
}

TEST(StreamServer, SignalsDoNotEndTheWaitOfAClient) {
  StreamLine line;
  struct sigaction action = {};
  action.sa_handler = [](int) {};
  struct sigaction before = {};
  sigaction(SIGUSR1, &action, &before);
  std::variant<stream::Client, std::string> connected = "not yet";
  std::thread waiting([&] { connected = stream::Client::connect(line.path, {.name = "sine", .axes = {"x"}}, 100s); });
  for (int i = 0; i < 100; ++i) {
    pthread_kill(waiting.native_handle(), SIGUSR1);
    std::this_thread::sleep_for(1ms);
  }
  line.beside([&] {
    waiting.join();
    return true;
  });
  // The last signal may have been delayed until its thread ran.
  sigaction(SIGUSR1, &before, nullptr);
  const auto* refusal = std::get_if<std::string>(&connected);
  EXPECT_EQ(refusal, nullptr) << *refusal;
}

TEST(StreamServer, AnAxisHasOneClient) {
  StreamLine line;
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
  EXPECT_THAT(line.told.back(), HasSubstr("its connection is closed: 0 setpoints; its axes are free"));
  const auto again = line.client({.axes = {"x"}});
  EXPECT_EQ(again.axis_count(), 1U);
}

TEST(StreamServer, TwoClientsOfOneNameInOneProcessAreTwo) {
  StreamLine line;
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
  StreamLine line;
  ASSERT_TRUE(line.take(0, "hand"));
  line.axes.all[0].view.state = MotionState::kContinuousMotion;
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

TEST(StreamServer, WhoIsSentAwayHasTakenNothingFromAnybody) {
  StreamLine line;
  ASSERT_TRUE(line.take(0, "hand"));
  const auto first = line.client({.name = "same", .axes = {"y"}});
  static_cast<void>(line.authority.take_changes());
  EXPECT_THAT(line.refusal({.name = "same", .axes = {"x", "y"}, .take_over = true}),
              HasSubstr("axis y: is commanded by"));
  EXPECT_EQ(line.authority.owner_of(0), "hand");
  EXPECT_TRUE(line.authority.losses({}).empty());
  EXPECT_TRUE(line.authority.take_changes().empty());
}

TEST(StreamServer, NobodyStreamsToAxesThatAreMovedTogether) {
  StreamLine line;
  LeaseTerms path;
  path.owner = "path";
  path.firm = true;
  ASSERT_TRUE(line.authority.take(0, path));
  EXPECT_THAT(line.refusal({.axes = {"x"}, .take_over = true}), HasSubstr("axis x: is moved by the path of this run"));
}

TEST(StreamServer, RefusesWithASentence) {
  StreamLine line;
  EXPECT_EQ(line.refusal({.axes = {"w"}}), "there is no axis \"w\" for streams, there are x, y, z");
  EXPECT_EQ(line.refusal({.axes = {"x", "x"}}), "axis x is named twice");
  EXPECT_THAT(line.told.back(), HasSubstr("was rejected: there is no axis \"w\""));
}

/// A hand-made client, for cases that the header does not support.
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
  rt::FileDescriptor socket_;
};

TEST(StreamServer, AnswersWhatIsNoGreeting) {
  StreamLine line;
  const RawClient nonsense(line.path);
  const std::array<std::byte, 5000> bytes{};
  nonsense.send(bytes);
  line.poll();
  EXPECT_EQ(nonsense.refusal(), "its first message is not a Hello of version 2");
  const RawClient newer(line.path);
  stream::Hello hello;
  hello.version = 3;
  newer.send(stream::to_bytes(hello));
  line.poll();
  EXPECT_EQ(newer.refusal(), "it uses version 3 of the stream protocol, the line uses version 2");
  const RawClient many(line.path);
  hello.version = stream::kVersion;
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

TEST(StreamServer, OneWhoDoesNotConfirmItsMemoryHasTakenNothing) {
  StreamLine line;
  stream::Hello hello;
  hello.axis_count = 1;
  hello.take_over = 1;
  hello.axes[0].set("x");
  ASSERT_TRUE(line.take(0, "hand"));
  const RawClient client(line.path);
  client.send(stream::to_bytes(hello));
  line.poll();
  EXPECT_EQ(client.refusal(), "") << "accepted so far";
  line.run(1ms);
  line.poll();
  EXPECT_EQ(line.authority.owner_of(0), "hand");
  client.send(stream::to_bytes(hello));
  line.poll();
  EXPECT_EQ(client.refusal(), "it has not confirmed that it has mapped its memory");
  EXPECT_EQ(line.authority.owner_of(0), "hand");
  EXPECT_TRUE(line.server->idle());
}

/// Two clients are accepted for one axis as long as neither has confirmed its memory: the first to do so has it.
TEST(StreamServer, TheFirstToConfirmItsMemoryHasTheAxis) {
  StreamLine line;
  stream::Hello hello;
  hello.axis_count = 1;
  hello.axes[0].set("x");
  const RawClient first(line.path);
  const RawClient second(line.path);
  first.send(stream::to_bytes(hello));
  second.send(stream::to_bytes(hello));
  line.poll();
  EXPECT_EQ(first.refusal(), "");
  EXPECT_EQ(second.refusal(), "");
  second.send(stream::to_bytes(stream::Mapped{}));
  line.poll();
  EXPECT_EQ(second.refusal(), "");
  EXPECT_NE(line.authority.owner_of(0), "");
  first.send(stream::to_bytes(stream::Mapped{}));
  line.poll();
  EXPECT_THAT(first.refusal(), HasSubstr("axis x: is commanded by stream client"));
}

TEST(StreamServer, OneWhoSaysNothingIsSentAway) {
  StreamLine line;
  std::vector<std::unique_ptr<RawClient>> silent;
  for (int i = 0; i < 20; ++i) {
    silent.push_back(std::make_unique<RawClient>(line.path));
    line.poll();
  }
  EXPECT_EQ(silent.back()->refusal(), "too many clients connect at the same time");
  EXPECT_EQ(line.refusal({.axes = {"x"}}), "too many clients connect at the same time")
      << "also said to one who speaks at once";
  std::this_thread::sleep_for(1100ms);
  line.poll();
  EXPECT_EQ(silent.front()->refusal(), "it sent no Hello in time");
  EXPECT_EQ(line.client({.axes = {"x"}}).axis_count(), 1U);
}

TEST(StreamServer, ReplacesTheSocketOfARunThatDiedButNotOfOneThatLives) {
  StreamLine line;
  StreamConfig config;
  config.socket = line.path;
  EXPECT_THAT(failure_text(StreamServer::open(config, {}, line.hub, line.authority, kPeriod)),
              HasSubstr("another process listens there"));
  const auto file = (line.folder.path / "old.sock").string();
  {
    const rt::FileDescriptor old{::socket(AF_UNIX, SOCK_SEQPACKET, 0)};
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy(file.begin(), file.end(), address.sun_path);
    ASSERT_EQ(::bind(old.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  config.socket = file;
  const auto opened = must(StreamServer::open(config, {}, line.hub, line.authority, kPeriod));
  struct stat status {};
  ASSERT_EQ(::stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U) << "nobody else may connect";
}

}  // namespace
}  // namespace driveline::runtime

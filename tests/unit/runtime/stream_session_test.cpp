// The handling of a stream's setpoints, axes and memory.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <variant>

#include "driveline/runtime/axes/axis_authority.hpp"
#include "driveline/stream/client.hpp"
#include "stream_line.hpp"
#include "support/must.hpp"

namespace driveline::runtime {
namespace {

using namespace std::chrono_literals;
using stream::AxisTarget;
using stream::EndReason;
using stream::MotionState;
using stream::Refusal;
using stream::SessionState;
using stream::StatusRecord;
using testing::HasSubstr;

TEST(StreamSession, FollowsTheSetpointsOnTheirTime) {
  for (const int step : {1, 8}) {
    StreamLine line;
    auto client = line.client({.axes = {"x", "y"}, .power = true});
    int sent = 0;
    stream_swing(line, client, 8000, step, sent);
    const auto status = must(client.status());
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
  StreamLine line;
  auto client = line.client({.axes = {"x"}, .power = true});
  int sent = 0;
  stream_swing(line, client, 80 * 5, 8, sent);
  for (int i = 0; i < 5; ++i) {
    client.heartbeat();
    line.run(50ms);
  }
  auto status = must(client.status());
  EXPECT_EQ(status->state, SessionState::kStarved);
  EXPECT_EQ(status->starved, 1U);
  EXPECT_EQ(status->axes[0].following, 1U);
  const auto held = status->axes[0].setpoint;
  EXPECT_LE(largest_step(line.axes.all[0].demands), 6.3 * 125e-6) << "it has stopped without a leap";
  client.heartbeat();
  line.run(10ms);
  EXPECT_EQ(line.axes.all[0].view.setpoint, held);
  line.poll();
  EXPECT_THAT(line.told.back(), HasSubstr("has no setpoints left: its axes come to rest until more arrive"));
  // The next setpoints are a restart, at any time.
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
  StreamLine line;
  auto client = line.client({.name = "stopped", .axes = {"x", "z"}, .power = true});
  int sent = 0;
  stream_swing(line, client, 80 * 5, 8, sent);
  line.run(99ms);
  EXPECT_EQ(client.status()->reason, EndReason::kNone);
  line.run(2ms);
  EXPECT_EQ(client.status()->reason, EndReason::kSilent);
  line.run(10ms);
  EXPECT_EQ(client.status()->state, SessionState::kOver);
  EXPECT_EQ(line.axes.all[0].view.state, MotionState::kStandstill);
  line.poll();
  EXPECT_THAT(line.told.back(), HasSubstr("it was silent for longer than the keep-alive time: 50 setpoints"));
  EXPECT_EQ(line.authority.owner_of(0), "");
  EXPECT_EQ(line.client({.axes = {"x"}}).axis_count(), 1U);
  // The client may continue to write, but it is ignored.
  EXPECT_TRUE(client.heartbeat());
  EXPECT_EQ(client.status()->state, SessionState::kOver);
}

TEST(StreamSession, EndsWhenTheClientWantsItSo) {
  StreamLine line;
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
  StreamLine line;
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
  StreamLine line;
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
  StreamLine line;
  auto client = line.client({.name = "sine", .axes = {"x", "y"}, .power = true});
  int sent = 0;
  stream_swing(line, client, 80 * 5, 8, sent);
  EXPECT_EQ(client.status()->axes[1].leased, 1U);
  ASSERT_TRUE(line.take(1, "hand", true));
  stream_swing(line, client, 80 * 5, 8, sent);
  EXPECT_EQ(client.status()->axes[0].following, 1U) << "each axis by itself";
  EXPECT_EQ(client.status()->axes[1].following, 0U);
  EXPECT_EQ(client.status()->axes[1].leased, 0U);
  EXPECT_EQ(line.axes.all[1].view.state, MotionState::kStandstill);
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
  StreamLine line;
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
  StreamLine line;
  auto client = line.client({.axes = {"x"}});
  int sent = 0;
  stream_swing(line, client, 80 * 5, 8, sent);
  EXPECT_EQ(client.status()->axes[0].state, MotionState::kDisabled);
  EXPECT_EQ(client.status()->axes[0].following, 0U);
  line.axes.all[0].view.state = MotionState::kStandstill;
  stream_swing(line, client, 80, 8, sent);
  EXPECT_EQ(client.status()->axes[0].following, 1U);
}

TEST(StreamSession, CountsWhatItRefuses) {
  StreamLine line;
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
  EXPECT_THAT(line.told[1],
              HasSubstr("is not finite: axis x: position nan deg; the status of the client counts such setpoints"));
}

TEST(StreamSession, TheFirstSetpointThatIsRefusedIsToldWithAxisValueAndLimit) {
  StreamLine line;
  auto client = line.client({.axes = {"y", "x"}, .power = true});
  EXPECT_TRUE(client.send(0ms, std::array<AxisTarget, 2>{}));
  line.run(1ms);
  EXPECT_TRUE(client.send(10ms, std::array{AxisTarget{}, AxisTarget{101.0}}));
  EXPECT_TRUE(client.send(10ms, std::array{AxisTarget{-200.0}, AxisTarget{}}));
  EXPECT_TRUE(client.send(10ms, std::array{AxisTarget{0.0, 11.0}, AxisTarget{}}));
  EXPECT_TRUE(client.send(10ms, std::array{AxisTarget{0.0, 12.0}, AxisTarget{}}));
  line.run(1ms);
  line.poll();
  line.poll();
  ASSERT_EQ(line.told.size(), 3U) << "the first one of each reason";
  EXPECT_THAT(line.told[1],
              HasSubstr("too fast for an axis: axis y: velocity 630.254 deg/s, allowed are -572.958 deg/s to "
                        "572.958 deg/s; the status of the client counts such setpoints"));
  EXPECT_THAT(line.told[2],
              HasSubstr("outside the range of an axis: axis x: position 5786.87 deg, allowed are -5729.58 deg to "
                        "5729.58 deg; the status of the client counts such setpoints"));
  EXPECT_EQ(client.status()->count(Refusal::kTooFast), 2U);
  EXPECT_EQ(client.status()->count(Refusal::kOutsideRange), 2U);
}

TEST(StreamSession, TakesABoundedNumberOfRecordsInACycle) {
  StreamLine line;
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

/// The ring of an admitted client, as a hostile one uses it.
class Hostile {
 public:
  Hostile(const std::string& path, StreamLine& line, bool punch_first = false)
      : socket_(::socket(AF_UNIX, SOCK_SEQPACKET, 0)) {
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
    ring = std::move(answer.descriptors[0]);
    auto opened = rt::SharedMapping::open(ring.get(), stream::setpoint_ring(), rt::SharedSealing::kSizeOnly);
    memory.emplace(std::move(std::get<rt::SharedMapping>(opened)));
    EXPECT_EQ(::ftruncate(ring.get(), 0), -1) << "the size is sealed";
    if (punch_first) {
      EXPECT_TRUE(punch()) << "the line cannot prevent it before the client has mapped its memory";
    }
    auto status = rt::SharedMapping::open(answer.descriptors[1].get(), stream::status_broadcast());
    broadcast.emplace(std::move(std::get<rt::SharedMapping>(status)));
    const auto mapped = stream::to_bytes(stream::Mapped{});
    EXPECT_GT(::send(socket_.get(), mapped.data(), mapped.size(), 0), 0);
    line.poll();
    const auto begun = stream::client_detail::receive_answer(socket_.get(), 1s);
    EXPECT_TRUE(std::holds_alternative<stream::client_detail::Received>(begun));
  }
  /// Returns the memory of the ring to the system. False: not permitted.
  [[nodiscard]] bool punch() const {
    return ::fallocate(ring.get(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, size()) == 0;
  }
  [[nodiscard]] off_t size() const { return static_cast<off_t>(memory->words().size_bytes()); }
  stream::client_detail::Descriptor ring{};
  std::optional<rt::SharedMapping> memory;
  std::optional<rt::SharedMapping> broadcast;

 private:
  rt::FileDescriptor socket_;
};

/// A page that was returned to the system would delay the cycle by a page fault at the next access.
TEST(StreamSession, AClientCannotReturnTheMemoryOfItsRing) {
  StreamLine line;
  const Hostile hostile(line.path, line, true);
  struct stat status = {};
  ASSERT_EQ(::fstat(hostile.ring.get(), &status), 0);
  EXPECT_EQ(status.st_blocks * 512, hostile.size()) << "what the client had returned is allocated again";
  const auto is_refused = [](int result) { return result == -1 && errno == EPERM; };
  EXPECT_FALSE(hostile.punch());
  const auto words = hostile.memory->words();
  EXPECT_TRUE(is_refused(::madvise(words.data(), words.size_bytes(), MADV_REMOVE)));
  EXPECT_EQ(::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, hostile.ring.get(), 0), MAP_FAILED);
  EXPECT_TRUE(is_refused(::fcntl(hostile.ring.get(), F_ADD_SEALS, F_SEAL_WRITE)));
  ASSERT_EQ(::fstat(hostile.ring.get(), &status), 0);
  EXPECT_EQ(status.st_blocks * 512, hostile.size());
}

TEST(StreamSession, SurvivesAnythingInItsMemory) {
  StreamLine line;
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
      // Almost correct records.
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
  const auto good = must(decent.status());
  EXPECT_EQ(good->taken, static_cast<std::uint64_t>(sent)) << "the neighbour is as it was";
  EXPECT_EQ(good->starved, 0U);
}

TEST(StreamSession, AClientThatIsKilledAnywhereLeavesAWholeLine) {
  StreamLine line;
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
    // Its connection may still have been pending.
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

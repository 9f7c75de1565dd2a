#include "driveline/port/capture_port.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <thread>
#include <vector>

#include "driveline/rt_guard/rt_guard.hpp"
#include "support/must.hpp"
#include "support/pcapng_blocks.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::port {
namespace {

using namespace std::chrono_literals;
using namespace pcapng_test;
using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::SizeIs;

constexpr std::uint16_t kFlags = 2;
constexpr std::uint16_t kDropCount = 4;
constexpr std::uint64_t kInbound = 1;
constexpr std::uint64_t kOutbound = 2;

Bytes frame_of(std::size_t size, unsigned seed) {
  Bytes frame(size);
  for (std::size_t i = 0; i < size; ++i) frame[i] = static_cast<std::byte>(seed + i * 13);
  return frame;
}

/// A port that accepts every frame, or returns a given status, and delivers the frames of a test.
class ScriptedPort final : public Port {
 public:
  explicit ScriptedPort(const rt::Clock& clock) : clock_{clock} {}

  SendStatus send(std::span<const std::byte>) noexcept override {
    if (status == SendStatus::kSent) last_send_time_ = clock_.now();
    return status;
  }
  std::optional<ReceivedFrame> receive() noexcept override {
    if (next_ == arriving.size()) return std::nullopt;
    return ReceivedFrame{arriving[next_++], clock_.now()};
  }
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override {
    waited_for = deadline;
    return next_ != arriving.size();
  }
  std::chrono::nanoseconds last_send_time() const noexcept override { return last_send_time_; }

  SendStatus status = SendStatus::kSent;
  std::vector<Bytes> arriving;
  std::chrono::nanoseconds waited_for{};

 private:
  const rt::Clock& clock_;
  std::size_t next_ = 0;
  std::chrono::nanoseconds last_send_time_{};
};

class CapturePortTest : public ::testing::Test {
 protected:
  CaptureConfig config() const { return {.file = file(), .interface_name = "test", .unix_time_of_zero = 1000s}; }
  std::filesystem::path file() const { return folder.path / "capture.pcapng"; }

  std::unique_ptr<CapturePort> open(const CaptureConfig& configuration) {
    auto port = CapturePort::open(inner, clock, configuration);
    EXPECT_TRUE(port) << port.error().message;
    return port ? std::move(*port) : nullptr;
  }

  rt::VirtualClock clock{5s};
  ScriptedPort inner{clock};
  test::TemporaryFolder folder;
};

TEST_F(CapturePortTest, FileHoldsWhatWasSentAndReceivedWithDirectionAndTime) {
  const auto port = open(config());
  const Bytes request = frame_of(61, 1);
  const Bytes answer = frame_of(1518, 2);
  inner.arriving = {answer};

  clock.advance(7ns);
  EXPECT_EQ(port->send(request), SendStatus::kSent);
  clock.advance(40us);
  const auto received = must(port->receive());
  EXPECT_THAT(received->bytes, ElementsAreArray(answer));
  EXPECT_EQ(received->time, 5s + 7ns + 40us);
  EXPECT_FALSE(port->receive());

  const auto report = must(port->close());
  EXPECT_EQ(report->frames, 2U);
  EXPECT_EQ(report->written, 2U);
  EXPECT_EQ(report->dropped, 0U);

  const auto packets = pcapng_packets(read_bytes(file()));
  ASSERT_THAT(packets, SizeIs(2));
  EXPECT_EQ(packets[0].frame, request);
  EXPECT_EQ(packets[0].time_ns, 1'005'000'000'007U);
  EXPECT_THAT(packets[0].options, ElementsAre(Pair(kFlags, kOutbound)));
  EXPECT_EQ(packets[1].frame, answer);
  EXPECT_EQ(packets[1].time_ns, 1'005'000'040'007U);
  EXPECT_THAT(packets[1].options, ElementsAre(Pair(kFlags, kInbound)));
}

TEST_F(CapturePortTest, BlocksComeInTheirOrder) {
  const auto port = open(config());
  EXPECT_EQ(port->send(frame_of(60, 0)), SendStatus::kSent);
  ASSERT_TRUE(port->close());
  std::vector<std::uint32_t> types;
  for (const PcapngBlock& block : pcapng_blocks(read_bytes(file()))) types.push_back(block.type);
  EXPECT_THAT(types, ElementsAre(0x0A0D0D0AU, 1U, 6U, 5U));
}

TEST_F(CapturePortTest, RefusedFramesAreNotInTheFile) {
  const auto port = open(config());
  for (const auto status : {SendStatus::kLinkDown, SendStatus::kBusy, SendStatus::kTooLong}) {
    inner.status = status;
    EXPECT_EQ(port->send(frame_of(60, 0)), status);
  }
  const auto report = must(port->close());
  EXPECT_EQ(report->frames, 0U);
  EXPECT_THAT(pcapng_packets(read_bytes(file())), IsEmpty());
}

TEST_F(CapturePortTest, EverythingElseIsPassedThrough) {
  const auto port = open(config());
  EXPECT_FALSE(port->wait_readable(42ns));
  EXPECT_EQ(inner.waited_for, 42ns);
  inner.arriving = {frame_of(60, 0)};
  EXPECT_TRUE(port->wait_readable(43ns));
  clock.advance(1us);
  EXPECT_EQ(port->send(frame_of(60, 0)), SendStatus::kSent);
  EXPECT_EQ(port->last_send_time(), 5s + 1us);
}

TEST_F(CapturePortTest, AfterCloseFramesOnlyPass) {
  const auto port = open(config());
  ASSERT_TRUE(port->close());
  const Bytes before = read_bytes(file());
  inner.arriving = {frame_of(60, 0)};
  EXPECT_EQ(port->send(frame_of(60, 1)), SendStatus::kSent);
  EXPECT_TRUE(port->receive());
  const auto again = must(port->close());
  EXPECT_EQ(again->frames, 0U);
  EXPECT_EQ(read_bytes(file()), before);
}

TEST_F(CapturePortTest, LongCaptureIsCompleteAndInOrder) {
  const auto port = open(config());
  constexpr unsigned kFrames = 10'000;
  for (unsigned i = 0; i < kFrames; ++i) {
    // The writer is an ordinary thread: wait for it.
    while (port->statistics().written + 2000 < i) std::this_thread::yield();
    ASSERT_EQ(port->send(frame_of(60 + i % 1000, i)), SendStatus::kSent);
  }
  const auto report = must(port->close());
  EXPECT_EQ(report->dropped, 0U);
  const auto packets = pcapng_packets(read_bytes(file()));
  ASSERT_THAT(packets, SizeIs(kFrames));
  for (unsigned i = 0; i < kFrames; ++i) ASSERT_EQ(packets[i].frame, frame_of(60 + i % 1000, i)) << i;
}

TEST_F(CapturePortTest, SendAndReceiveDoNotAllocate) {
  if (!rt::RtGuard::available()) GTEST_SKIP() << "a sanitizer owns malloc; the guard counts nothing here";
  const auto port = open(config());
  const Bytes frame = frame_of(1514, 3);
  inner.arriving.assign(5000, frame);
  bool passed = true;
  rt::RtGuard::enter();
  for (int i = 0; i < 5000; ++i) {  // more than the ring holds: whether it is full or not, nothing is allocated
    passed = passed && port->send(frame) == SendStatus::kSent && port->receive().has_value();
  }
  EXPECT_EQ(rt::RtGuard::leave().total(), 0U);
  EXPECT_TRUE(passed);
}

TEST_F(CapturePortTest, FullRingDropsCountsAndSaysWhereTheGapIs) {
  // A pipe without a reader stops the writer, so that the ring surely fills.
  ASSERT_EQ(mkfifo(file().c_str(), 0600), 0);
  const rt::FileDescriptor reader{::open(file().c_str(), O_RDONLY | O_NONBLOCK)};
  ASSERT_TRUE(reader.valid());
  const int pipe_bytes = fcntl(reader.get(), F_GETPIPE_SZ);
  ASSERT_GT(pipe_bytes, 0);

  CaptureConfig small = config();
  small.ring_frames = 8;
  const auto port = open(small);
  // More than pipe, ring and the writer's batch hold together, whatever their timing.
  const auto frames = static_cast<unsigned>(pipe_bytes) / 1000 + 8 + 64 + 100;
  for (unsigned i = 0; i < frames; ++i) EXPECT_EQ(port->send(frame_of(1000, i)), SendStatus::kSent);
  const std::uint64_t dropped = port->statistics().dropped;
  EXPECT_GT(dropped, 0U);

  // Now the test reads.
  Bytes content;
  std::thread consumer{[&] {
    std::array<std::byte, 4096> chunk{};
    fcntl(reader.get(), F_SETFL, 0);  // from now on wait for data, until the writer closes the pipe
    for (ssize_t size = 1; size > 0;) {
      size = read(reader.get(), chunk.data(), chunk.size());
      if (size > 0) content.insert(content.end(), chunk.begin(), chunk.begin() + size);
    }
  }};
  // The ring drains; the next accepted frame carries the number of frames lost before it.
  while (port->statistics().written + dropped < frames) std::this_thread::yield();
  EXPECT_EQ(port->send(frame_of(60, 77)), SendStatus::kSent);
  const auto report = port->close();
  consumer.join();

  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->frames, frames + 1);
  EXPECT_EQ(report->dropped, dropped);
  EXPECT_EQ(report->written + report->dropped, report->frames);

  const auto packets = pcapng_packets(content);
  EXPECT_THAT(packets, SizeIs(report->written));
  // The first byte of every frame is its number (modulo 256), so a gap must have exactly the length in the file.
  std::uint64_t expected = 0;
  std::uint64_t noted = 0;
  for (const PcapngPacket& packet : packets) {
    if (packet.options.contains(kDropCount)) {
      expected += packet.options.at(kDropCount);
      noted += packet.options.at(kDropCount);
    }
    const auto seed = static_cast<unsigned>(expected == frames ? 77 : expected);
    ASSERT_EQ(packet.frame[0], static_cast<std::byte>(seed)) << expected;
    ++expected;
  }
  EXPECT_EQ(noted, dropped);
  EXPECT_EQ(pcapng_options(pcapng_blocks(content).back(), 12),
            (std::map<std::uint16_t, std::uint64_t>{{4, report->frames}, {5, dropped}}));
}

TEST_F(CapturePortTest, ReaderOfThePipeLeavingIsAnErrorNotTheEnd) {
  ASSERT_EQ(mkfifo(file().c_str(), 0600), 0);
  rt::FileDescriptor reader{::open(file().c_str(), O_RDONLY | O_NONBLOCK)};
  const auto port = open(config());
  reader = rt::FileDescriptor{};
  EXPECT_EQ(port->send(frame_of(60, 0)), SendStatus::kSent);
  const auto report = port->close();
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().error_number, EPIPE);
}

TEST_F(CapturePortTest, FileThatCannotGrowStaysReadableAndTheLossIsReported) {
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{10'000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto port = open(config());
  for (unsigned i = 0; i < 100; ++i) EXPECT_EQ(port->send(frame_of(1000, i)), SendStatus::kSent);
  const auto report = port->close();
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);

  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, PortErrorCode::kFile);
  EXPECT_EQ(report.error().error_number, EFBIG);
  EXPECT_EQ(report.error().message, "Cannot write capture file '" + file().string() + "': File too large.");
  const CaptureStatistics statistics = port->statistics();
  EXPECT_EQ(statistics.frames, 100U);
  EXPECT_GT(statistics.dropped, 0U);
  EXPECT_EQ(statistics.written + statistics.dropped, 100U);
  EXPECT_THAT(pcapng_packets(read_bytes(file())), SizeIs(statistics.written));  // throws if a block is cut off
}

TEST_F(CapturePortTest, FileThatCannotBeCreatedIsAClearError) {
  CaptureConfig bad = config();
  bad.file = folder.path / "missing" / "capture.pcapng";
  const auto port = CapturePort::open(inner, clock, bad);
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error().code, PortErrorCode::kFile);
  EXPECT_EQ(port.error().message, "Cannot create capture file '" + bad.file.string() + "': No such file or directory.");
}

TEST_F(CapturePortTest, FullDiskAtTheStartIsAClearError) {
  CaptureConfig full = config();
  full.file = "/dev/full";
  const auto port = CapturePort::open(inner, clock, full);
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error().message, "Cannot write capture file '/dev/full': No space left on device.");
}

TEST_F(CapturePortTest, TimeIsUnixTimeByDefault) {
  CaptureConfig now = config();
  now.unix_time_of_zero.reset();
  const auto before = std::chrono::system_clock::now().time_since_epoch();
  const auto port = open(now);
  EXPECT_EQ(port->send(frame_of(60, 0)), SendStatus::kSent);
  ASSERT_TRUE(port->close());
  const auto after = std::chrono::system_clock::now().time_since_epoch();
  const std::chrono::nanoseconds time{pcapng_packets(read_bytes(file())).at(0).time_ns};
  EXPECT_GE(time, before);
  EXPECT_LE(time, after);
}

}  // namespace
}  // namespace driveline::port

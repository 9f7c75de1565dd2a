#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <memory>

#include "driveline/rt/clock.hpp"
#include "driveline/slaves/line/simulated_line.hpp"
#include "driveline/wire/frame.hpp"
#include "pcapng_reader.hpp"

namespace driveline::slaves {

using namespace std::chrono_literals;
using Bytes = std::vector<std::byte>;

/// Mailboxes of the recorded drive, an AKD.
inline constexpr std::size_t kMailboxLength = 1024;
inline constexpr std::uint16_t kMailboxOut = 0x1800;
inline constexpr std::uint16_t kMailboxIn = 0x1C00;

struct RecordedDatagram {
  wire::DatagramHeader header;
  Bytes data;
  std::uint16_t working_counter = 0;
};

inline std::vector<RecordedDatagram> datagrams(std::span<const std::byte> frame) {
  std::vector<RecordedDatagram> result;
  auto cursor = wire::DatagramCursor::open(frame);
  while (cursor && !cursor->done()) {
    const auto view = cursor->next();
    if (!view) break;
    result.push_back({view->header, {view->data.begin(), view->data.end()}, view->working_counter()});
  }
  return result;
}

inline bool is_reply(const Bytes& frame) {
  return (frame[6] & std::byte{2}) != std::byte{0};
}

/// A slave that receives the requests that a real master has sent to an AKD.
class RecordedDiscovery : public ::testing::Test {
 protected:
  /// Creates the device from its EEPROM image and the recorded mailbox replies.
  using MakeDevice = std::function<std::unique_ptr<Device>(Bytes image, std::deque<Bytes> replies)>;

  /// Loads capture and image and builds the slave; skips the test if they are missing.
  void load(const char* capture, const char* image_name, const MakeDevice& make_device) {
    const auto image = replay::find_capture(image_name);
    if (!image) GTEST_SKIP() << replay::missing_capture_text(image_name);
    const auto file = replay::find_capture(capture);
    if (!file) GTEST_SKIP() << replay::missing_capture_text(capture);
    auto packets = replay::read_pcapng(*file);
    ASSERT_TRUE(packets) << packets.error();
    packets_ = std::move(*packets);
    std::deque<Bytes> replies;
    for (const auto& packet : packets_) {
      if (!is_reply(packet.bytes)) continue;
      for (const auto& d : datagrams(packet.bytes)) {
        const bool whole = d.header.address.ado() == kMailboxIn && d.data.size() == kMailboxLength;
        if (whole && d.working_counter == 1) replies.push_back(d.data);
      }
    }
    SlaveOptions options;
    options.sii.reads_8_bytes = false;
    std::vector<std::unique_ptr<Slave>> slaves;
    slaves.push_back(std::make_unique<Slave>(make_device(*replay::read_file(*image), std::move(replies)), options));
    line_ = std::make_unique<SimulatedLine>(clock_, std::move(slaves));
  }

  /// Answer of the simulated slave to a recorded request, at the recorded time.
  Bytes answer(const replay::CapturedPacket& request) {
    if (start_ == 0ns) start_ = request.time;
    clock_.sleep_until(1s + (request.time - start_));
    Bytes frame = request.bytes;
    frame.resize(std::max(frame.size(), wire::kMinFrameBytes));  // as the network interface does
    EXPECT_TRUE(line_->process(frame, clock_.now())) << "packet " << request.number;
    return frame;
  }

  /// Replays all recorded requests and compares the working counters of the answers, except for reads of the mailbox:
  /// its content is not replayed, so polls find it empty. Returns the number of comparisons.
  std::size_t compare_overlapping() {
    // Requests and replies overlap: a reply belongs to the oldest request with the same datagram indices.
    std::deque<Bytes> waiting;
    std::size_t compared = 0;
    for (const auto& packet : packets()) {
      if (!is_reply(packet.bytes)) {
        waiting.push_back(answer(packet));
        continue;
      }
      const auto recorded = datagrams(packet.bytes);
      const auto match = std::find_if(waiting.begin(), waiting.end(), [&](const Bytes& own) {
        const auto actual = datagrams(own);
        return std::equal(
            actual.begin(), actual.end(), recorded.begin(), recorded.end(), [](const auto& a, const auto& b) {
              return a.header.command == b.header.command && a.header.index == b.header.index &&
                     a.header.address.ado() == b.header.address.ado() && a.header.length == b.header.length;
            });
      });
      if (match == waiting.end()) continue;
      const auto actual = datagrams(*match);
      waiting.erase(waiting.begin(), match + 1);
      for (std::size_t d = 0; d < actual.size(); ++d) {
        const auto ado = actual[d].header.address.ado();
        if (ado >= kMailboxIn && ado < kMailboxIn + kMailboxLength) continue;
        EXPECT_EQ(actual[d].working_counter, recorded[d].working_counter)
            << "packet " << packet.number << " " << to_text(actual[d].header.command) << " " << std::hex << ado;
        ++compared;
      }
    }
    return compared;
  }

  const std::vector<replay::CapturedPacket>& packets() const { return packets_; }
  Slave& slave() { return line_->slave(0); }

 private:
  rt::VirtualClock clock_{1s};
  std::vector<replay::CapturedPacket> packets_;
  std::unique_ptr<SimulatedLine> line_;
  std::chrono::nanoseconds start_{0};
};

}  // namespace driveline::slaves

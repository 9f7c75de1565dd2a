// A slave emulated from the EEPROM image of a real drive answers what real masters asked that drive: same working
// counters, same addresses, same EEPROM content, frames of the same length.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <set>

#include "driveline/rt/clock.hpp"
#include "driveline/slaves/line/line.hpp"
#include "driveline/wire/frame.hpp"
#include "pcapng_reader.hpp"

namespace driveline::slaves {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::byte>;

constexpr std::size_t kMailboxLength = 1024;
constexpr std::uint16_t kMailboxOut = 0x1800;
constexpr std::uint16_t kMailboxIn = 0x1C00;

/// The recorded drive: its EEPROM, its sync managers, and the mailbox replies it gave.
class RecordedDrive final : public Device {
 public:
  RecordedDrive(Bytes image, std::deque<Bytes> replies) : replies_(std::move(replies)) {
    using Use = SyncManagerLayout::Use;
    profile_.sii_image = std::move(image);
    profile_.sync_managers = {{Use::kMailboxOut, kMailboxOut, 0, 0, kMailboxLength},
                              {Use::kMailboxIn, kMailboxIn, 0, 0, kMailboxLength},
                              {Use::kOutputs, 0x1100, 0, 0, 17},
                              {Use::kInputs, 0x1140, 0, 0, 17}};
    profile_.fmmu_count = 3;
    profile_.sync_manager_count = 4;
    profile_.ram_kib = 4;
  }
  const DeviceProfile& profile() const noexcept override { return profile_; }
  std::size_t process_data_size(std::size_t sync_manager) const noexcept override { return sync_manager >= 2 ? 17 : 0; }
  wire::AlStatusCode transition(wire::AlState, wire::AlState) noexcept override { return wire::AlStatusCode::kNoError; }
  void fall_back(wire::AlState, wire::AlState, wire::AlStatusCode) noexcept override {}
  void write_outputs(std::size_t, std::span<const std::byte>) noexcept override {}
  void read_inputs(std::size_t, std::span<std::byte> data) noexcept override {
    std::fill(data.begin(), data.end(), std::byte{0});
  }
  void mailbox_request(std::span<const std::byte>) override { ++asked_; }
  std::size_t mailbox_reply(std::span<std::byte> out) override {
    if (asked_ == 0 || replies_.empty()) return 0;
    --asked_;
    const Bytes reply = std::move(replies_.front());
    replies_.pop_front();
    std::copy(reply.begin(), reply.end(), out.begin());
    return reply.size();
  }
  void advance(std::chrono::nanoseconds) noexcept override {}
  std::chrono::nanoseconds process_data_period() const noexcept override { return 1ms; }

 private:
  DeviceProfile profile_;
  std::deque<Bytes> replies_;
  int asked_ = 0;
};

struct Datagram {
  wire::DatagramHeader header;
  Bytes data;
  std::uint16_t working_counter = 0;
};

std::vector<Datagram> datagrams(std::span<const std::byte> frame) {
  std::vector<Datagram> result;
  auto cursor = wire::DatagramCursor::open(frame);
  while (cursor && !cursor->done()) {
    const auto view = cursor->next();
    if (!view) break;
    result.push_back({view->header, {view->data.begin(), view->data.end()}, view->working_counter()});
  }
  return result;
}

bool is_reply(const Bytes& frame) {
  return (frame[6] & std::byte{2}) != std::byte{0};
}

class RecordedDiscovery : public ::testing::Test {
 protected:
  /// Loads capture and image and builds the slave; skips without them.
  void load(const char* capture) {
    const auto image = replay::find_capture("akd.hex");
    if (!image) GTEST_SKIP() << replay::missing_capture_text("akd.hex");
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
    slaves.push_back(std::make_unique<Slave>(
        std::make_unique<RecordedDrive>(*replay::read_file(*image), std::move(replies)), options));
    line_ = std::make_unique<Line>(clock_, std::move(slaves));
  }

  /// What our slave makes of a recorded request, at the recorded time.
  Bytes answer(const replay::CapturedPacket& request) {
    if (start_ == 0ns) start_ = request.time;
    clock_.sleep_until(1s + (request.time - start_));
    Bytes frame = request.bytes;
    frame.resize(std::max(frame.size(), wire::kMinFrameBytes));  // as the network interface does
    EXPECT_TRUE(line_->process(frame, clock_.now())) << "packet " << request.number;
    return frame;
  }

  const std::vector<replay::CapturedPacket>& packets() const { return packets_; }

 private:
  rt::VirtualClock clock_{1s};
  std::vector<replay::CapturedPacket> packets_;
  std::unique_ptr<Line> line_;
  std::chrono::nanoseconds start_{0};
};

/// Registers whose content is the recorded hardware's own: controller type, link state, clock, EEPROM emulation, and
/// those that depend on how fast its firmware was.
bool is_own_content(std::uint16_t ado) {
  return ado < 0x0010 || ado == 0x0110 || ado == 0x0111 || ado == 0x0130 || ado == 0x0140 || ado == 0x0502 ||
         (ado >= 0x0800 && ado < 0x0A00);
}

TEST_F(RecordedDiscovery, SoemScansTheDrive) {
  load("soem-sdinfo-akd.pcapng");
  if (IsSkipped()) return;
  // Packet 5: a second AL control write 0.5 ms after the first one, which the drive's firmware had not read by then.
  // Our firmware reads it at once.
  const std::set<std::size_t> faster = {5};
  std::size_t compared = 0;
  std::size_t mailboxes = 0;
  for (std::size_t i = 0; i + 1 < packets().size(); ++i) {
    const auto& request = packets()[i];
    if (is_reply(request.bytes)) continue;
    const auto& recorded = packets()[i + 1];
    const auto own = answer(request);
    const auto expected = datagrams(recorded.bytes);
    const auto actual = datagrams(own);
    if (!is_reply(recorded.bytes) || expected.size() != actual.size()) continue;  // lost in the recording
    EXPECT_EQ(own.size(), recorded.bytes.size()) << "packet " << request.number;
    for (std::size_t d = 0; d < actual.size(); ++d) {
      const auto ado = actual[d].header.address.ado();
      ASSERT_EQ(actual[d].header.index, expected[d].header.index) << "packet " << request.number;
      EXPECT_EQ(actual[d].header.address.adp(), expected[d].header.address.adp()) << "packet " << request.number;
      if (!faster.contains(request.number)) {
        EXPECT_EQ(actual[d].working_counter, expected[d].working_counter)
            << "packet " << request.number << " " << to_text(actual[d].header.command) << " " << std::hex << ado;
      }
      if (!is_own_content(ado)) {
        EXPECT_EQ(actual[d].data, expected[d].data) << "packet " << request.number << std::hex << " " << ado;
      }
      if (ado == kMailboxIn) ++mailboxes;
      ++compared;
    }
  }
  EXPECT_GT(compared, 3000U);
  EXPECT_EQ(mailboxes, 35U);
}

TEST_F(RecordedDiscovery, TwinCatStartsTheDriveUp) {
  load("twincat-akd-nc-mode.pcapng");
  if (IsSkipped()) return;
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
      return std::equal(actual.begin(), actual.end(), recorded.begin(), recorded.end(),
                        [](const auto& a, const auto& b) {
                          return a.header.command == b.header.command && a.header.index == b.header.index &&
                                 a.header.address.ado() == b.header.address.ado() && a.header.length == b.header.length;
                        });
    });
    if (match == waiting.end()) continue;
    const auto actual = datagrams(*match);
    waiting.erase(waiting.begin(), match + 1);
    for (std::size_t d = 0; d < actual.size(); ++d) {
      const auto ado = actual[d].header.address.ado();
      // The mailbox content is not replayed here: who polls an empty mailbox finds it empty.
      if (ado >= kMailboxIn && ado < kMailboxIn + kMailboxLength) continue;
      EXPECT_EQ(actual[d].working_counter, recorded[d].working_counter)
          << "packet " << packet.number << " " << to_text(actual[d].header.command) << " " << std::hex << ado;
      ++compared;
    }
  }
  EXPECT_GT(compared, 8000U);
}

TEST(RecordedImages, AreLoadedByTheController) {
  struct Row {
    const char* file;
    bool device_emulation;
  };
  // The output terminal has no application: its controller follows AL control by itself.
  for (const auto& row : {Row{"akd.hex", false}, Row{"ek1100.hex", true}, Row{"el2004-eeprom-dump.bin", true}}) {
    const auto file = replay::find_capture(row.file);
    if (!file) GTEST_SKIP() << replay::missing_capture_text(row.file);
    const Esc esc({}, *replay::read_file(*file));
    EXPECT_TRUE(esc.pdi_operational()) << row.file;
    EXPECT_EQ(esc.device_emulation(), row.device_emulation) << row.file;
  }
}

}  // namespace
}  // namespace driveline::slaves

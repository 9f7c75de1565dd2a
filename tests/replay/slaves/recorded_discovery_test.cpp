// A slave emulated from the EEPROM image of a real drive answers what real masters asked that drive: same working
// counters, same addresses, same EEPROM content, frames of the same length.
#include <set>

#include "recorded_discovery.hpp"

namespace driveline::slaves {
namespace {

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

std::unique_ptr<Device> recorded_drive(Bytes image, std::deque<Bytes> replies) {
  return std::make_unique<RecordedDrive>(std::move(image), std::move(replies));
}

/// Registers with content specific to the recorded hardware: controller type, link state, clock, EEPROM emulation, and
/// registers that depend on the speed of its firmware.
bool is_own_content(std::uint16_t ado) {
  return ado < 0x0010 || ado == 0x0110 || ado == 0x0111 || ado == 0x0130 || ado == 0x0140 || ado == 0x0502 ||
         (ado >= 0x0800 && ado < 0x0A00);
}

TEST_F(RecordedDiscovery, SoemScansTheDrive) {
  load("soem-sdinfo-akd.pcapng", "akd.hex", recorded_drive);
  if (IsSkipped()) return;
  // Packet 5: a second AL control write 0.5 ms after the first one, which the drive's firmware had not yet read. The
  // simulated firmware reads it at once.
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
  load("twincat-akd-nc-mode.pcapng", "akd.hex", recorded_drive);
  if (IsSkipped()) return;
  EXPECT_GT(compare_overlapping(), 8000U);
}

TEST(RecordedImages, AreLoadedByTheController) {
  struct Row {
    const char* file;
    bool device_emulation;
  };
  // The output terminal has no application: its controller follows AL control on its own.
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

// Devices emulated from nothing but the EEPROM images of real ones answer the requests of real masters: with the
// recorded working counters, and with the content of their EEPROM.
#include <set>

#include "driveline/esi/sii.hpp"
#include "driveline/slaves/generic/generic_device.hpp"
#include "recorded_discovery.hpp"

namespace driveline::slaves {
namespace {

std::unique_ptr<Device> from_image(Bytes image, const std::deque<Bytes>& /*replies*/) {
  const auto decoded = esi::decode_sii(image);
  EXPECT_TRUE(decoded) << esi::to_text(decoded.error());
  const auto model = generic::DeviceModel::create(esi::description_from_sii(*decoded));
  EXPECT_TRUE(model) << describe(model.error());
  generic::GenericOptions options;
  options.sii_image = std::move(image);
  return std::make_unique<generic::GenericDevice>(*model, options);
}

class GenericDiscovery : public RecordedDiscovery {
 protected:
  /// Replays all recorded requests; compares the working counters except for the packets in `other`. `mailbox` false:
  /// the device has none, and the content of the recorded memory there is not compared either.
  std::size_t compare(const std::set<std::size_t>& other, bool mailbox) {
    std::size_t compared = 0;
    for (std::size_t i = 0; i + 1 < packets().size(); ++i) {
      const auto& request = packets()[i];
      if (is_reply(request.bytes)) continue;
      const auto own = answer(request);
      const auto expected = datagrams(packets()[i + 1].bytes);
      const auto actual = datagrams(own);
      if (!is_reply(packets()[i + 1].bytes) || expected.size() != actual.size()) continue;  // lost in the recording
      for (std::size_t d = 0; d < actual.size(); ++d) {
        const bool memory = actual[d].header.address.ado() >= wire::kProcessRamStart;
        if (other.contains(request.number) || (memory && !mailbox)) continue;
        EXPECT_EQ(actual[d].working_counter, expected[d].working_counter)
            << "packet " << request.number << " " << to_text(actual[d].header.command) << " " << std::hex
            << actual[d].header.address.ado();
        ++compared;
      }
    }
    return compared;
  }
};

TEST_F(GenericDiscovery, SoemScansAnAkdMadeOfItsEeprom) {
  load("soem-sdinfo-akd.pcapng", "akd.hex", from_image);
  if (IsSkipped()) return;
  // Packet 5: see RecordedDiscovery.SoemScansTheDrive.
  EXPECT_GT(compare({5}, true), 3000U);
}

TEST_F(GenericDiscovery, TwinCatStartsAnAkdMadeOfItsEepromUp) {
  load("twincat-akd-nc-mode.pcapng", "akd.hex", from_image);
  if (IsSkipped()) return;
  EXPECT_GT(compare_overlapping(), 8000U);
  EXPECT_EQ(slave().state(), wire::AlState::kPreOp) << "where the recording ends";
}

TEST_F(GenericDiscovery, SoemScansACouplerMadeOfItsEeprom) {
  load("soem-sdinfo-akd.pcapng", "ek1100.hex", from_image);
  if (IsSkipped()) return;
  EXPECT_GT(compare({5}, false), 2000U);
}

TEST_F(GenericDiscovery, SoemScansATerminalMadeOfItsEeprom) {
  load("soem-sdinfo-akd.pcapng", "el2004-eeprom-dump.bin", from_image);
  if (IsSkipped()) return;
  EXPECT_GT(compare({5}, false), 2000U);
}

/// The same for a device without mailbox, taken to OP by the bytes of a master.
class GenericTerminal : public GenericDiscovery {
 protected:
  std::uint16_t send(wire::Command command, wire::DatagramAddress address, std::vector<std::byte>& data) {
    std::array<std::byte, 256> buffer{};
    wire::FrameBuilder builder(buffer, {});
    const auto place = builder.add(command, 0, address, data.size());
    std::copy(data.begin(), data.end(), builder.data(*place).begin());
    const auto frame = builder.finish();
    replay::CapturedPacket packet;
    packet.time = time_ += 1ms;
    packet.bytes.assign(frame.begin(), frame.end());
    const auto reply = answer(packet);
    const auto answers = datagrams(reply);
    data = answers.at(0).data;
    return answers.at(0).working_counter;
  }
  std::uint16_t write(std::uint16_t address, std::vector<std::byte> data) {
    return send(wire::Command::kApwr, wire::DatagramAddress::physical(0, address), data);
  }

 private:
  std::chrono::nanoseconds time_{1s};
};

TEST_F(GenericTerminal, AnOutputTerminalMadeOfItsEepromTakesOutputs) {
  load("soem-sdinfo-akd.pcapng", "el2004-eeprom-dump.bin", from_image);
  if (IsSkipped()) return;
  // Sync manager and FMMU according to its EEPROM: one byte on the digital output register, control 44h.
  const auto bytes = [](std::initializer_list<unsigned> values) {
    std::vector<std::byte> result;
    for (const auto value : values) result.push_back(static_cast<std::byte>(value));
    return result;
  };
  EXPECT_EQ(write(0x0800, bytes({0x00, 0x0F, 1, 0, 0x44, 0, 1, 0})), 1);
  EXPECT_EQ(write(0x0600, bytes({0, 0, 1, 0, 1, 0, 0, 3, 0x00, 0x0F, 0, 2, 1, 0, 0, 0})), 1);
  for (const unsigned state : {2U, 4U, 8U}) EXPECT_EQ(write(0x0120, bytes({state, 0})), 1);
  auto outputs = bytes({0x05});
  EXPECT_EQ(send(wire::Command::kLwr, wire::DatagramAddress::logical(0x10000), outputs), 1);
  auto none = bytes({0});
  send(wire::Command::kBrd, wire::DatagramAddress::physical(0, 0), none);
  EXPECT_EQ(slave().state(), wire::AlState::kOp);
  const auto& device = dynamic_cast<const generic::GenericDevice&>(slave().device());
  std::vector<std::uint64_t> values;
  for (const std::uint16_t index : std::initializer_list<std::uint16_t>{0x7000, 0x7010, 0x7020, 0x7030}) {
    values.push_back(device.dictionary().raw(*device.model().table().find(index, 1)));
  }
  EXPECT_EQ(values, (std::vector<std::uint64_t>{1, 0, 1, 0}));
}

}  // namespace
}  // namespace driveline::slaves

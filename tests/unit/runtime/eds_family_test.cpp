// Slaves of a CAN line that are simulated from their EDS: their keys in a line description, and errors in these.
#include <gmock/gmock.h>

#include "driveline/runtime/can_line/can_line.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "support/io_device_eds.hpp"
#include "support/scripted_node.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::runtime {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

class EdsFamilyTest : public test::TemporaryDirectory {
 protected:
  void SetUp() override {
    TemporaryDirectory::SetUp();
    write(directory / "io.eds", test::kIoDeviceEds);
  }
  Result<CanLineConfig> parse(const std::string& keys, const std::string& bus = "") const {
    return parse_can_line_config(
        "[bus]\ntype = \"can\"\n" + bus + "[[slave]]\nname = \"io\"\nnode = 9\nmodel = \"eds\"\n" + keys,
        directory / "line.toml");
  }
  /// The error without the folder.
  std::string error(const std::string& keys, const std::string& bus = "") const {
    const auto config = parse(keys, bus);
    if (config) return "no error";
    std::string text = describe(config.error());
    for (auto at = text.find(directory.string()); at != std::string::npos; at = text.find(directory.string())) {
      text.erase(at, directory.string().size() + 1);
    }
    return text;
  }
};

TEST_F(EdsFamilyTest, ADeviceOnTheBus) {
  const auto config = parse(
      "eds = \"io.eds\"\n[[slave.input]]\nentry = \"Analog in\"\nvalue = 7\n"
      "[[slave]]\nname = \"other\"\nnode = 10\nmodel = \"eds\"\neds = \"io.eds\"\nloop_back = false\n",
      "bit_rate = 500000\n");
  ASSERT_TRUE(config) << describe(config.error());
  CanLine line(*config);
  slaves::can::ScriptedNode client;
  line.bus().attach(client, {.bit_rate = 500'000});
  line.advance(5ms);
  EXPECT_EQ(client.identifiers(), (std::vector<std::uint32_t>{0x709, 0x70A})) << "boot-up messages, at 500 kbit/s";
  EXPECT_EQ(line.device(0).state(), "Pre-operational");
  auto& signals = *line.device(0).signals();
  const auto place = signals.find_signal(slaves::SignalId::Direction::kInput, "Analog in");
  ASSERT_TRUE(place);
  EXPECT_EQ(signals.signal(*place), 7.0);
  client.send_at(5ms, slaves::can::Frame::of(0, bytes_test::hex("01 00")));
  client.send_at(7ms, slaves::can::Frame::of(0x209, bytes_test::hex("A5")));
  client.send_at(7ms, slaves::can::Frame::of(0x20A, bytes_test::hex("A5")));
  line.advance(20ms);
  std::vector<std::byte> last(2);
  for (const auto& one : client.received) {
    if (one.frame.identifier.value == 0x189) last[0] = one.frame.data[0];
    if (one.frame.identifier.value == 0x18A) last[1] = one.frame.data[0];
  }
  EXPECT_EQ(last, bytes_test::hex("A5 00")) << "the second one has no loop-back";
}

TEST_F(EdsFamilyTest, ErrorsHaveFileLineAndReason) {
  EXPECT_EQ(error(""), "line.toml:6: [slave 1] model: is \"eds\": eds, the file of the device, is expected as well");
  EXPECT_THAT(error("eds = \"missing.eds\"\n"), HasSubstr("line.toml:7: [slave 1] eds: missing.eds"));
  write(directory / "no_lists.eds", "[DeviceInfo]\nVendorNumber=1\n");
  EXPECT_THAT(error("eds = \"no_lists.eds\"\n"), HasSubstr("eds: no_lists.eds:1: there is no list of objects"));
  write(directory / "no_ini.eds", "[DeviceInfo]\nVendorNumber=1\nxyz\n");
  EXPECT_THAT(error("eds = \"no_ini.eds\"\n"),
              HasSubstr("eds: no_ini.eds:3: \"xyz\" is neither [section] nor key=value"));
  std::string circular(test::kIoDeviceEds);
  circular.replace(circular.find("0x60000108"), 10, "0x1A000120");
  write(directory / "circular.eds", circular);
  EXPECT_THAT(
      error("eds = \"circular.eds\"\n"),
      HasSubstr("eds: circular.eds: the device cannot be simulated: the default mapping 1A00h is not possible"));
  write(directory / "large.eds", std::string(17 << 20, '\n'));
  EXPECT_EQ(error("eds = \"large.eds\"\n"),
            "line.toml:7: [slave 1] eds: large.eds has 17825792 bytes, at most 16777216 "
            "are expected in an electronic data sheet");
  EXPECT_EQ(
      error("eds = \"io.eds\"\n", "bit_rate = 250000\n"),
      "line.toml:7: [slave 1] model: \"io\" is a device of io.eds with 125, 500, 1000 kbit/s, the bus has 250 kbit/s");
  EXPECT_THAT(error("eds = \"io.eds\"\n[[slave.input]]\nentry = \"Motor\"\nvalue = 1\n"), HasSubstr("\"Motor\" "));
  EXPECT_THAT(error("eds = \"io.eds\"\n[[slave.input]]\nentry = \"6000:01\"\nvalue = 256\n"), HasSubstr("entry"));
  EXPECT_THAT(error("eds = \"io.eds\"\nfirmware = \"1.0\"\n"), HasSubstr("firmware"));
}

TEST_F(EdsFamilyTest, HasNoEtherCatConnection) {
  const auto config =
      parse_line_config("[[slave]]\nname = \"io\"\nmodel = \"eds\"\neds = \"io.eds\"\n", directory / "line.toml");
  ASSERT_FALSE(config);
  EXPECT_THAT(describe(config.error()), HasSubstr(":3: [slave 1] model: is \"eds\", which has no EtherCAT connection"));
}

}  // namespace
}  // namespace driveline::runtime

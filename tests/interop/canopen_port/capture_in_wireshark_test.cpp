#include <gmock/gmock.h>

#include <cstdio>
#include <cstdlib>
#include <memory>

#include "driveline/canopen_port/can_capture.hpp"
#include "support/bytes.hpp"
#include "support/must.hpp"
#include "support/scripted_can_port.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::canopen {
namespace {

using bytes_test::hex;
using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::IsEmpty;

/// Standard output of a command.
std::string output_of(const std::string& command) {
  std::string output;
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe{popen(command.c_str(), "r"), pclose};
  for (int character = 0; pipe && (character = fgetc(pipe.get())) != EOF;) output += static_cast<char>(character);
  return output;
}

class CanCaptureInWireshark : public test::TemporaryDirectory {
 protected:
  void SetUp() override {
    test::TemporaryDirectory::SetUp();
    if (std::system("tshark --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "tshark is not installed";
    const auto port = *must(CanCapture::open(
        inner, clock, {.file = file(), .interface_name = "can3", .unix_time_of_zero = 1'700'000'000s}));
    inner.arriving = {Frame::of(Identifier{0x1AAA'AAAA, true}, hex("01 F1")), Frame::remote({0x70A, false}, 4),
                      Frame{{}, FrameKind::kError, 0, {}}};
    ASSERT_EQ(port->send(Frame::of(0x123, hex("11 22 33 44 55 66 77 88"))), SendStatus::kSent);
    clock.advance(125us);
    ASSERT_EQ(port->send(Frame::of(0x7FF, {})), SendStatus::kSent);
    while (port->receive()) {
    }
    ASSERT_EQ(must(port->close())->written, 5U);
  }
  [[nodiscard]] std::string file() const { return directory / "can.pcapng"; }

  rt::VirtualClock clock;
  port_test::ScriptedCanPort inner{clock};
};

TEST_F(CanCaptureInWireshark, EveryFrameHasItsIdentifierAndData) {
  EXPECT_EQ(output_of("tshark -n -r " + file() +
                      " -T fields -E separator=/s -e frame.time_epoch -e frame.interface_name -e can.id"
                      " -e can.flags.xtd -e can.flags.rtr -e can.flags.err -e can.len -e data.data 2>/dev/null"),
            "1700000000.000000000 can3 291 0 0 0 8 1122334455667788\n"
            "1700000000.000125000 can3 2047 0 0 0 0 \n"
            "1700000000.000125000 can3 447392426 1 0 0 2 01f1\n"
            "1700000000.000125000 can3 1802 0 1 0 4 00000000\n"  // it takes the padding for data
            "1700000000.000125000 can3    1 8 \n");              // an error frame has no identifier
}

TEST_F(CanCaptureInWireshark, NothingIsMalformed) {
  EXPECT_THAT(output_of("tshark -n -r " + file() + " -Y '_ws.malformed' 2>/dev/null"), IsEmpty());
  EXPECT_THAT(output_of("capinfos -M " + file() + " 2>/dev/null"), HasSubstr("Number of packets:   5"));
}

}  // namespace
}  // namespace driveline::canopen

// A stream of frames into a CANopen device, on a bus with a second node. Input: see can_frames.hpp.

#include <algorithm>
#include <cstdlib>
#include <string_view>

#include "can_frames.hpp"
#include "driveline/canopen_wire/nmt.hpp"
#include "fuzz_target.hpp"
#include "support/bytes.hpp"
#include "support/canopen_sample.hpp"
#include "support/scripted_node.hpp"

namespace driveline::fuzz {
namespace {

using canopen::Frame;
using slaves::can::Bus;
using slaves::can::ScriptedNode;
using namespace std::chrono_literals;

constexpr std::uint32_t kNode = 5;
constexpr std::size_t kMostFrames = 2000;

/// Whether the device has one of the states of CiA 301.
bool known_state(canopen::NmtState state) {
  return state == canopen::NmtState::kPreOperational || state == canopen::NmtState::kOperational ||
         state == canopen::NmtState::kStopped;
}

/// After everything that has come a reset makes the device a good one again.
void check_alive(Bus& bus, ScriptedNode& master) {
  master.send_at(bus.now(), canopen::NmtRequest{canopen::NmtCommand::kResetNode, 0}.frame());
  bus.advance(bus.now() + 10ms);
  master.received.clear();
  master.send_at(bus.now(), Frame::of(0x600 + kNode, bytes_test::hex("40 00 10 00 00 00 00 00")));
  bus.advance(bus.now() + 10ms);
  const Frame answer = Frame::of(0x580 + kNode, bytes_test::hex("43 00 10 00 92 01 02 00"));
  const bool answered = std::any_of(master.received.begin(), master.received.end(),
                                    [&](const auto& seen) { return seen.frame == answer; });
  if (!answered) std::abort();
}

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  Bus bus;
  ScriptedNode master;
  slaves::ObjectDictionary dictionary(slaves::cia301::sample_table());
  slaves::cia301::SampleApplication application;
  slaves::cia301::Device device(dictionary, application,
                                {.block_transfer = true, .remote_types = true, .long_rpdo_emergency = true});
  bus.attach(master);
  bus.attach(device, {.automatic_recovery = true});
  bus.advance(1ms);
  for (std::size_t i = 0; i < kMostFrames && input.size() >= 3; ++i) {
    master.send_at(bus.now(), take_frame(input));
    bus.advance(bus.now() + take_time(input));
    device.watch(bus.now());
    if (!known_state(device.state())) std::abort();
    master.received.clear();
  }
  check_alive(bus, master);
}

std::vector<Bytes> seeds() {
  Bytes transfers;
  append(transfers, 0x605, "40 03 20 00 00 00 00 00");
  append(transfers, 0x605, "60 00 00 00 00 00 00 00");
  append(transfers, 0x605, "70 00 00 00 00 00 00 00");
  append(transfers, 0x605, "21 03 20 00 09 00 00 00");
  append(transfers, 0x605, "00 31 32 33 34 35 36 37");
  append(transfers, 0x605, "1B 38 39 00 00 00 00 00");
  append(transfers, 0x605, "C6 03 20 00 09 00 00 00");
  append(transfers, 0x605, "01 31 32 33 34 35 36 37");
  append(transfers, 0x605, "82 38 39 00 00 00 00 00");
  append(transfers, 0x605, "D5 00 00 00 00 00 00 00");
  append(transfers, 0x605, "A4 03 20 00 04 00 00 00");
  append(transfers, 0x605, "A3 00 00 00 00 00 00 00", 20);
  append(transfers, 0x605, "A2 04 7F 00 00 00 00 00", 40);
  append(transfers, 0x605, "23 10 10 01 73 61 76 65");
  Bytes process_data;
  append(process_data, 0x605, "23 00 14 01 05 02 00 80");
  append(process_data, 0x605, "2F 00 14 02 01 00 00 00");
  append(process_data, 0x605, "23 00 16 01 08 00 05 00");
  append(process_data, 0x605, "23 00 16 02 10 00 00 20");
  append(process_data, 0x605, "2F 00 16 00 02 00 00 00");
  append(process_data, 0x605, "23 00 14 01 05 02 00 00");
  append(process_data, 0x605, "23 00 1A 01 08 00 01 20");
  append(process_data, 0x605, "2F 00 1A 00 01 00 00 00");
  append(process_data, 0x605, "2B 00 18 05 08 00 00 00");
  append(process_data, 0x000, "01 05");
  append(process_data, 0x205, "EE 34 12");
  append(process_data, 0x080, "");
  append(process_data, 0x205, "EE 34");
  append(process_data, 0x8185, "", 200);
  append(process_data, 0x000, "02 00");
  Bytes error_control;
  append(error_control, 0x605, "23 16 10 02 14 00 07 00");
  append(error_control, 0x605, "2B 0C 10 00 14 00 00 00");
  append(error_control, 0x605, "2F 0D 10 00 03 00 00 00");
  append(error_control, 0x707, "05", 10);
  append(error_control, 0x8705, "", 250);
  append(error_control, 0x707, "00");
  append(error_control, 0x605, "2B 17 10 00 07 00 00 00", 250);
  append(error_control, 0x605, "23 06 10 00 C4 09 00 00");
  append(error_control, 0x605, "23 05 10 00 80 00 00 40", 250);
  append(error_control, 0x100, "0B FB 61 04 39 3D");
  append(error_control, 0x000, "82 05");
  return {transfers, process_data, error_control};
}

}  // namespace driveline::fuzz

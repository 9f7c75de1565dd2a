// What clients send into the doors of a CAN line. Input: pieces of a byte with the door in bits 6 and 7 and the length
// in the others, and as many bytes.

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>

#include "driveline/slaves/can/bus.hpp"
#include "driveline/slaves/can/cannelloni_door.hpp"
#include "driveline/slaves/can/slcan_door.hpp"
#include "driveline/slaves/can/socketcand_door.hpp"
#include "fuzz_target.hpp"
#include "support/scripted_node.hpp"

namespace driveline::fuzz {
namespace {

using canopen::Frame;
using slaves::can::Bus;
using slaves::can::Door;
using slaves::can::ScriptedNode;
using namespace std::chrono_literals;

/// The doors in the order of their numbers in the input.
enum DoorNumber : unsigned { kSerial = 0, kTunnel = 1, kDaemon = 2, kPackets = 3 };

/// Takes a part of the output, as a client that reads slowly: a packet, or half of a stream.
void read_some(Door& door, bool packets) {
  if (door.output().size() > Door::kOutputBytes || door.piece() > door.output().size()) std::abort();
  door.taken(packets ? door.piece() : door.output().size() / 2);
}

/// After everything that has come a new client of each door gets its frame to the other one.
void check_alive(Bus& bus, std::span<Door* const> doors) {
  bus.advance(bus.now() + 1s);
  for (Door* door : doors) {
    door->open();
    door->taken(door->output().size());
  }
  Door& serial = *doors[kSerial];
  Door& daemon = *doors[kDaemon];
  Door& packets = *doors[kPackets];
  daemon.input("< open can0 >< rawmode >", bus.now());
  daemon.taken(daemon.output().size());
  serial.input("O\rt3211AA\r", bus.now());
  bus.advance(bus.now() + 100ms);
  const bool sent = serial.output().starts_with("\rz\r");
  if (!sent || daemon.output().find("< frame 321 ") == std::string_view::npos) std::abort();
  constexpr std::string_view kFrame("\0\0\x03\x21\x01\xAA", 6);
  if (packets.output().find(kFrame) == std::string_view::npos) std::abort();
}

void append(Bytes& input, DoorNumber door, std::string_view text) {
  input.push_back(static_cast<std::byte>(text.size() | door << 6U));
  for (const char c : text) input.push_back(static_cast<std::byte>(c));
}

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  Bus bus;
  ScriptedNode node;
  slaves::can::SlcanDoor serial;
  slaves::can::CannelloniTcpDoor tunnel;
  slaves::can::SocketcandDoor daemon{"can0"};
  slaves::can::CannelloniUdpDoor packets;
  const std::array<Door*, 4> doors{&serial, &tunnel, &daemon, &packets};
  bus.attach(node);
  for (Door* door : doors) {
    bus.attach(*door, {.error_frames = true});
    door->open();
  }
  while (!input.empty()) {
    const auto head = std::to_integer<unsigned>(input[0]);
    input = input.subspan(1);
    const auto piece = input.first(std::min<std::size_t>(head & 0x3FU, input.size()));
    input = input.subspan(piece.size());
    std::string text;
    for (const std::byte byte : piece) text += static_cast<char>(byte);
    Door& door = *doors[head >> 6U];
    door.input(text, bus.now());
    node.send_at(bus.now(), Frame::of(0x123, bytes_test::hex("01 02 03")));
    bus.advance(bus.now() + 500us);
    read_some(door, head >> 6U == kPackets);
  }
  check_alive(bus, doors);
}

std::vector<Bytes> seeds() {
  Bytes frames;
  append(frames, kSerial, "S6\rZ1\rO\r");
  append(frames, kDaemon, "< open can0 >< rawmode >< send 123 2 1 F1 >");
  append(frames, kSerial, "t1232AABB\rT1AAAAAAA0\rr70A4\rR000001002\rF\rV\rN\r");
  append(frames, kDaemon, "< sendrtr 70A 2 >< echo >< bcmmode >");
  append(frames, kSerial, "C\rs001C\rL\rX1\rt1230\r");
  Bytes jobs;
  append(jobs, kDaemon, "< open can0 >< add 0 2000 123 2 1 F1 >< subscribe 0 0 123 >");
  append(jobs, kDaemon, "< filter 0 500 321 1 FF >< update 123 1 7 >< delete 123 >");
  append(jobs, kDaemon, "< unsubscribe 123 >< controlmode >< statistics 10 >");
  Bytes tunnels;
  append(tunnels, kTunnel, std::string_view("CANNELLONIv1\0\0\x01\0\x02\x11\x33\x9A\xAA\xAA\xAA\0", 24));
  append(tunnels, kPackets, std::string_view("\x02\0\xA7\0\x02\0\0\x01\0\x02\x11\x33\x40\0\x07\x0A\x04", 17));
  append(tunnels, kPackets, std::string_view("\x02\0\xA9\0\x01\0\0\x01\x23\x82\0\xAA\xBB", 13));
  Bytes broken;
  append(broken, kDaemon, "< rawmode >< open can1 >< open can0 >< send 1 9 >");
  append(broken, kSerial, "O\rt12\rt1239\r\r\n\aG\rS8\r");
  append(broken, kTunnel, "CANNELLONIv2");
  append(broken, kPackets, std::string_view("\x02\0\x01\xFF\xFF\0\0\x01\x23\x09", 10));
  return {frames, jobs, tunnels, broken};
}

}  // namespace driveline::fuzz

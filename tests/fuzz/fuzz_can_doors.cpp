// What clients send into the doors of a CAN line. Input: pieces of a byte with the door in bit 7 and the length in the
// others, and as many bytes.

#include <algorithm>
#include <cstdlib>
#include <string>

#include "driveline/slaves/can/bus.hpp"
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

/// Takes a part of the output, as a client that reads slowly.
void read_some(Door& door) {
  if (door.output().size() > Door::kOutputBytes) std::abort();
  door.taken(door.output().size() / 2);
}

/// After everything that has come a new client of each door gets its frame to the other one.
void check_alive(Bus& bus, Door& serial, Door& daemon) {
  bus.advance(bus.now() + 1s);
  for (Door* door : {&serial, &daemon}) {
    door->open();
    door->taken(door->output().size());
  }
  daemon.input("< open can0 >< rawmode >", bus.now());
  daemon.taken(daemon.output().size());
  serial.input("O\rt3211AA\r", bus.now());
  bus.advance(bus.now() + 100ms);
  const bool sent = serial.output().starts_with("\rz\r");
  if (!sent || daemon.output().find("< frame 321 ") == std::string_view::npos) std::abort();
}

void append(Bytes& input, bool daemon, std::string_view text) {
  input.push_back(static_cast<std::byte>(text.size() | (daemon ? 0x80U : 0U)));
  for (const char c : text) input.push_back(static_cast<std::byte>(c));
}

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  Bus bus;
  ScriptedNode node;
  slaves::can::SlcanDoor serial;
  slaves::can::SocketcandDoor daemon{"can0"};
  bus.attach(node);
  bus.attach(serial, {.error_frames = true});
  bus.attach(daemon, {.error_frames = true});
  serial.open();
  daemon.open();
  while (!input.empty()) {
    const auto head = std::to_integer<unsigned>(input[0]);
    input = input.subspan(1);
    const auto piece = input.first(std::min<std::size_t>(head & 0x7FU, input.size()));
    input = input.subspan(piece.size());
    std::string text;
    for (const std::byte byte : piece) text += static_cast<char>(byte);
    Door& door = (head & 0x80U) != 0 ? static_cast<Door&>(daemon) : serial;
    door.input(text, bus.now());
    node.send_at(bus.now(), Frame::of(0x123, bytes_test::hex("01 02 03")));
    bus.advance(bus.now() + 500us);
    read_some(door);
  }
  check_alive(bus, serial, daemon);
}

std::vector<Bytes> seeds() {
  Bytes frames;
  append(frames, false, "S6\rZ1\rO\r");
  append(frames, true, "< open can0 >< rawmode >< send 123 2 1 F1 >");
  append(frames, false, "t1232AABB\rT1AAAAAAA0\rr70A4\rR000001002\rF\rV\rN\r");
  append(frames, true, "< sendrtr 70A 2 >< echo >< bcmmode >");
  append(frames, false, "C\rs001C\rL\rX1\rt1230\r");
  Bytes broken;
  append(broken, true, "< rawmode >< open can1 >< open can0 >< send 1 9 >");
  append(broken, false, "O\rt12\rt1239\r\r\n\aG\rS8\r");
  return {frames, broken};
}

}  // namespace driveline::fuzz

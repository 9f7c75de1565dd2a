// A stream of frames into the MSD on a CAN bus. Input: see can_frames.hpp.

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "can_frames.hpp"
#include "driveline/canopen_wire/nmt.hpp"
#include "driveline/slaves/can/bus.hpp"
#include "driveline/slaves/msd/can/msd_can_drive.hpp"
#include "support/scripted_node.hpp"

namespace driveline::fuzz {
namespace {

using canopen::Frame;
using slaves::can::Bus;
using slaves::can::ScriptedNode;
using slaves::msd::MsdCanDrive;
using namespace std::chrono_literals;

constexpr std::uint8_t kAddress = 12;
constexpr std::size_t kMostFrames = 400;

/// After everything that has come a restart makes the drive a good one again, unless it has no node-ID any more.
void check_drive(Bus& bus, ScriptedNode& master, MsdCanDrive& drive) {
  drive.restart();
  bus.advance(bus.now() + 20ms);
  const std::uint8_t node = drive.device().node_id();
  if (node == 0) return;
  master.controller().set_bit_rate(drive.device().controller()->options().bit_rate);
  master.controller().recover(bus.now());
  bus.advance(bus.now() + 200ms);
  master.received.clear();
  master.send_at(bus.now(), Frame::of(0x600U + node, bytes_test::hex("40 00 10 00 00 00 00 00")));
  bus.advance(bus.now() + 100ms);
  const Frame answer = Frame::of(0x580U + node, bytes_test::hex("43 00 10 00 92 01 02 00"));
  const bool answered = std::any_of(master.received.begin(), master.received.end(),
                                    [&](const auto& seen) { return seen.frame == answer; });
  if (!answered) std::abort();
}

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  Bus bus;
  ScriptedNode master;
  slaves::msd::MsdParameters parameters;
  parameters.factory_start_up_time = 5ms;
  MsdCanDrive drive(parameters, {slaves::msd::DipSwitch{kAddress}, {}, 500us});
  bus.attach(master, {.automatic_recovery = true});
  bus.attach(drive.device(), {.automatic_recovery = true});
  bus.advance(5ms);
  for (std::size_t i = 0; i < kMostFrames && input.size() >= 3; ++i) {
    master.send_at(bus.now(), take_frame(input));
    bus.advance(bus.now() + take_time(input));
    if (!std::isfinite(drive.core().position_rad())) std::abort();
    master.received.clear();
  }
  check_drive(bus, master, drive);
}

std::vector<Bytes> seeds() {
  Bytes setup;
  append(setup, 0x60C, "2F 60 60 00 01 00 00 00");
  append(setup, 0x60C, "23 00 16 01 10 00 40 60");
  append(setup, 0x60C, "2F 00 16 00 01 00 00 00");
  append(setup, 0x60C, "23 01 16 01 20 00 7A 60");
  append(setup, 0x60C, "2F 01 16 00 01 00 00 00");
  append(setup, 0x60C, "23 01 1A 01 20 00 64 60");
  append(setup, 0x60C, "2F 01 1A 00 01 00 00 00");
  append(setup, 0x60C, "23 0E 28 00 0C 00 00 00");
  append(setup, 0x000, "01 0C", 20);
  append(setup, 0x20C, "06 00", 20);
  append(setup, 0x20C, "07 00", 20);
  append(setup, 0x20C, "0F 00", 20);
  append(setup, 0x30C, "00 00 10 00", 20);
  append(setup, 0x20C, "1F 00", 250);
  append(setup, 0x080, "", 250);
  append(setup, 0x28C, "", 10);
  Bytes settings;
  append(settings, 0x60C, "2B D6 27 00 7D 00 00 00");
  append(settings, 0x60C, "2F D5 27 00 1E 00 00 00");
  append(settings, 0x60C, "23 16 10 01 14 00 05 00");
  append(settings, 0x60C, "23 D7 27 02 FF 00 00 00");
  append(settings, 0x705, "05", 250);
  append(settings, 0x60C, "2F 0B 20 03 01 00 00 00");
  append(settings, 0x60C, "2F 0B 20 01 01 00 00 00");
  append(settings, 0x60C, "23 10 10 01 73 61 76 65");
  append(settings, 0x60C, "40 03 20 00 00 00 00 00");
  append(settings, 0x60C, "60 00 00 00 00 00 00 00");
  append(settings, 0x000, "82 00", 60);
  append(settings, 0x000, "81 00", 200);
  return {setup, settings};
}

}  // namespace driveline::fuzz

#include "support/can_front_ends.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "driveline/canopen_wire/nmt.hpp"
#include "driveline/canopen_wire/sdo.hpp"
#include "support/stopwatch.hpp"

namespace driveline::bench {
namespace {

using canopen::Frame;
using slaves::msd::CanConnection;
using slaves::msd::DipSwitch;
using slaves::msd::MsdCanDrive;
using slaves::msd::MsdParameters;
using namespace std::chrono_literals;

constexpr std::uint8_t kFrontEnds = 8;
constexpr double kIncrementsPerTurn = 1 << 20;
constexpr std::int64_t kCyclesPerSwing = 600;

/// An object and what the master writes to it.
struct CanSetting {
  std::uint16_t index;
  std::uint8_t subindex;
  std::uint32_t value;
  std::size_t size;
};

}  // namespace

void CanMaster::send(const Frame& frame) {
  if (!controller_->send(frame)) throw std::runtime_error("a frame of the master was not taken");
}

void CanMaster::receive(const Frame& frame, std::chrono::nanoseconds now) {
  if (frame.identifier.value != awaited_) return;
  const auto payload = frame.payload();
  answer_.assign(payload.begin(), payload.end());
  answered_at_ = now;
}

std::vector<std::byte> CanMaster::ask(std::uint8_t node, std::span<const std::byte> request) {
  awaited_ = 0x580U + node;
  answer_.clear();
  send(Frame::of(0x600U + node, request));
  const auto patience = bus_->now() + 100ms;
  while (answer_.empty() && bus_->now() < patience) bus_->advance(bus_->next_event());
  if (answer_.empty() || answer_[0] == std::byte{0x80}) throw std::runtime_error("an SDO request has no good answer");
  return answer_;
}

void CanMaster::write(std::uint8_t node, std::uint16_t index, std::uint8_t subindex, std::uint32_t value,
                      std::size_t size) {
  const auto command = canopen::expedited_command(canopen::SdoRequest::kInitiateDownload, size);
  ask(node, canopen::SdoMessage{command, index, subindex, bytes::to_le_bytes(value)}.encode());
}

CanFrontEnds::CanFrontEnds() : sent_(kFrontEnds) {
  for (std::uint8_t node = 1; node <= kFrontEnds; ++node) {
    drives_.push_back(std::make_unique<MsdCanDrive>(MsdParameters{}, CanConnection{DipSwitch{node}, {}, 500us}));
    bus_.attach(drives_.back()->device());
  }
  bus_.advance(20ms);
  for (std::uint8_t node = 1; node <= kFrontEnds; ++node) {
    for (const auto& [index, subindex, value, size] :
         {CanSetting{0x2132, 0, std::bit_cast<std::uint32_t>(2.0F), 4}, CanSetting{0x1006, 0, 2000, 4},
          CanSetting{0x60C2, 1, 2, 1}, CanSetting{0x6060, 0, 7, 1}, CanSetting{0x1400, 1, 0x8000'0200U + node, 4},
          CanSetting{0x1600, 1, 0x6040'0010, 4}, CanSetting{0x1600, 0, 1, 1}, CanSetting{0x1400, 1, 0x200U + node, 4},
          CanSetting{0x1401, 1, 0x8000'0300U + node, 4}, CanSetting{0x1401, 2, 1, 1},
          CanSetting{0x1601, 1, 0x60C1'0120, 4}, CanSetting{0x1601, 0, 1, 1}, CanSetting{0x1401, 1, 0x300U + node, 4},
          CanSetting{0x1800, 1, 0x8000'0180U + node, 4}, CanSetting{0x1800, 2, 1, 1},
          CanSetting{0x1A00, 1, 0x6041'0010, 4}, CanSetting{0x1A00, 2, 0x6064'0020, 4}, CanSetting{0x1A00, 0, 2, 1},
          CanSetting{0x1800, 1, 0x180U + node, 4}}) {
      master_.write(node, index, subindex, value, size);
    }
  }
  enable();
}

/// The first cycles are on the bus; behind them it is left out.
void CanFrontEnds::enable() {
  master_.send(canopen::NmtRequest{canopen::NmtCommand::kStart, 0}.frame());
  bus_.advance((bus_.now() / 1ms + 4) * 1ms);
  for (const std::uint16_t word : std::array<std::uint16_t, 6>{0x06, 0x07, 0x0F, 0x0F, 0x1F, 0x1F}) {
    for (std::uint8_t node = 1; node <= kFrontEnds; ++node) {
      master_.send(Frame::of(0x200U + node, bytes::to_le_bytes(word)));
      master_.send(Frame::of(0x300U + node, bytes::to_le_bytes(std::uint32_t{0})));
    }
    bus_.advance(bus_.now() + 4ms);
    master_.send(Frame::of(0x080, {}));
    bus_.advance(bus_.now() + 2ms);
  }
  now_ = (bus_.now() / 1ms) * 1ms;
  for (const auto& one : drives_) {
    if (one->core().state() != slaves::PowerState::kOperationEnabled) throw std::runtime_error("a drive is not on");
  }
}

double CanFrontEnds::setpoint_rad() const noexcept {
  const double share = static_cast<double>(cycles_) / static_cast<double>(kCyclesPerSwing);
  return (1.0 - std::cos(2.0 * std::numbers::pi * share)) * 2.0 * std::numbers::pi;
}

void CanFrontEnds::step_millisecond(Cost& cost) {
  now_ += 1ms;
  const double begin = now_ns();
  for (const auto& one : drives_) one->core().advance(now_);
  const double advanced = now_ns();
  for (const auto& one : drives_) one->device().advance(now_);
  const double end = now_ns();
  cost.drive += advanced - begin - reading_cost_ns();
  cost.own_frames += end - advanced - reading_cost_ns();
}

CanFrontEnds::Cost CanFrontEnds::cycle() {
  ++cycles_;
  const auto target =
      static_cast<std::int32_t>(std::lrint(setpoint_rad() / (2.0 * std::numbers::pi) * kIncrementsPerTurn));
  setpoints_.clear();
  for (std::uint8_t node = 1; node <= kFrontEnds; ++node) {
    setpoints_.push_back(Frame::of(0x300U + node, bytes::to_le_bytes(static_cast<std::uint32_t>(target))));
  }
  const Frame sync = Frame::of(0x080, {});
  Cost cost;
  step_millisecond(cost);
  step_millisecond(cost);
  const double begin = now_ns();
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    auto& device = drives_[i]->device();
    auto& queue = device.controller()->queue();
    device.receive(setpoints_[i], now_);
    device.receive(sync, now_);
    sent_[i].clear();
    for (; queue.front() != nullptr; queue.pop()) {
      sent_[i].push_back(*queue.front());
      device.transmitted(sent_[i].back(), now_);
    }
  }
  const double own = now_ns();
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    for (std::size_t other = 0; other < drives_.size(); ++other) {
      if (other == i) continue;
      drives_[i]->device().receive(setpoints_[other], now_);
      for (const Frame& frame : sent_[other]) drives_[i]->device().receive(frame, now_);
    }
  }
  const double end = now_ns();
  cost.own_frames += own - begin - reading_cost_ns();
  cost.frames_of_others = end - own - reading_cost_ns();
  for (const auto& frames : sent_) {
    if (frames.size() != 1) throw std::runtime_error("a drive has not sent its PDO after a SYNC");
  }
  return {cost.drive / kFrontEnds, cost.own_frames / kFrontEnds, cost.frames_of_others / kFrontEnds};
}

void CanFrontEnds::check() const {
  for (const auto& one : drives_) {
    if (one->core().fault()) throw std::runtime_error("a drive has a fault");
    if (std::abs(one->core().position_rad() - setpoint_rad()) > 0.5) throw std::runtime_error("a drive left its path");
  }
}

}  // namespace driveline::bench

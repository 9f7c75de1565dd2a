#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "driveline/slaves/can/bus.hpp"
#include "driveline/slaves/msd/can/msd_can_drive.hpp"

namespace driveline::bench {

/// A CANopen master of a few lines. Its requests let virtual time pass.
class CanMaster final : public slaves::can::Node {
 public:
  explicit CanMaster(slaves::can::Bus& bus) : bus_(&bus) { bus.attach(*this); }

  void send(const canopen::Frame& frame);
  /// Sends an SDO request and waits for the answer. Throws std::runtime_error without one, or if it is an abort.
  std::vector<std::byte> ask(std::uint8_t node, std::span<const std::byte> request);
  void write(std::uint8_t node, std::uint16_t index, std::uint8_t subindex, std::uint32_t value, std::size_t size);
  /// Time of the last answer.
  [[nodiscard]] std::chrono::nanoseconds answered_at() const noexcept { return answered_at_; }

  void connected(slaves::can::Controller& controller) override { controller_ = &controller; }
  void receive(const canopen::Frame& frame, std::chrono::nanoseconds now) override;
  void advance(std::chrono::nanoseconds /*now*/) override {}
  [[nodiscard]] std::chrono::nanoseconds next_wake() const noexcept override { return slaves::can::kNever; }

 private:
  slaves::can::Bus* bus_;
  slaves::can::Controller* controller_ = nullptr;
  std::uint32_t awaited_ = 0;  ///< identifier
  std::vector<std::byte> answer_;
  std::chrono::nanoseconds answered_at_{0};
};

/// MSD drives in interpolated position mode with SYNCs of 2 ms, as devices without a bus: frames are handed to them,
/// and the drives behind them are advanced apart, so that each can be measured.
class CanFrontEnds {
 public:
  /// Makes and enables eight drives.
  CanFrontEnds();

  /// Times of a cycle of 2 ms, in ns for each drive.
  struct Cost {
    double drive = 0.0;           ///< drive with its plant
    double own_frames = 0.0;      ///< front end: SYNC, RxPDO and TxPDO of the drive, two milliseconds
    double frames_of_others = 0;  ///< and the frames of the other seven, which are not for it
  };
  /// Executes a cycle.
  Cost cycle();
  /// Throws if a drive has a fault or has not followed: the figures would be invalid.
  void check() const;

 private:
  void enable();
  void step_millisecond(Cost& cost);
  [[nodiscard]] double setpoint_rad() const noexcept;

  slaves::can::Bus bus_;
  CanMaster master_{bus_};
  std::vector<std::unique_ptr<slaves::msd::MsdCanDrive>> drives_;
  std::vector<canopen::Frame> setpoints_;
  std::vector<std::vector<canopen::Frame>> sent_;
  std::chrono::nanoseconds now_{0};
  std::int64_t cycles_ = 0;
};

}  // namespace driveline::bench

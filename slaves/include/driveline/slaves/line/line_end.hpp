#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <span>
#include <vector>

#include "driveline/port/port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/slaves/line/wiring.hpp"

namespace driveline::slaves {

class SimulatedLine;

/// An end of a line that a master can be connected to: holds the frames in flight to the master, in a fixed pool
/// without allocation after construction.
class LineEnd final : public port::Port {
 public:
  /// Maximum number of frames in flight.
  static constexpr std::size_t kMaxInFlight = 64;

  /// Created by the line, which must outlive it.
  LineEnd(SimulatedLine& line, rt::Clock& clock, MasterPort which);

  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override;
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override;
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override;
  [[nodiscard]] std::chrono::nanoseconds last_send_time() const noexcept override { return last_send_; }

 private:
  friend class SimulatedLine;
  struct Slot {
    std::array<std::byte, port::kMaxFrameBytes> bytes;
    std::size_t length = 0;
    std::chrono::nanoseconds arrival{0};
  };

  /// Returns the slot for the next frame to arrive; nullptr: pool exhausted. The line fills it, then calls commit().
  [[nodiscard]] Slot* next_slot() noexcept;
  void commit(std::size_t length, std::chrono::nanoseconds arrival) noexcept;
  void release_held() noexcept;
  /// Returns when a frame sent now starts on the wire, after earlier frames. Reserves the wire for its duration.
  [[nodiscard]] std::chrono::nanoseconds occupy(std::chrono::nanoseconds now, std::chrono::nanoseconds byte_time,
                                                std::size_t bytes) noexcept;

  SimulatedLine& line_;
  rt::Clock& clock_;
  MasterPort which_;
  std::vector<Slot> slots_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  bool held_ = false;  ///< the first slot was returned by receive()
  std::chrono::nanoseconds last_send_{0};
  std::chrono::nanoseconds wire_free_{0};  ///< end of the last frame including FCS and inter-frame gap
};

}  // namespace driveline::slaves

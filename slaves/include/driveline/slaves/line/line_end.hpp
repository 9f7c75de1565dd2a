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

class Line;

/// One of the two ends of a line that a master can hold: the frames that are on their way back to it. A fixed pool,
/// no allocation after construction.
class LineEnd final : public port::Port {
 public:
  /// Frames that may be on the way at the same time.
  static constexpr std::size_t kMaxInFlight = 64;

  /// Made by the line, which must outlive it.
  LineEnd(Line& line, rt::Clock& clock, MasterPort which);

  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override;
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override;
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override;
  [[nodiscard]] std::chrono::nanoseconds last_send_time() const noexcept override { return last_send_; }

 private:
  friend class Line;
  struct Slot {
    std::array<std::byte, port::kMaxFrameBytes> bytes;
    std::size_t length = 0;
    std::chrono::nanoseconds arrival{0};
  };

  /// Slot for the next frame to arrive; nullptr when the pool is used up. Filled by the line, then committed.
  [[nodiscard]] Slot* next_slot() noexcept;
  void commit(std::size_t length, std::chrono::nanoseconds arrival) noexcept;
  void release_held() noexcept;
  /// When a frame handed over now begins on the wire: behind those before it. Takes the wire for its time.
  [[nodiscard]] std::chrono::nanoseconds occupy(std::chrono::nanoseconds now, std::chrono::nanoseconds byte_time,
                                                std::size_t bytes) noexcept;

  Line& line_;
  rt::Clock& clock_;
  MasterPort which_;
  std::vector<Slot> slots_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  bool held_ = false;  ///< the first slot has been handed out
  std::chrono::nanoseconds last_send_{0};
  std::chrono::nanoseconds wire_free_{0};  ///< the last frame, its FCS and the gap behind it are over
};

}  // namespace driveline::slaves

#pragma once

#include <chrono>
#include <cstdint>

#include "can/frame_words.hpp"
#include "driveline/canopen_port/can_port.hpp"

namespace driveline::cli {

/// A frame as `can dump` shows it: time, identifier, bytes, and what they mean.
[[nodiscard]] std::string frame_line(const canopen::ReceivedFrame& received, std::chrono::nanoseconds start,
                                     const FrameWords& words);
/// The same as one JSON document in one line.
[[nodiscard]] std::string frame_json_line(const canopen::ReceivedFrame& received, std::chrono::nanoseconds start,
                                          const FrameWords& words);
/// An identifier as users write it: three digits, or eight of an extended one.
[[nodiscard]] std::string identifier_words(const canopen::Identifier& identifier);

/// Prints frames as they come, in text or JSON, and counts them.
class FramePrinter {
 public:
  /// Times are shown since `start`.
  FramePrinter(std::chrono::nanoseconds start, bool json) : start_(start), json_(json) {}
  /// Prints a frame.
  void print(const canopen::ReceivedFrame& received);
  /// Frames that were printed.
  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  /// Bits of them on the bus, without error frames.
  [[nodiscard]] std::uint64_t bits() const noexcept { return bits_; }

 private:
  std::chrono::nanoseconds start_;
  bool json_;
  FrameReader reader_;
  std::uint64_t count_ = 0;
  std::uint64_t bits_ = 0;
};

}  // namespace driveline::cli

#pragma once

#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "can/frame_words.hpp"
#include "driveline/canopen_port/can_port.hpp"

namespace driveline::cli {

/// Counts the frames of a bus by identifier, with their bits on the wire: the load is computed, to the bit.
class BusFigures {
 public:
  /// Counts a frame.
  void add(const canopen::Frame& frame);
  /// Frames, without error frames.
  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_; }
  /// Share of the bus that the frames take at a bit rate, during `time`: 0 to 1.
  [[nodiscard]] double load(std::uint32_t bit_rate, std::chrono::nanoseconds time) const;

  /// A summary and a row for each identifier.
  [[nodiscard]] std::string to_text(const std::string& bus, std::uint32_t bit_rate, std::chrono::nanoseconds time,
                                    const canopen::PortStatistics& adapter) const;
  /// The same as a document.
  [[nodiscard]] nlohmann::json to_json(const std::string& bus, std::uint32_t bit_rate, std::chrono::nanoseconds time,
                                       const canopen::PortStatistics& adapter) const;

 private:
  struct Row {
    canopen::Frame last;
    std::uint64_t frames = 0;
    std::uint64_t bits = 0;
    std::string name;
  };
  std::map<std::uint32_t, Row> rows_;  ///< by arbitration field: in the order of priority
  FrameReader reader_;
  std::uint64_t frames_ = 0;
  std::uint64_t bits_ = 0;
};

}  // namespace driveline::cli

#pragma once

#include <cstdint>

#include "driveline/canopen_wire/slcan.hpp"

namespace driveline::canopen {

/// Reads what a serial CAN adapter sends (slcan.hpp), character by character. \rtsafe throughout.
class SlcanReader {
 public:
  static constexpr std::size_t kLongestLine = 64;  ///< longer ones are skipped as a whole

  /// What a character has led to.
  enum class Event : std::uint8_t {
    kNone,     ///< nothing yet
    kFrame,    ///< frame() has come
    kOk,       ///< the positive answer to a command or a frame
    kSent,     ///< the positive answer to a frame, of adapters that tell frames by themselves
    kRefused,  ///< the negative one
    kFlags,    ///< the answer to F, see flags()
  };

  /// Takes the next character.
  [[nodiscard]] Event take(char character) noexcept;
  /// The frame of the last kFrame.
  [[nodiscard]] const Frame& frame() const noexcept { return frame_; }
  /// Bits of slcan::status_flag of the last kFlags.
  [[nodiscard]] std::uint8_t flags() const noexcept { return flags_; }
  /// Lines that were neither a frame nor an answer, since the start.
  [[nodiscard]] std::uint64_t malformed() const noexcept { return malformed_; }

 private:
  [[nodiscard]] Event line() noexcept;

  Text<kLongestLine> line_;
  bool too_long_ = false;  ///< the line so far
  Frame frame_;
  std::uint8_t flags_ = 0;
  std::uint64_t malformed_ = 0;
};

}  // namespace driveline::canopen

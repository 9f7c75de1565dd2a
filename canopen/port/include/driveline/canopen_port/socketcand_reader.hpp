#pragma once

#include <cstdint>

#include "driveline/canopen_wire/socketcand.hpp"

namespace driveline::canopen {

/// Reads what a server of socketcand sends (socketcand.hpp), character by character. \rtsafe throughout.
class SocketcandReader {
 public:
  static constexpr std::size_t kLongestElement = 256;  ///< longer ones are skipped

  /// What a character has led to.
  enum class Event : std::uint8_t {
    kNone,        ///< nothing yet
    kGreeting,    ///< "< hi >"
    kOk,          ///< "< ok >"
    kFrame,       ///< frame() has come
    kErrorFrame,  ///< an error frame, see error_classes()
    kFailure,     ///< "< error ... >" with a reason, see reason()
  };

  /// Takes the next character.
  [[nodiscard]] Event take(char character) noexcept;
  /// The frame of the last kFrame or kErrorFrame.
  [[nodiscard]] const Frame& frame() const noexcept { return frame_; }
  /// Bits of socketcan::error_class of the last kErrorFrame.
  [[nodiscard]] std::uint32_t error_classes() const noexcept { return error_classes_; }
  /// The reason of the last kFailure; valid until the next character.
  [[nodiscard]] std::string_view reason() const noexcept { return reason_; }
  /// Elements that are not of the protocol, and runs of characters between elements, since the start.
  [[nodiscard]] std::uint64_t malformed() const noexcept { return malformed_; }

 private:
  [[nodiscard]] Event element() noexcept;
  [[nodiscard]] Event error(std::string_view words) noexcept;
  Event skip() noexcept;

  Text<kLongestElement> element_;  ///< behind its '<'
  bool inside_ = false;            ///< behind a '<'
  bool skipping_ = false;          ///< in a run between elements that has been counted
  Frame frame_;
  std::uint32_t error_classes_ = 0;
  std::string_view reason_;
  std::uint64_t malformed_ = 0;
};

}  // namespace driveline::canopen

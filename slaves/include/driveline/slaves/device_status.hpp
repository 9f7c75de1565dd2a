#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "driveline/wire/al.hpp"

namespace driveline::slaves {

/// A text of at most Size bytes; longer texts are truncated. Trivially copyable.
template <std::size_t Size>
struct FixedText {
  std::array<char, Size> bytes{};  ///< padded with 0

  /// Copies the text, truncated to Size bytes. \rtsafe
  constexpr FixedText& operator=(std::string_view text) noexcept {
    bytes.fill(0);
    std::copy_n(text.begin(), std::min(text.size(), Size), bytes.begin());
    return *this;
  }
  /// Returns the text up to the first 0. \rtsafe
  [[nodiscard]] constexpr std::string_view view() const noexcept {
    return {bytes.begin(), static_cast<std::size_t>(std::find(bytes.begin(), bytes.end(), '\0') - bytes.begin())};
  }
};

/// Status that a device displays, e.g. on its web page. Trivially copyable, so that rings and sockets transfer it as it
/// is.
struct DeviceStatus {
  static constexpr std::size_t kMaxValues = 32;  ///< capacity of `values`
  /// A number with its name and unit.
  struct Value {
    FixedText<32> name;      ///< name for display
    FixedText<12> unit;      ///< empty: none
    std::uint32_t kind = 0;  ///< a value of Kind
    double value = 0.0;      ///< number in `unit`
  };
  /// Kind of a value.
  enum class Kind : std::uint32_t { kActual, kParameter };

  FixedText<40> maker;                            ///< name of the manufacturer
  FixedText<40> type;                             ///< device name
  FixedText<64> name;                             ///< name assigned by the user
  FixedText<16> firmware;                         ///< firmware version
  std::uint32_t vendor_id = 0;                    ///< 1018h:01
  std::uint32_t product_code = 0;                 ///< 1018h:02
  std::uint32_t revision = 0;                     ///< 1018h:03
  std::uint32_t serial_number = 0;                ///< 1018h:04
  wire::AlState al_state = wire::AlState::kInit;  ///< state of the slave controller
  bool fault = false;                             ///< a fault is present
  std::uint16_t control_word = 0;                 ///< 6040h
  std::uint16_t status_word = 0;                  ///< 6041h
  std::uint16_t error_code = 0;                   ///< 603Fh
  FixedText<32> state;                            ///< state of a drive, for display; empty: not a drive
  FixedText<32> mode;                             ///< mode of operation, for display
  FixedText<48> message;                          ///< text of the fault
  FixedText<8> display;                           ///< characters on the display; empty: no display
  std::uint32_t value_count = 0;                  ///< number of valid elements of `values`
  std::array<Value, kMaxValues> values{};         ///< only the first `value_count` are valid

  /// Adds a value; ignored when `values` is full. \rtsafe
  void add(Kind kind, std::string_view value_name, double value, std::string_view unit = {}) noexcept {
    if (value_count >= kMaxValues) return;
    Value& place = values[value_count++];
    place.name = value_name;
    place.unit = unit;
    place.kind = static_cast<std::uint32_t>(kind);
    place.value = value;
  }
  /// Returns the valid values. \rtsafe
  [[nodiscard]] std::span<const Value> shown() const noexcept {
    return std::span(values).first(std::min<std::size_t>(value_count, kMaxValues));
  }
};

}  // namespace driveline::slaves

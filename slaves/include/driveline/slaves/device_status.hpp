#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "driveline/wire/al.hpp"

namespace driveline::slaves {

/// A text of at most Size bytes, cut off where it is longer; trivially copyable.
template <std::size_t Size>
struct FixedText {
  std::array<char, Size> bytes{};  ///< padded with 0

  /// Takes the text, or as much of it as fits. \rtsafe
  constexpr FixedText& operator=(std::string_view text) noexcept {
    bytes.fill(0);
    std::copy_n(text.begin(), std::min(text.size(), Size), bytes.begin());
    return *this;
  }
  /// Up to the first 0. \rtsafe
  [[nodiscard]] constexpr std::string_view view() const noexcept {
    return {bytes.begin(), static_cast<std::size_t>(std::find(bytes.begin(), bytes.end(), '\0') - bytes.begin())};
  }
};

/// What a device shows of itself to people: on its web page. Trivially copyable, so that it goes through rings and
/// sockets as it is.
struct DeviceStatus {
  static constexpr std::size_t kMostValues = 32;  ///< that it has room for
  /// A number with its name and unit.
  struct Value {
    FixedText<32> name;      ///< in words
    FixedText<12> unit;      ///< empty: none
    std::uint32_t kind = 0;  ///< of Kind
    double value = 0.0;      ///< in this unit
  };
  /// What a value is.
  enum class Kind : std::uint32_t { kActual, kParameter };

  FixedText<40> maker;                            ///< of the device
  FixedText<40> type;                             ///< device name
  FixedText<64> name;                             ///< that its owner gave it
  FixedText<16> firmware;                         ///< version
  std::uint32_t vendor_id = 0;                    ///< 1018h:01
  std::uint32_t product_code = 0;                 ///< 1018h:02
  std::uint32_t revision = 0;                     ///< 1018h:03
  std::uint32_t serial_number = 0;                ///< 1018h:04
  wire::AlState al_state = wire::AlState::kInit;  ///< of its slave controller
  bool fault = false;                             ///< one stands
  std::uint16_t control_word = 0;                 ///< 6040h
  std::uint16_t status_word = 0;                  ///< 6041h
  std::uint16_t error_code = 0;                   ///< 603Fh
  FixedText<32> state;                            ///< of a drive, in words; empty: it is no drive
  FixedText<32> mode;                             ///< of operation, in words
  FixedText<48> message;                          ///< of the fault, in words
  FixedText<8> display;                           ///< what is lit on it; empty: it has none
  std::uint32_t value_count = 0;                  ///< of `values`
  std::array<Value, kMostValues> values{};        ///< those behind the count mean nothing

  /// Adds a value; one too many is left out. \rtsafe
  void add(Kind kind, std::string_view value_name, double value, std::string_view unit = {}) noexcept {
    if (value_count >= kMostValues) return;
    Value& place = values[value_count++];
    place.name = value_name;
    place.unit = unit;
    place.kind = static_cast<std::uint32_t>(kind);
    place.value = value;
  }
  /// Those that there are. \rtsafe
  [[nodiscard]] std::span<const Value> shown() const noexcept {
    return std::span(values).first(std::min<std::size_t>(value_count, kMostValues));
  }
};

}  // namespace driveline::slaves

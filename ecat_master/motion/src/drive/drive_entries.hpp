#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "driveline/motion/cia301/pdo_configuration.hpp"
#include "driveline/motion/cia301/pdo_entry.hpp"
#include "driveline/motion/drive/axis_objects.hpp"

namespace driveline::motion {

/// Entry of an object in the process data of a direction, which start at `base`; empty: not mapped with this width.
template <typename T>
[[nodiscard]] std::optional<PdoEntry<T>> entry(const std::vector<PdoMapping>& pdos, std::size_t base,
                                               std::uint16_t index, std::uint8_t subindex = 0) {
  const auto offset = object_offset(pdos, index, 8 * sizeof(T), subindex);
  return offset ? std::optional(PdoEntry<T>(base + *offset)) : std::nullopt;
}

/// Rounds to the nearest integer; |value| < 2^62. Takes a few instructions, while std::llround is a library call,
/// needed several times per axis and cycle.
[[nodiscard]] inline std::int64_t to_nearest(double value) noexcept {
  return static_cast<std::int64_t>(value + std::copysign(0.5, value));
}

/// Rounds to a wire integer; out-of-range values saturate, NaN becomes zero.
template <typename T>
[[nodiscard]] T saturate(double value) noexcept {
  if (std::isnan(value)) return 0;
  constexpr auto kMin = static_cast<double>(std::numeric_limits<T>::min());
  constexpr auto kMax = static_cast<double>(std::numeric_limits<T>::max());
  return static_cast<T>(to_nearest(std::clamp(value, kMin, kMax)));
}

/// Writes the value; does nothing if the object is not mapped.
template <typename T>
void put(const std::optional<PdoEntry<T>>& pdo_entry, std::span<std::byte> image, T value) noexcept {
  if (pdo_entry) pdo_entry->set(image, value);
}

/// Reads the value; zero if the object is not mapped.
template <typename T>
[[nodiscard]] T take(const std::optional<PdoEntry<T>>& pdo_entry, std::span<const std::byte> image) noexcept {
  return pdo_entry ? pdo_entry->get(image) : T{0};
}

}  // namespace driveline::motion

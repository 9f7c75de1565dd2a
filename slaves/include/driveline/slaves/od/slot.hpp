#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "driveline/esi/data_type.hpp"

namespace driveline::slaves {

/// Number of a value of type T in an ObjectDictionary. Access as another type does not compile.
template <typename T>
struct Slot {
  std::uint16_t number = 0;  ///< EntryRow::slot of the rows with this value
};

/// Consecutive slots of N values of the same type.
template <typename T, std::size_t N>
struct SlotArray {
  std::uint16_t first = 0;  ///< number of the first slot

  /// Precondition: i < N. \rtsafe
  [[nodiscard]] constexpr Slot<T> operator[](std::size_t i) const noexcept {
    return {static_cast<std::uint16_t>(first + i)};
  }
  /// \rtsafe
  [[nodiscard]] static constexpr std::size_t size() noexcept { return N; }
  /// Whether `number` is the slot of an element. \rtsafe
  [[nodiscard]] constexpr bool contains(std::uint16_t number) const noexcept {
    return number >= first && number < first + N;
  }
};

/// Base of the values that an application uses: a struct whose members are slots, numbered in the order of declaration.
///
///     struct Values : SlotNumbers {
///       constexpr Values() noexcept : SlotNumbers(0) {}
///       Slot<float> gain{next()};
///       SlotArray<std::int32_t, 4> positions{next(4)};
///     };
///     inline constexpr Values kValue{};
class SlotNumbers {
 public:
  /// Starts the numbers at `first`: 0, or end() of another struct.
  explicit constexpr SlotNumbers(std::uint16_t first) noexcept : next_(first) {}
  /// Returns the number after the last one. \rtsafe
  [[nodiscard]] constexpr std::uint16_t end() const noexcept { return next_; }

 protected:
  /// Returns the next number, for the initialiser of a member; reserves `count` numbers for an array.
  constexpr std::uint16_t next(std::uint16_t count = 1) noexcept {
    return std::exchange(next_, static_cast<std::uint16_t>(next_ + count));
  }

 private:
  std::uint16_t next_;
};

/// Returns the data type of rows whose values have type T.
template <typename T>
[[nodiscard]] constexpr esi::DataType data_type() noexcept {
  using enum esi::DataType;
  if constexpr (std::is_same_v<T, bool>) return kBoolean;
  if constexpr (std::is_same_v<T, float>) return kReal32;
  if constexpr (std::is_same_v<T, std::int8_t>) return kInteger8;
  if constexpr (std::is_same_v<T, std::int16_t>) return kInteger16;
  if constexpr (std::is_same_v<T, std::int32_t>) return kInteger32;
  if constexpr (std::is_same_v<T, std::uint8_t>) return kUnsigned8;
  if constexpr (std::is_same_v<T, std::uint16_t>) return kUnsigned16;
  if constexpr (std::is_same_v<T, std::uint32_t>) return kUnsigned32;
}

}  // namespace driveline::slaves

#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace driveline::motion {

/// An object in a PDO, as in the mapping objects 1600h and 1A00h.
struct MappedObject {
  std::uint16_t index = 0;    ///< index of the object; 0 with sub-index 0: a gap
  std::uint8_t subindex = 0;  ///< sub-index of the entry
  std::uint8_t bits = 0;      ///< length in the process data

  /// The entry in wire format: index << 16 | sub-index << 8 | bits (ETG.1000.6 Table 74).
  [[nodiscard]] constexpr std::uint32_t raw() const noexcept {
    return (std::uint32_t{index} << 16) | (std::uint32_t{subindex} << 8) | bits;
  }
  /// The inverse of raw(); every number is valid.
  [[nodiscard]] static constexpr MappedObject from_raw(std::uint32_t raw) noexcept {
    return {static_cast<std::uint16_t>(raw >> 16), static_cast<std::uint8_t>(raw >> 8), static_cast<std::uint8_t>(raw)};
  }
  constexpr bool operator==(const MappedObject&) const = default;
};

/// A PDO and its mapping.
struct PdoMapping {
  std::uint16_t index = 0;                     ///< mapping object, 1600h-17FFh or 1A00h-1BFFh
  std::vector<MappedObject> objects;           ///< in the order of the process data; empty: the slave's mapping is kept
  std::optional<std::uint8_t> sync_manager{};  ///< empty: the first of its direction
  bool own_mapping = false;                    ///< `objects` were read from the slave and are not written
  /// Length of the PDO in the process data, in bits.
  [[nodiscard]] std::size_t bits() const noexcept;
};

/// The PDOs of a slave: outputs on sync manager 2 (1C12h), inputs on sync manager 3 (1C13h).
struct PdoConfiguration {
  std::vector<PdoMapping> outputs;  ///< RxPDOs in the order of their assignment
  std::vector<PdoMapping> inputs;   ///< TxPDOs in the order of their assignment
  /// Size of the output process data in bytes, rounded up.
  [[nodiscard]] std::size_t output_bytes() const noexcept;
  /// Size of the input process data in bytes, rounded up.
  [[nodiscard]] std::size_t input_bytes() const noexcept;
};

/// Whether two mappings have the same objects and sizes; the representation of a gap does not matter.
[[nodiscard]] bool same_content(std::span<const MappedObject> a, std::span<const MappedObject> b) noexcept;
/// Whether a slave exchanges the planned PDOs, in this order, when it has assigned `present`. Planned PDOs without
/// objects, or with objects that were read from the slave, are compared by their index only.
[[nodiscard]] bool same_pdos(std::span<const PdoMapping> planned, std::span<const PdoMapping> present) noexcept;

/// Size of the process data of these PDOs in bytes, rounded up.
[[nodiscard]] std::size_t bytes_of(std::span<const PdoMapping> pdos) noexcept;

}  // namespace driveline::motion

#pragma once

#include <array>
#include <span>

#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves {

/// Limits of a device's process data.
struct PdoLimits {
  std::uint8_t pdos = 4;     ///< PDOs per direction
  std::uint8_t objects = 8;  ///< mapped objects per PDO
  std::uint16_t bytes = 8;   ///< bytes per PDO
  std::uint16_t rx_first = 0x1600;
  std::uint16_t tx_first = 0x1A00;
};

enum class PdoDirection : std::uint8_t { kRx, kTx };

/// The process data of one direction resolved to slots: made once when the mapping is complete, then decoding and
/// encoding need no lookup.
class PdoMap {
 public:
  static constexpr std::size_t kMaxFields = 32;

  /// Reads assignment 1C12h or 1C13h and the mappings it names. The dictionary holds only what PdoRules let in.
  void build(const ObjectDictionary& dictionary, PdoDirection direction, const PdoLimits& limits) noexcept;

  /// Bytes of process data.
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  /// Process data into values; bytes that are missing at the end leave their values alone. \rtsafe
  void decode(std::span<const std::byte> data, ObjectDictionary& dictionary) const noexcept;
  /// Values into process data, as many bytes as there is room for. \rtsafe
  void encode(const ObjectDictionary& dictionary, std::span<std::byte> data) const noexcept;

 private:
  struct Field {
    std::uint16_t slot = 0;
    std::uint16_t offset = 0;
    std::uint8_t bytes = 0;
    bool is_signed = false;
    bool constant = false;
    std::uint32_t constant_value = 0;
  };
  void append(const ObjectDictionary& dictionary, std::uint32_t entry) noexcept;

  std::array<Field, kMaxFields> fields_{};
  std::size_t count_ = 0;
  std::size_t size_ = 0;
};

/// The rules for writing PDO mappings (1600h.., 1A00h..) and assignments (1C12h, 1C13h): entries only while sub-index
/// 0 is 0, at most the device's number of objects and bytes, only objects that exist and can be mapped
/// (CiA 301 7.2.5.3, ETG.1000.6 5.6.7). Rows that are none of these objects are accepted.
[[nodiscard]] SdoResult<void> check_pdo_write(const ObjectDictionary& dictionary, const PdoLimits& limits,
                                              const EntryRow& row, std::uint32_t raw);

}  // namespace driveline::slaves

#pragma once

#include <array>
#include <span>
#include <vector>

#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves {

/// Limits of a device's process data.
struct PdoLimits {
  std::uint16_t pdos = 4;                        ///< PDOs per direction
  std::uint8_t objects = 8;                      ///< mapped objects per PDO
  std::uint16_t bytes = 8;                       ///< bytes per PDO
  std::uint16_t rx_first = 0x1600;               ///< index of the first RxPDO mapping
  std::uint16_t tx_first = 0x1A00;               ///< index of the first TxPDO mapping
  std::uint32_t output_sync_managers = 1U << 2;  ///< bit n: sync manager n transfers RxPDOs
  std::uint32_t input_sync_managers = 1U << 3;   ///< bit n: sync manager n transfers TxPDOs
  bool gaps = false;                             ///< a mapping may have gaps: index 0 with a number of bits
  bool even_bytes = false;                       ///< a PDO must have an even number of bytes
  bool locked = true;    ///< entries of a mapping are written while sub-index 0 is 0 only (CiA 301 7.5.2.36)
  bool dummies = false;  ///< an RxPDO may have dummy entries: data types 0001h-0007h (CiA 301 7.4.7)
};

/// Returns the object that lists the PDOs assigned to a sync manager (ETG.1000.6 5.6.7.4: 1C10h plus its number).
[[nodiscard]] constexpr std::uint16_t assignment_object(std::size_t sync_manager) noexcept {
  return static_cast<std::uint16_t>(0x1C10 + sync_manager);
}

/// Process data of a sync manager, resolved to slots once when the mapping is complete, so that decoding and encoding
/// need no lookup. Entries may have any number of bits and cross byte boundaries.
class PdoMap {
 public:
  /// Enough entries for drives with 4 PDOs of 8 objects.
  static constexpr std::size_t kDefaultFields = 32;

  /// Where the value of an entry is.
  enum class Storage : std::uint8_t {
    kUnsigned,  ///< a number in `slot`
    kSigned,    ///< a number in `slot`, of which decode() extends the sign
    kText,      ///< `slot` belongs to a row that is stored as bytes
    kConstant,  ///< the initial value of the row; decode() skips it
  };
  /// An entry of the process data; gaps have none.
  struct Field {
    const EntryRow* row = nullptr;         ///< the mapped entry
    std::uint32_t bit_offset = 0;          ///< position in the process data
    std::uint16_t slot = 0;                ///< slot in the dictionary, of a text or a number
    std::uint8_t bits = 0;                 ///< length in the process data
    Storage storage = Storage::kUnsigned;  ///< what `slot` means
    /// Whether the value is stored as bytes. \rtsafe
    [[nodiscard]] bool is_text() const noexcept { return storage == Storage::kText; }
    /// Whether the value is a number with a slot. \rtsafe
    [[nodiscard]] bool is_number() const noexcept { return storage <= Storage::kSigned; }
  };

  /// Holds at most `max_fields` entries; further entries are ignored.
  explicit PdoMap(std::size_t max_fields = kDefaultFields) {
    fields_.reserve(max_fields);
    copies_.reserve(max_fields);
  }

  /// Reads the assignment of the sync manager and the mappings of its PDOs. Precondition: check_pdo_write() has
  /// accepted their values. Does not allocate. \rtsafe
  void build(const ObjectDictionary& dictionary, std::size_t sync_manager, const PdoLimits& limits) noexcept;

  /// Reads the mapping of the one PDO whose mapping object is `mapping`, for buses where each PDO is a message. The
  /// same precondition. Does not allocate. \rtsafe
  void build_pdo(const ObjectDictionary& dictionary, std::uint16_t mapping, const PdoLimits& limits) noexcept;

  /// Returns the length of the process data in bytes.
  [[nodiscard]] std::size_t size() const noexcept { return (bits_ + 7) / 8; }
  /// Returns the entries in the order of the process data. \rtsafe
  [[nodiscard]] std::span<const Field> fields() const noexcept { return fields_; }
  /// Returns the first entry of this object; null: it is not mapped. \rtsafe
  [[nodiscard]] const Field* find(std::uint16_t index, std::uint8_t subindex) const noexcept;
  /// Copies process data to values; values whose entry is not completely contained in `data` do not change. \rtsafe
  void decode(std::span<const std::byte> data, ObjectDictionary& dictionary) const noexcept;
  /// Copies values to process data, for all entries that fit into `data`. Gaps and padding do not change. \rtsafe
  void encode(const ObjectDictionary& dictionary, std::span<std::byte> data) const noexcept;

 private:
  /// What a cycle needs of an entry of 1, 2 or 4 whole bytes.
  struct Copy {
    std::uint16_t place = 0;  ///< first byte in the process data
    std::uint16_t slot = 0;   ///< slot in the dictionary
  };
  /// The order of the copies: those of the same kind follow one another.
  enum Kind : std::uint8_t { kSigned32, kUnsigned32, kSigned16, kUnsigned16, kSigned8, kUnsigned8, kKinds };

  void clear() noexcept;
  void append_pdo(const ObjectDictionary& dictionary, std::uint16_t mapping, const PdoLimits& limits) noexcept;
  void append(const ObjectDictionary& dictionary, std::uint32_t entry) noexcept;
  void append_copy(const Field& field) noexcept;
  // Not inlined: the registers that they need would be saved in every cycle.
  [[gnu::noinline]] void decode_fields(std::span<const std::byte> data, ObjectDictionary& dictionary) const noexcept;
  [[gnu::noinline]] void encode_fields(const ObjectDictionary& dictionary, std::span<std::byte> data) const noexcept;

  std::vector<Field> fields_;
  std::vector<Copy> copies_;                  ///< of all such entries
  std::array<std::uint16_t, kKinds> ends_{};  ///< end of the copies of each kind
  std::size_t bits_ = 0;
  bool copies_only_ = true;  ///< every field has a copy
};

/// Checks a write to a PDO mapping (1600h.., 1A00h..) or assignment (1C10h + n): entries are writable only while
/// sub-index 0 is 0 (PdoLimits::locked), the device limits the number of objects and bytes, and objects must exist and
/// be mappable (CiA 301 7.2.5.3, ETG.1000.6 5.6.7). Other rows are accepted.
[[nodiscard]] SdoResult<void> check_pdo_write(const ObjectDictionary& dictionary, const PdoLimits& limits,
                                              const EntryRow& row, std::uint64_t raw);

}  // namespace driveline::slaves

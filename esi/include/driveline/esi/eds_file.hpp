#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/esi/device_description.hpp"

/// Electronic data sheets (EDS) of CANopen devices, and device configuration files (DCF), which add the values and the
/// place of one device (CiA 306-1).
namespace driveline::esi {

/// An entry of the object dictionary.
struct EntryAddress {
  std::uint16_t index = 0;    ///< index of the object
  std::uint8_t subindex = 0;  ///< sub-index within the object
  bool operator==(const EntryAddress&) const = default;
  /// Ascending by index, then by sub-index.
  bool operator<(const EntryAddress& other) const noexcept {
    return index != other.index ? index < other.index : subindex < other.subindex;
  }
};

/// A part of the file that was skipped or interpreted; not an error.
struct EdsNote {
  std::size_t line = 0;  ///< 1-based
  std::string text;      ///< one sentence
  bool operator==(const EdsNote&) const = default;
};

/// Value of an entry in a DCF.
struct EdsValue {
  EntryAddress entry;
  std::string hex;            ///< raw little-endian value as hex digits, like ObjectEntry::default_hex
  bool adds_node_id = false;  ///< the node-ID is added to the value
  bool operator==(const EdsValue&) const = default;
};

/// Place of a device on its bus, section DeviceComissioning of a DCF.
struct EdsPlace {
  std::uint8_t node_id = 0;    ///< 1 to 127
  std::uint16_t bit_rate = 0;  ///< kbit/s; 0: not specified
  std::string name;            ///< name of the node
  bool operator==(const EdsPlace&) const = default;
};

/// Content of an EDS or DCF.
struct EdsFile {
  /// Identity, names and objects. `rx_pdos` and `tx_pdos` are those of the mapping objects (1600h-17FFh, 1A00h-1BFFh)
  /// with their defaults.
  DeviceDescription device;
  std::vector<EntryAddress> node_id_defaults;  ///< entries whose default adds the node-ID, ascending
  std::vector<std::uint16_t> bit_rates;        ///< supported bit rates in kbit/s, ascending
  bool lss = false;                            ///< node-ID and bit rate can be set over the bus (CiA 305)
  std::optional<EdsPlace> place{};             ///< none: an EDS
  std::vector<EdsValue> values{};              ///< values of a DCF, ascending by entry
  std::vector<EdsNote> notes{};                ///< parts that were skipped or interpreted

  /// Returns the default of an entry with the node-ID, as little-endian hex digits; empty: none, or no such entry.
  [[nodiscard]] std::string default_hex(EntryAddress entry, std::uint8_t node_id) const;
};

/// Why a file was not accepted.
struct EdsError {
  std::string file;      ///< name that was passed to the reader
  std::size_t line = 0;  ///< 1-based
  std::string problem;   ///< content that the reader found, and what it expected
  bool operator==(const EdsError&) const = default;
};

/// Formats the error as a sentence, "file:line: problem".
[[nodiscard]] std::string describe(const EdsError& error);

/// Reads an EDS or DCF in UTF-8, UTF-16 or ISO 8859-1. `file_name` is used in messages only.
///
/// Required is a list of objects; everything else is optional. Accepted beyond CiA 306-1, because files of vendors have
/// it: any letter case, `$NODEID` before or after the number, white space in formulas, objects that are not in a list,
/// counts that are wrong, values that do not fit their type. The last four, and data types without a counterpart in
/// DataType, are in EdsFile::notes.
[[nodiscard]] tl::expected<EdsFile, EdsError> read_eds(std::string_view text, std::string_view file_name);

/// Writes an EDS, or a DCF if the file has a place. Equal input gives equal bytes: the file contains no date. A
/// text with characters beyond ASCII is left out. read_eds() returns the same content, but without notes, if texts are
/// as long as their defaults and PDOs those of the mapping objects.
[[nodiscard]] std::string write_eds(const EdsFile& file, std::string_view file_name);

/// Writes the device's objects as an EDS without bit rates, as CANopen configuration tools read it for a device with
/// CoE.
[[nodiscard]] std::string write_eds(const DeviceDescription& device, std::string_view file_name);

}  // namespace driveline::esi

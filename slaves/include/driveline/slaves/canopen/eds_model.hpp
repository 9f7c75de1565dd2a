#pragma once

#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/esi/eds_file.hpp"
#include "driveline/slaves/canopen/device_options.hpp"
#include "driveline/slaves/device_signals.hpp"
#include "driveline/slaves/od/dictionary_table.hpp"

namespace driveline::slaves::cia301 {

/// Why no device can be created from a file.
struct EdsModelError {
  /// What is wrong.
  enum class Fault : std::uint8_t {
    kTooManyPdos,        ///< `index` is beyond the PDOs of the simulation
    kTooManyEntries,     ///< `count` objects and entries are more than a dictionary can hold
    kNoNumber,           ///< the stack needs a number in this entry, which is a text or a domain
    kImpossibleMapping,  ///< no master could write the default mapping in this object
  };
  Fault fault = Fault::kTooManyPdos;
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
  std::size_t count = 0;
};

/// Formats the error as a sentence about the device.
[[nodiscard]] std::string describe(const EdsModelError& error);

/// Common data of all devices of an EDS or DCF: the object dictionary, and what the stack needs beside it.
///
/// What the file does not say follows CiA 301: the COB-IDs of the predefined connection set for the first four PDOs,
/// others do not exist, event-driven PDOs. Values of a DCF replace the defaults. Entries that can be written and are no
/// process data can be stored, where the device has 1010h.
class EdsModel {
 public:
  static constexpr std::uint16_t kMostPdos = 128;      ///< of each direction
  static constexpr std::size_t kMostEntries = 0xFF00;  ///< slot numbers have 16 bits

  /// Creates the model of a device with this data sheet.
  [[nodiscard]] static tl::expected<std::shared_ptr<const EdsModel>, EdsModelError> create(esi::EdsFile file);

  EdsModel(const EdsModel&) = delete;  // rows refer to the texts of this object
  EdsModel& operator=(const EdsModel&) = delete;
  ~EdsModel() = default;

  /// Returns the content of the file.
  [[nodiscard]] const esi::EdsFile& file() const noexcept { return file_; }
  /// Returns the rows of all objects; they live as long as the model.
  [[nodiscard]] const DictionaryTable& table() const noexcept { return *table_; }
  /// Returns the settings of the device.
  [[nodiscard]] const DeviceOptions& options() const noexcept { return options_; }

  /// A PDO entry with its names: "Channel 1/Value" has that of its PDO as prefix.
  struct NamedEntry {
    std::string name;               ///< full name
    std::string short_name;         ///< name of the entry alone
    const EntryRow* row = nullptr;  ///< row in table(); never null
  };
  /// Returns the entries of all default TPDOs (inputs) or RPDOs (outputs); each entry appears once.
  [[nodiscard]] const std::vector<NamedEntry>& entries(SignalId::Direction direction) const noexcept {
    return direction == SignalId::Direction::kInput ? inputs_ : outputs_;
  }
  /// Returns the place of an entry in entries() by its full name, its name, or its address "6000:01".
  [[nodiscard]] tl::expected<std::size_t, SignalNameError> find_entry(SignalId::Direction direction,
                                                                      std::string_view name) const;

 private:
  friend class EdsModelBuilder;
  EdsModel() = default;

  esi::EdsFile file_;
  std::deque<std::string> texts_;
  std::unique_ptr<const DictionaryTable> table_;
  DeviceOptions options_;
  std::vector<NamedEntry> inputs_;
  std::vector<NamedEntry> outputs_;
};

}  // namespace driveline::slaves::cia301

#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/esi/device_description.hpp"

/// EtherCAT slave information (ESI) files: XML descriptions of devices for configuration tools (ETG.2000).
namespace driveline::esi {

/// An element of the file that was skipped or interpreted; not an error.
struct EsiNote {
  std::size_t line = 0;  ///< 1-based
  std::string path;      ///< element path, e.g. EtherCATInfo/Descriptions/Devices/Device[2]/Slots
  std::string text;      ///< one sentence
  bool operator==(const EsiNote&) const = default;
};

/// Selects a device of a file. Empty fields match any device.
struct DeviceChoice {
  std::string name;                           ///< type or name of the device; case is ignored
  std::optional<std::uint32_t> product_code;  ///< exact product code; empty: any
  std::optional<std::uint32_t> revision;      ///< exact revision; empty: the highest
};

/// Why a DeviceChoice selects no device of a file.
struct DeviceChoiceError {
  /// Kind of failure.
  enum class Fault : std::uint8_t {
    kNoDevice,  ///< the file describes no device
    kNoneFits,  ///< none of `devices` matches
    kSeveral,   ///< `devices` of several products match
  };
  /// A device that the error lists.
  struct Candidate {
    std::string type;                ///< as in the file
    std::uint32_t product_code = 0;  ///< as in the file
    std::uint32_t revision = 0;      ///< as in the file
  };
  Fault fault = Fault::kNoDevice;  ///< kind of failure
  DeviceChoice choice;             ///< the requested device
  std::vector<Candidate> devices;  ///< in the order of the file
};

/// Formats the error as a sentence that lists the available devices.
[[nodiscard]] std::string describe(const DeviceChoiceError& error);

/// Content of an ESI file.
struct EsiFile {
  std::uint32_t vendor_id = 0;             ///< vendor ID assigned by the ETG
  std::string vendor_name;                 ///< as in the file
  std::vector<DeviceDescription> devices;  ///< all revisions, in the order of the file
  std::vector<EsiNote> notes;              ///< elements that were skipped or interpreted

  /// Returns the device with exactly this identity, or nullptr when the file has none.
  [[nodiscard]] const DeviceDescription* find_device(std::uint32_t vendor, std::uint32_t product,
                                                     std::uint32_t revision) const noexcept;
  /// Returns the matching device: the highest revision when several revisions of a single product match.
  [[nodiscard]] tl::expected<const DeviceDescription*, DeviceChoiceError> choose(const DeviceChoice& choice) const;
};

/// Why a file was not accepted.
struct EsiError {
  std::string file;        ///< name that was passed to the reader
  std::size_t line = 0;    ///< 1-based
  std::size_t offset = 0;  ///< bytes from the start of the file (of its UTF-8 form for files in other encodings)
  std::string path;        ///< element path; empty when the XML itself is not well formed
  std::string problem;     ///< content that the reader found
  std::string expected;    ///< content that the reader expected; empty when `problem` says it
};

/// Formats the error as a sentence, "file:line: path: problem, expected ...".
[[nodiscard]] std::string to_text(const EsiError& error);
/// The same.
[[nodiscard]] inline std::string describe(const EsiError& error) {
  return to_text(error);
}

/// Reads an ESI file in UTF-8, UTF-16 or ISO 8859-1. `file_name` is used in messages only.
///
/// Required are the root element, a vendor ID, and the type of each device; everything else is optional. Where a name
/// has several languages, English (LcId 1033) is used. Vendor-specific elements are skipped; modules and slots add a
/// note.
[[nodiscard]] tl::expected<EsiFile, EsiError> read_esi(std::string_view xml, std::string_view file_name);

/// Writes the devices as one ESI file; equal input gives equal bytes. The vendor is taken from the first device.
///
/// read_esi() returns equal descriptions if these are in normal form: names without outer white space, hex texts in
/// upper case, gaps in PDOs of default type, an object of code kVariable with one entry that has the object's name, an
/// array with sub-index 0 and elements that share type and access, sub-indices ascending. Any other description is
/// written in the closest form that the schema allows (such an array as a record).
[[nodiscard]] std::string write_esi(const std::vector<DeviceDescription>& devices);

}  // namespace driveline::esi

#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/esi/device_description.hpp"

/// EtherCAT slave information files: the XML description of devices that configuration tools read (ETG.2000).
namespace driveline::esi {

/// An element of the file that was left out or interpreted; no error.
struct EsiNote {
  std::size_t line = 0;  ///< 1-based
  std::string path;      ///< element path, e.g. EtherCATInfo/Descriptions/Devices/Device[2]/Slots
  std::string text;      ///< one sentence
  bool operator==(const EsiNote&) const = default;
};

/// Selects a device of a file. Empty fields match any device.
struct DeviceChoice {
  std::string name;                           ///< type or name of the device, upper or lower case
  std::optional<std::uint32_t> product_code;  ///< exactly; nothing: any
  std::optional<std::uint32_t> revision;      ///< exactly; nothing: the highest
};

/// Why a DeviceChoice selects no device of a file.
struct DeviceChoiceError {
  /// Kind of failure.
  enum class Fault : std::uint8_t {
    kNoDevice,  ///< the file describes none
    kNoneFits,  ///< none of `devices` matches
    kSeveral,   ///< `devices` of several products match
  };
  /// A device that the error names.
  struct Candidate {
    std::string type;                ///< as in the file
    std::uint32_t product_code = 0;  ///< as in the file
    std::uint32_t revision = 0;      ///< as in the file
  };
  Fault fault = Fault::kNoDevice;  ///< kind of failure
  DeviceChoice choice;             ///< what was asked for
  std::vector<Candidate> devices;  ///< in the order of the file
};

/// The error as a sentence, with the devices that are there.
[[nodiscard]] std::string describe(const DeviceChoiceError& error);

/// What an ESI file holds.
struct EsiFile {
  std::uint32_t vendor_id = 0;             ///< of the ETG
  std::string vendor_name;                 ///< as in the file
  std::vector<DeviceDescription> devices;  ///< in the order of the file, every revision
  std::vector<EsiNote> notes;              ///< what was left out or interpreted

  /// The device with exactly this identity, nullptr when the file has none.
  [[nodiscard]] const DeviceDescription* find_device(std::uint32_t vendor, std::uint32_t product,
                                                     std::uint32_t revision) const noexcept;
  /// The device that matches; of several revisions of one product the highest.
  [[nodiscard]] tl::expected<const DeviceDescription*, DeviceChoiceError> choose(const DeviceChoice& choice) const;
};

/// Why a file was not accepted.
struct EsiError {
  std::string file;        ///< as it was given to the reader
  std::size_t line = 0;    ///< 1-based
  std::size_t offset = 0;  ///< bytes from the start of the file (of its UTF-8 form, for files in other encodings)
  std::string path;        ///< element path; empty when the XML itself is not well formed
  std::string problem;     ///< what is there
  std::string expected;    ///< what should be there; empty when the problem says it
};

/// The error as a sentence, "file:line: path: problem, expected ...".
[[nodiscard]] std::string to_text(const EsiError& error);

/// Reads an ESI file in UTF-8, UTF-16 or ISO 8859-1. `file_name` is for messages only.
///
/// Required: the root element, a vendor id, and per device its type; everything else may be missing. Names are taken
/// in English (LcId 1033) where there is a choice. Elements of vendors are passed over; modules and slots get a note.
[[nodiscard]] tl::expected<EsiFile, EsiError> read_esi(std::string_view xml, std::string_view file_name);

/// Writes the devices as one ESI file; equal input gives equal bytes. The vendor is that of the first device.
///
/// read_esi() gives back equal descriptions if these are in normal form: names without outer white space, hex texts in
/// upper case, gaps in PDOs of default type, an object of code kVariable with one entry of the object's name, an array
/// with sub-index 0 and elements of one type and one access, sub-indices ascending. A description outside the form is
/// written as near to it as the schema allows (such an array as a record).
[[nodiscard]] std::string write_esi(const std::vector<DeviceDescription>& devices);

}  // namespace driveline::esi

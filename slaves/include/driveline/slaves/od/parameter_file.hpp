#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves {

/// An error in a parameter file, and its line.
struct ParameterFileError {
  std::size_t line = 0;  ///< starts at 1; 0: the file as a whole
  std::string what;      ///< a sentence without the line number
};

/// Writes the stored parameters of a device as text, one per line: `6085:00 = 419430400  # Quick stop deceleration`.
/// Numbers are decimal, strings are quoted. Aliases appear once.
[[nodiscard]] std::string write_parameters(const ObjectDictionary& dictionary);

/// Sets the parameters in `text`; none when a line is refused (no such object, not a stored parameter, out of range).
[[nodiscard]] tl::expected<void, ParameterFileError> read_parameters(std::string_view text,
                                                                     ObjectDictionary& dictionary);

/// Replaces `path` completely or not at all: writes a temporary file beside it, synchronises it to the disk and renames
/// it. An error contains the system's reason.
[[nodiscard]] tl::expected<void, ParameterFileError> save_parameter_file(const std::string& path,
                                                                         const ObjectDictionary& dictionary);
/// Reads the parameters from `path`. A file that does not exist changes nothing and is not an error.
[[nodiscard]] tl::expected<void, ParameterFileError> load_parameter_file(const std::string& path,
                                                                         ObjectDictionary& dictionary);

}  // namespace driveline::slaves

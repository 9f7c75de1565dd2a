#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves {

/// An error in a parameter file, and where. `line` counts from 1; 0: the file as a whole.
struct ParameterFileError {
  std::size_t line = 0;  ///< from 1; 0: the file as a whole
  std::string what;      ///< a sentence without the line
};

/// The stored parameters of a device as text, one per line: `6085:00 = 419430400  # Quick stop deceleration`.
/// Numbers are decimal, strings in quotes. Aliases appear once.
[[nodiscard]] std::string write_parameters(const ObjectDictionary& dictionary);

/// Sets the parameters in `text`. When a line is refused (no such object, not a stored one, out of range), nothing is
/// changed.
[[nodiscard]] tl::expected<void, ParameterFileError> read_parameters(std::string_view text,
                                                                     ObjectDictionary& dictionary);

/// Replaces `path` as a whole or not at all: written beside it, synchronised to the disk, renamed. An error carries the
/// system's reason.
[[nodiscard]] tl::expected<void, ParameterFileError> save_parameter_file(const std::string& path,
                                                                         const ObjectDictionary& dictionary);
/// A file that does not exist changes nothing and is no error.
[[nodiscard]] tl::expected<void, ParameterFileError> load_parameter_file(const std::string& path,
                                                                         ObjectDictionary& dictionary);

}  // namespace driveline::slaves

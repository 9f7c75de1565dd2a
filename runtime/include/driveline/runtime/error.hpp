#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <tl/expected.hpp>

#include "driveline/ecat_master/error.hpp"

namespace driveline::runtime {

/// Kind of error, for programs that react to it.
enum class ErrorKind : std::uint8_t {
  kFile,           ///< an input file is missing or wrong
  kSetting,        ///< a setting does not fit the line, or contradicts another
  kCall,           ///< the library was called in a wrong way
  kInterfaceBusy,  ///< another process uses the interface
  kLineDriven,     ///< another master controls the line
  kFolderBusy,     ///< another process writes to the folder
  kMachine,        ///< interface, thread, memory, or an output file
  kLine,           ///< the line or one of its slaves; `bus` has the facts if the error came from the master
};

/// Reason why an operation failed, with its facts. `describe()` makes the sentence.
struct Error {
  ErrorKind kind = ErrorKind::kCall;
  std::string place;           ///< the subject: "cell.toml:7: [axis 1] slave", "slave 2 (x)"; may be empty
  std::string reason;          ///< what is wrong, and what was expected
  std::filesystem::path file;  ///< kFile: the file; else empty
  std::size_t line = 0;        ///< kFile: line number in the file, from 1; 0: the error concerns the whole file
  std::optional<ecat_master::Error> bus{};  ///< kLine: the error of the master
};

/// A value or an Error.
template <typename T>
using Result = tl::expected<T, Error>;

/// Returns one sentence: the place, if there is one, and the reason.
[[nodiscard]] std::string describe(const Error& error);

/// Makes an error to return: `return fail(ErrorKind::kMachine, ...)`.
[[nodiscard]] tl::unexpected<Error> fail(ErrorKind kind, std::string reason, std::string place = {});
/// Makes an error in a file (kFile): in the whole file or in one line of it.
[[nodiscard]] tl::unexpected<Error> fail_file(const std::filesystem::path& file, std::string reason,
                                              std::size_t line = 0);
/// Makes an error of the master (kLine).
[[nodiscard]] tl::unexpected<Error> fail_line(const ecat_master::Error& error);

}  // namespace driveline::runtime

#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <tl/expected.hpp>

#include "driveline/ecat_master/error.hpp"

namespace driveline::runtime {

/// What stands in the way; a program may decide by it.
enum class ErrorKind : std::uint8_t {
  kFile,           ///< a file that was to be read: it is not there, or something in it is wrong
  kSetting,        ///< what was asked for does not fit the line, or two things do not go together
  kCall,           ///< the library was used in a way that it does not allow
  kInterfaceBusy,  ///< another process has the interface
  kLineDriven,     ///< another master drives the line
  kFolderBusy,     ///< another process writes into the folder
  kMachine,        ///< interface, thread, memory, or a file that was to be written
  kLine,           ///< the line or one of its slaves; `bus` has the facts where the master knows them
};

/// Why something could not be done, with its facts. `describe()` makes the sentence.
struct Error {
  ErrorKind kind = ErrorKind::kCall;  ///< what stands in the way
  std::string place;                  ///< what it is about: "cell.toml:7: [axis 1] slave", "slave 2 (x)"; may be empty
  std::string reason;                 ///< what is wrong, and what was expected
  std::filesystem::path file;         ///< kFile: the file; else empty
  std::size_t line = 0;               ///< kFile: line in it from 1 on; 0: it is about the file as a whole
  std::optional<ecat_master::Error> bus{};  ///< kLine: as the master has it
};

/// A value, or why there is none.
template <typename T>
using Result = tl::expected<T, Error>;

/// One sentence: the place, if there is one, and the reason.
[[nodiscard]] std::string describe(const Error& error);

/// An error in the making: `return fail(ErrorKind::kMachine, ...)`.
[[nodiscard]] tl::unexpected<Error> fail(ErrorKind kind, std::string reason, std::string place = {});
/// About a file, as a whole or one line of it.
[[nodiscard]] tl::unexpected<Error> fail_file(const std::filesystem::path& file, std::string reason,
                                              std::size_t line = 0);
/// What the master says of the line.
[[nodiscard]] tl::unexpected<Error> fail_line(const ecat_master::Error& error);

}  // namespace driveline::runtime

#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "driveline/runtime/error.hpp"

namespace driveline::cli {

/// Runs gnuplot on the file `script` inside `directory`. Error: a sentence (gnuplot is not there or failed, with what
/// it said last). Its warnings are not shown: they are about axes that did not move and the like.
[[nodiscard]] tl::expected<void, std::string> run_gnuplot(const std::filesystem::path& directory,
                                                          const std::string& script);

/// What gnuplot has drawn.
struct Drawing {
  std::map<std::string, std::filesystem::path> pictures{};  ///< that are whole, by the key they have in a report
  /// A file that could not be written to its end, which gnuplot does not tell; none: there is none.
  std::optional<runtime::Error> problem{};
};

/// Leaves `script` as the file `name` in `directory` and runs it. `pictures`: PNG files it draws there, by key. One
/// that was cut off is removed. Error: why there are none although the disk would take them, a sentence (gnuplot is not
/// there or failed).
[[nodiscard]] tl::expected<Drawing, std::string> draw(const std::filesystem::path& directory, const std::string& name,
                                                      const std::string& script,
                                                      const std::map<std::string, std::string>& pictures);

/// A name as a quoted string of a script. Names come from files and must not end the string and inject commands.
[[nodiscard]] std::string gnuplot_text(std::string_view name);

}  // namespace driveline::cli

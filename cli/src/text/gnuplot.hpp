#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "driveline/runtime/error.hpp"

namespace driveline::cli {

/// Runs gnuplot on the file `script` inside `directory`. Error: a sentence (gnuplot is missing or failed, with the last
/// line of its output). Its warnings are not shown: they concern axes that did not move and the like.
[[nodiscard]] tl::expected<void, std::string> run_gnuplot(const std::filesystem::path& directory,
                                                          const std::string& script);

/// The pictures that gnuplot has drawn.
struct Drawing {
  std::map<std::string, std::filesystem::path> pictures{};  ///< complete pictures, by their key in a report
  /// A file that could not be written completely, which gnuplot does not report; none: all files are complete.
  std::optional<runtime::Error> problem{};
};

/// Writes `script` into the file `name` in `directory` and runs it. `pictures`: PNG files that it draws there, by key;
/// a truncated one is removed. Error: a sentence, unless the disk is the reason (gnuplot is missing or failed).
[[nodiscard]] tl::expected<Drawing, std::string> draw(const std::filesystem::path& directory, const std::string& name,
                                                      const std::string& script,
                                                      const std::map<std::string, std::string>& pictures);

/// Quotes a name for a script. Names come from files and must not end the string and inject commands.
[[nodiscard]] std::string gnuplot_text(std::string_view name);

}  // namespace driveline::cli

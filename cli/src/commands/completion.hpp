#pragma once

#include <string>

namespace driveline::cli {

/// A bash script that completes the commands of the table, their options and the options' values.
[[nodiscard]] std::string bash_completion();

/// The same for zsh, with the summaries of the commands and the help of the options.
[[nodiscard]] std::string zsh_completion();

}  // namespace driveline::cli

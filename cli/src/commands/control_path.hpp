#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "failure.hpp"

namespace driveline::cli {

/// The folder of the sockets of running lines: $XDG_RUNTIME_DIR/driveline; without that variable /run/driveline for
/// root and /tmp/driveline-UID for others.
[[nodiscard]] std::filesystem::path control_folder();
/// Makes the folder, for this user alone. Failure: it cannot be made, or others could get at what is in it.
[[nodiscard]] Outcome<void> make_control_folder();
/// The socket of the line with that name.
[[nodiscard]] std::filesystem::path control_path(const std::string& line);
/// The sockets in the folder at which somebody listens.
[[nodiscard]] std::vector<std::filesystem::path> running_lines();

/// The socket of the line that is meant: `control` if it is given, that of the line described in `config` if that is
/// given, else that of the only line that runs. Failure: no line runs, or several do.
[[nodiscard]] Outcome<std::string> find_control(const std::string& control, const std::string& config);
/// For commands that can do without: the socket of a running line that is meant; empty: there is none.
[[nodiscard]] std::string running_control(const std::string& config);

}  // namespace driveline::cli

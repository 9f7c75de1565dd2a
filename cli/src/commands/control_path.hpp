#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "failure.hpp"

namespace driveline::cli {

/// The folder of the sockets of running lines: $XDG_RUNTIME_DIR/driveline; without that variable /run/driveline for
/// root and /tmp/driveline-UID for other users.
[[nodiscard]] std::filesystem::path control_folder();
/// Creates the folder, accessible to this user only. Failure: it cannot be created, or other users could access it.
[[nodiscard]] Outcome<void> make_control_folder();
/// The path of the socket of the line with that name.
[[nodiscard]] std::filesystem::path control_path(const std::string& line);
/// The sockets in the folder that have a listener, sorted.
[[nodiscard]] std::vector<std::filesystem::path> running_lines();

/// The socket of the line to talk to: `control` if given, else that of the line described in `config` if given, else
/// that of the only running line. Failure: no line runs, or several do.
[[nodiscard]] Outcome<std::string> find_control(const std::string& control, const std::string& config);
/// For commands that can work without a running line: its socket, selected as above; empty: there is none.
[[nodiscard]] std::string running_control(const std::string& config);

}  // namespace driveline::cli

#pragma once

#include <memory>

#include "driveline/runtime/line.hpp"
#include "line/slave_console.hpp"

namespace driveline::cli {

/// Commands to the slaves that a `run` simulates in its process; null: they are on an interface. `line` must outlive
/// the console.
[[nodiscard]] std::unique_ptr<SlaveConsole> make_slave_console(runtime::Line& line);

}  // namespace driveline::cli

#pragma once

#include "command.hpp"

/// The commands of the program, each in a file of its own; the table is in command_table.cpp.
namespace driveline::cli {

[[nodiscard]] Execute prepare_run(Arguments& to);
[[nodiscard]] Execute prepare_simulate(Arguments& to);
[[nodiscard]] Execute prepare_fault(Arguments& to);

[[nodiscard]] Execute prepare_slaves(Arguments& to);
[[nodiscard]] Execute prepare_states(Arguments& to);
[[nodiscard]] Execute prepare_dc(Arguments& to);
[[nodiscard]] Execute prepare_upload(Arguments& to);
[[nodiscard]] Execute prepare_download(Arguments& to);

// These work on files, not on a bus.
[[nodiscard]] Execute prepare_esi_generate(Arguments& to);
[[nodiscard]] Execute prepare_esi_validate(Arguments& to);
[[nodiscard]] Execute prepare_esi_show(Arguments& to);
[[nodiscard]] Execute prepare_completion(Arguments& to);

}  // namespace driveline::cli

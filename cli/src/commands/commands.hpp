#pragma once

#include "commands/command.hpp"

/// The commands of the program, each in a file of its own; the table is in command_table.cpp.
namespace driveline::cli {

[[nodiscard]] Execute prepare_run(Arguments& to);
[[nodiscard]] Execute prepare_axis(Arguments& to);
[[nodiscard]] Execute prepare_simulate(Arguments& to);
[[nodiscard]] Execute prepare_group(Arguments& to);
[[nodiscard]] Execute prepare_identify(Arguments& to);
[[nodiscard]] Execute prepare_plan(Arguments& to);
[[nodiscard]] Execute prepare_fault(Arguments& to);
[[nodiscard]] Execute prepare_input(Arguments& to);

// Commands for a line observed over DDS.
[[nodiscard]] Execute prepare_echo(Arguments& to);
[[nodiscard]] Execute prepare_record(Arguments& to);
[[nodiscard]] Execute prepare_plot(Arguments& to);
[[nodiscard]] Execute prepare_top(Arguments& to);

[[nodiscard]] Execute prepare_scan(Arguments& to);
[[nodiscard]] Execute prepare_graph(Arguments& to);
[[nodiscard]] Execute prepare_diag(Arguments& to);
[[nodiscard]] Execute prepare_eoe(Arguments& to);
[[nodiscard]] Execute prepare_drive(Arguments& to);
[[nodiscard]] Execute prepare_slaves(Arguments& to);
[[nodiscard]] Execute prepare_states(Arguments& to);
[[nodiscard]] Execute prepare_dc(Arguments& to);
[[nodiscard]] Execute prepare_rescan(Arguments& to);
[[nodiscard]] Execute prepare_pdos(Arguments& to);
[[nodiscard]] Execute prepare_cstruct(Arguments& to);
[[nodiscard]] Execute prepare_sdos(Arguments& to);
[[nodiscard]] Execute prepare_upload(Arguments& to);
[[nodiscard]] Execute prepare_download(Arguments& to);
[[nodiscard]] Execute prepare_foe_read(Arguments& to);
[[nodiscard]] Execute prepare_foe_write(Arguments& to);
[[nodiscard]] Execute prepare_soe_read(Arguments& to);
[[nodiscard]] Execute prepare_soe_write(Arguments& to);
[[nodiscard]] Execute prepare_soe_list(Arguments& to);
[[nodiscard]] Execute prepare_soe_import(Arguments& to);
[[nodiscard]] Execute prepare_reg_read(Arguments& to);
[[nodiscard]] Execute prepare_reg_write(Arguments& to);
[[nodiscard]] Execute prepare_reg_list(Arguments& to);
[[nodiscard]] Execute prepare_sii_read(Arguments& to);
[[nodiscard]] Execute prepare_sii_write(Arguments& to);
[[nodiscard]] Execute prepare_sii_compare(Arguments& to);
[[nodiscard]] Execute prepare_sii_alias(Arguments& to);

// Commands for CAN buses.
[[nodiscard]] Execute prepare_can_dump(Arguments& to);
[[nodiscard]] Execute prepare_can_send(Arguments& to);
[[nodiscard]] Execute prepare_can_stat(Arguments& to);
[[nodiscard]] Execute prepare_nmt(Arguments& to);
[[nodiscard]] Execute prepare_emcy(Arguments& to);

// Commands that work on files or the machine, not on a bus.
[[nodiscard]] Execute prepare_esi_generate(Arguments& to);
[[nodiscard]] Execute prepare_esi_validate(Arguments& to);
[[nodiscard]] Execute prepare_esi_show(Arguments& to);
[[nodiscard]] Execute prepare_doctor(Arguments& to);
[[nodiscard]] Execute prepare_bench(Arguments& to);
[[nodiscard]] Execute prepare_completion(Arguments& to);
[[nodiscard]] Execute prepare_manual(Arguments& to);

}  // namespace driveline::cli

#include <array>

#include "commands.hpp"

namespace driveline::cli {
namespace {

constexpr std::string_view kLine = "Lines";
constexpr std::string_view kTools = "Bus tools";
constexpr std::string_view kFiles = "Files and the shell";

constexpr std::array kCommands = {
    Command{"run", "", kLine, "Take the line to OP and its axes along their path",
            "run --config examples/line8.toml --duration 5\n"
            "run --config examples/line8.toml --duration 5 --virtual --json",
            prepare_run},
    Command{"simulate", "", kLine, "Serve the simulated line on a network interface to any master",
            "simulate --config examples/line8-nic.toml --iface dl-line\n"
            "simulate --config examples/line8-nic.toml --iface dl-line --control line.socket",
            prepare_simulate},
    Command{"fault", "", kLine, "Begin, end or list faults of the line that `simulate` serves",
            "fault help\n"
            "fault --control line.socket cable-break slave=x to=y for_ms=500\n"
            "fault --control line.socket drop way=back chance=0.01 seed=7\n"
            "fault --control line.socket heal all",
            prepare_fault},
    Command{"slaves", "", kTools, "List the slaves on the line",
            "slaves --config examples/line8.toml\n"
            "slaves --iface eth1 --json",
            prepare_slaves},
    Command{"states", "", kTools, "Show the EtherCAT states, or change them",
            "states --iface eth1\n"
            "states --config examples/line8.toml SAFEOP",
            prepare_states},
    Command{"dc", "", kTools, "Bring the clocks together, watch them, and show how far apart they are",
            "dc --config examples/line8-dc.toml\n"
            "dc --config examples/line8-dc.toml --virtual --output out\n"
            "dc --iface eth1 --duration 10 --json",
            prepare_dc},
    Command{"upload", "", kTools, "Read an object over CoE",
            "upload --config examples/line8.toml -p 0 -t int32 0x6064 0\n"
            "upload --config examples/line8.toml -p 2 -t string 0x1008 0",
            prepare_upload},
    Command{"download", "", kTools, "Write an object over CoE",
            "download --config examples/line8.toml -p 1 -t int8 0x6060 0 8", prepare_download},
    Command{"esi", "", kFiles, "Device description files (ESI) and EEPROM images (SII)", "", nullptr},
    Command{"esi generate", "", "", "Write ESI file and SII image of the simulated MSD", "esi generate out",
            prepare_esi_generate},
    Command{"esi validate", "", "", "Check an ESI file and tell what was passed over",
            "esi validate esi/data/moog_msd.xml", prepare_esi_validate},
    Command{"esi show", "", "", "List the devices of an ESI file", "esi show esi/data/moog_msd.xml", prepare_esi_show},
    Command{"completion", "", kFiles, "Print a script that lets the shell complete commands and options",
            "completion bash > ~/.local/share/bash-completion/completions/driveline", prepare_completion},
};

}  // namespace

std::span<const Command> commands() {
  return kCommands;
}

}  // namespace driveline::cli

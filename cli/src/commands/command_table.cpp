#include <array>

#include "commands/commands.hpp"

namespace driveline::cli {
namespace {

constexpr std::string_view kLine = "Lines";
constexpr std::string_view kDds = "Telemetry, from any machine";
constexpr std::string_view kTools = "Bus tools";
constexpr std::string_view kFiles = "Files and the shell";
constexpr std::string_view kMeasuring = "Measuring";

constexpr std::array kCommands = {
    Command{"run", "", kLine, "Take the line to OP and move its axes along their path",
            "run --config examples/line8.toml --duration 5\n"
            "run --config examples/line8.toml --duration 5 --virtual --json\n"
            "run --config examples/by_hand.toml --script examples/moves.txt --virtual",
            prepare_run},
    Command{"axis", "", kLine, "Move an axis of a running line by hand: enable, home, move, jog, stop, status",
            "axis all status\n"
            "axis x move 90deg --velocity 30deg/s\n"
            "axis x move --by 10mm\n"
            "axis x jog -20rpm --for 2s\n"
            "axis x stop",
            prepare_axis},
    Command{"group", "", kLine, "Move a group of axes of a running line along lines, arcs and paths",
            "group plotter status\n"
            "group plotter enable\n"
            "group plotter move 90mm 20mm --feed 100mm/s\n"
            "group plotter path contour.jsonl\n"
            "group plotter hold",
            prepare_group},
    Command{"identify", "", kLine,
            "Move one axis back and forth, and identify inertia, friction and weight of its load",
            "identify --config examples/line8.toml --virtual z --distance 20\n"
            "identify --config examples/vertical.toml --virtual z --distance 12 --json",
            prepare_identify},
    Command{"plan", "", kLine, "Show the motion of a file of moves without moving anything: duration, limits, picture",
            "plan examples/contour.jsonl\n"
            "plan examples/contour.jsonl --override 50 --picture contour.svg --json\n"
            "plan examples/delta.jsonl --picture delta.svg",
            prepare_plan},
    Command{"simulate", "", kLine, "Serve the simulated line on a network interface to any master",
            "simulate --config examples/line8-nic.toml --iface dl-line\n"
            "simulate --config examples/line8-nic.toml --iface dl-line --control line.socket\n"
            "simulate --config examples/can8.toml --slcan 127.0.0.1:29550 --socketcand 127.0.0.1:29536",
            prepare_simulate},
    Command{"fault", "", kLine, "Start, end or list faults of the line that `simulate` or `run` simulates",
            "fault help\n"
            "fault personas\n"
            "fault power-off slave=x for_ms=500\n"
            "fault --control line.socket cable-break slave=x to=y for_ms=500\n"
            "fault --control line.socket drop way=back chance=0.01 seed=7\n"
            "fault --control line.socket heal all",
            prepare_fault},
    Command{"input", "", kLine, "Set inputs, read inputs and outputs of a slave that `simulate` or `run` simulates",
            "input x ENPO=0\n"
            "input --control line.socket x\n"
            "input --control line.socket x ENPO=0\n"
            "input --control line.socket analogue \"Channel 1/Value=500\"",
            prepare_input},
    Command{"echo", "", kDds, "Print what a line publishes, sample by sample",
            "echo line_status\n"
            "echo driveline/v1/event --json --timeout 2\n"
            "echo axis_telemetry --count 1 --domain 3 --interface all",
            prepare_echo},
    Command{"record", "", kDds, "Record what a line publishes, for PlotJuggler, Foxglove, tables and programs",
            "record --output run.mcap\n"
            "record --output run.mcap --duration 60 --topic axis_batch --topic event\n"
            "record --output axes.csv --topic axis_telemetry --force",
            prepare_record},
    Command{"plot", "", kDds, "Draw positions, following errors and events of a recording",
            "plot run.mcap\n"
            "plot run.mcap --axis x --axis y --output xy.svg",
            prepare_plot},
    Command{"top", "", kDds, "Show a line as a page that refreshes: state, cycle, axes, events",
            "top\n"
            "top --once\n"
            "top --domain 3 --interface all --period 0.2",
            prepare_top},
    Command{"scan", "", kTools, "Show the slaves on the line, and write a line description for them",
            "scan --config examples/line8.toml\n"
            "scan --iface eth1 --write line.toml\n"
            "scan --config examples/mixed.toml --write found.toml --move 0.5\n"
            "scan --config examples/can8.toml --iface slcan:tcp:127.0.0.1:29550",
            prepare_scan},
    Command{"slaves", "", kTools, "List the slaves on the line",
            "slaves --config examples/line8.toml\n"
            "slaves --config examples/line8.toml -p 0 -v\n"
            "slaves --iface eth1 --json\n"
            "slaves --config examples/can8.toml -n 3",
            prepare_slaves},
    Command{"states", "", kTools, "Show the states, or change those of EtherCAT",
            "states --iface eth1\n"
            "states --config examples/line8.toml SAFEOP\n"
            "states --config examples/can8.toml",
            prepare_states},
    Command{"dc", "", kTools, "Synchronize the clocks, observe them, and show their differences",
            "dc --config examples/line8-dc.toml\n"
            "dc --config examples/line8-dc.toml --virtual --output out\n"
            "dc --iface eth1 --duration 10 --json",
            prepare_dc},
    Command{"graph", "", kTools, "Draw the connections between the slaves, for Graphviz or as a tree",
            "graph --config examples/line8.toml\n"
            "graph --config examples/line8.toml --tree",
            prepare_graph},
    Command{"diag", "crc", kTools, "Diagnose the line: states, links, error counters, location of faults",
            "diag --config examples/line8.toml\n"
            "diag --config examples/line8.toml --json",
            prepare_diag},
    Command{"drive", "", kTools, "Show one drive: display, state, values, inputs, faults, parameters",
            "drive --config examples/line8.toml -p 0 --once\n"
            "drive --iface eth1 -p 2\n"
            "drive --iface eth1 -p 2 --json",
            prepare_drive},
    Command{"rescan", "", kTools, "Search the slaves again and take all to INIT", "rescan --config examples/line8.toml",
            prepare_rescan},
    Command{"pdos", "", kTools, "List the PDOs, with the objects mapped into them",
            "pdos --config examples/line8.toml -p 0\n"
            "pdos --config examples/line8.toml -p 0 --sii\n"
            "pdos --config examples/process_data.toml --image\n"
            "pdos --config examples/can8.toml -n 1",
            prepare_pdos},
    Command{"cstruct", "", kTools, "Print C++ declarations of the PDOs for programs that use the library",
            "cstruct --config examples/line8.toml -p 0", prepare_cstruct},
    Command{"sdos", "", kTools, "List the objects of the slaves with type and access",
            "sdos --config examples/line8.toml -p 0 0x6041\n"
            "sdos --config examples/line8.toml -p 0 -q\n"
            "sdos --config examples/can8.toml -n 1 0x1018",
            prepare_sdos},
    Command{"upload", "", kTools, "Read an object by SDO",
            "upload --config examples/line8.toml -p 0 -t int32 0x6064 0\n"
            "upload --config examples/line8.toml -p 2 -t string 0x1008 0\n"
            "upload --config examples/can8.toml -n 3 0x6041 0",
            prepare_upload},
    Command{"download", "", kTools, "Write an object by SDO",
            "download --config examples/line8.toml -p 1 -t int8 0x6060 0 8\n"
            "download --config examples/can8.toml -n 3 -t int8 0x6060 0 1",
            prepare_download},
    Command{"can", "", kTools, "Frames of a CAN bus", "", nullptr},
    Command{"can dump", "", "", "Show the frames of a CAN bus with what they mean",
            "can dump --iface slcan:tcp:127.0.0.1:29550\n"
            "can dump --iface can0 --count 100 --log bus.log --pcap bus.pcapng\n"
            "can dump --config examples/can8.toml --duration 100ms",
            prepare_can_dump},
    Command{"can send", "", "", "Send frames to a CAN bus",
            "can send --config examples/can8.toml 601#4000100000000000 --wait 10ms\n"
            "can send --iface can0 000#0103 703#R1",
            prepare_can_send},
    Command{"can stat", "", "", "Count the frames of a CAN bus: load to the bit, identifiers, state of the adapter",
            "can stat --iface socketcand:127.0.0.1:29536/can0 --duration 10\n"
            "can stat --config examples/can8.toml --duration 100ms --json",
            prepare_can_stat},
    Command{"nmt", "", kTools, "Start, stop or reset nodes of a CAN bus",
            "nmt --iface slcan:tcp:127.0.0.1:29550 3 start\n"
            "nmt --config examples/can8.toml all reset-comm",
            prepare_nmt},
    Command{"emcy", "", kTools, "Show the errors that nodes of a CAN bus remember, and their emergencies as they come",
            "emcy --iface can0 -n 3\n"
            "emcy --config examples/can8.toml --duration 0 --json",
            prepare_emcy},
    Command{"foe", "", kTools, "Files of a slave (file access over EtherCAT)", "", nullptr},
    Command{"foe read", "foe_read", "", "Read a file of a slave",
            "foe read --config examples/line8.toml -p 0 parameters.txt -o parameters.txt", prepare_foe_read},
    Command{"foe write", "foe_write", "", "Write a file to a slave",
            "foe write --iface eth1 -p 0 parameters.txt\n"
            "foe write --iface eth1 -p 0 --boot moog_msd.efw",
            prepare_foe_write},
    Command{"soe", "", kTools, "Operation data of drives (servo profile over EtherCAT)", "", nullptr},
    Command{"soe read", "soe_read", "", "Read an operation datum: value, name, unit, limits, attribute",
            "soe read --config examples/soe.toml -p 0 S-0-0100\n"
            "soe read --iface eth1 -p 2 --drive 1 P-0-0017 --json",
            prepare_soe_read},
    Command{"soe write", "soe_write", "", "Write the value of an operation datum, or execute a procedure command",
            "soe write --config examples/soe.toml -p 0 S-0-0100 150\n"
            "soe write --config examples/soe.toml -p 0 S-0-0099 --execute",
            prepare_soe_write},
    Command{"soe list", "", "", "List the operation data of a drive", "soe list --config examples/soe.toml -p 0",
            prepare_soe_list},
    Command{"soe import", "", "", "Make [[slave.idn]] tables of a TwinCAT start-up list",
            "soe import examples/soe_startup.xml --drive 0", prepare_soe_import},
    Command{"eoe", "", kTools, "Show the ports, addresses and counters of EoE (Ethernet over EtherCAT)",
            "eoe --control run.socket\n"
            "eoe --config examples/line8.toml\n"
            "eoe --iface eth1 -p 2 --json",
            prepare_eoe},
    Command{"reg", "", kTools, "Registers of the slave controllers", "", nullptr},
    Command{"reg read", "reg_read", "", "Read a register of one or several slaves",
            "reg read --config examples/line8.toml -p 0 al_status\n"
            "reg read --config examples/line8.toml -p 0-3 0x0130 -t uint16\n"
            "reg read --config examples/line8.toml -p 1 0x0000 10",
            prepare_reg_read},
    Command{"reg write", "reg_write", "", "Write a register of one slave",
            "reg write --config examples/line8.toml -p 0 watchdog_divider 2498", prepare_reg_write},
    Command{"reg list", "", "", "List the named registers", "reg list", prepare_reg_list},
    Command{"sii", "", kTools, "EEPROM of a slave (slave information interface)", "", nullptr},
    Command{"sii read", "sii_read", "", "Read the EEPROM as an image, or print its content",
            "sii read --config examples/line8.toml -p 0 -v\n"
            "sii read --config examples/line8.toml -p 0 -o drive.sii",
            prepare_sii_read},
    Command{"sii write", "sii_write", "", "Write an image into the EEPROM; every word is read back",
            "sii write --iface eth1 -p 0 drive.sii", prepare_sii_write},
    Command{"sii compare", "", "", "Compare the EEPROM with an ESI file",
            "sii compare --config examples/line8.toml -p 0 esi/data/moog_msd.xml", prepare_sii_compare},
    Command{"sii alias", "alias", "", "Write the alias address into the EEPROM",
            "sii alias --config examples/line8.toml -p 2 4711", prepare_sii_alias},
    Command{"esi", "", kFiles, "Device description files (ESI) and EEPROM images (SII)", "", nullptr},
    Command{"esi generate", "", "", "Write ESI files, SII images, EDS and object pages of the simulated drives",
            "esi generate out", prepare_esi_generate},
    Command{"esi validate", "", "", "Check an ESI file, EDS or DCF, and list what the reader ignores",
            "esi validate esi/data/moog_msd.xml", prepare_esi_validate},
    Command{"esi show", "", "", "List the devices of an ESI file, or the content of an EDS or DCF",
            "esi show esi/data/moog_msd.xml", prepare_esi_show},
    Command{"doctor", "", kMeasuring, "Check whether this machine can run a punctual cycle, and print remedies",
            "doctor --iface eth1 --cpu 1\n"
            "doctor --config examples/line8-nic.toml --iface eth1 --json",
            prepare_doctor},
    Command{"bench", "", kMeasuring, "Run the benchmarks and combine their figures into a report with pictures",
            "bench --list\n"
            "bench wake --quick --output out",
            prepare_bench},
    Command{"completion", "", kFiles, "Print a shell script for completion of commands and options",
            "completion bash > ~/.local/share/bash-completion/completions/driveline", prepare_completion},
    Command{"manual", "", kFiles, "Print the manual page of the program or of a command",
            "manual\n"
            "manual esi show",
            prepare_manual},
};

}  // namespace

std::span<const Command> commands() {
  return kCommands;
}

}  // namespace driveline::cli

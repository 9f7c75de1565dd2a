// Rows of the terminals: function selectors, images, outputs set by the bus, motor brake.
#include <vector>

#include "table_row.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::string_view kSelector = "MSD manual 12.2.4; terminal SERCOS manual Table 10.1; defaults ours";
constexpr std::string_view kFreeSelector =
    "MSD manual 12.2.4; belongs to no terminal that a manual names: stored, without effect; name ours";
constexpr std::size_t kTerminals = 11;  ///< terminals in 2079h
constexpr std::array<std::string_view, 13> kInputNames = {
    "MPRO_INPUT_FS_ENPO",         "MPRO_INPUT_FS_ISD00", "MPRO_INPUT_FS_ISD01", "MPRO_INPUT_FS_ISD02",
    "MPRO_INPUT_FS_ISD03",        "MPRO_INPUT_FS_ISD04", "MPRO_INPUT_FS_ISD05", "MPRO_INPUT_FS_ISD06",
    "MPRO_INPUT_FS_ISDSH",        "MPRO_INPUT_FS_ISA00", "MPRO_INPUT_FS_ISA01", "Input function selector 111",
    "Input function selector 112"};
constexpr std::array<std::string_view, 5> kOutputNames = {"MPRO_OUTPUT_FS_OSD00", "MPRO_OUTPUT_FS_OSD01",
                                                          "MPRO_OUTPUT_FS_OSD02", "MPRO_OUTPUT_FS_MOTO",
                                                          "MPRO_OUTPUT_FS_RELOUT1"};
constexpr double kBrakeFunction = 1;  ///< brake function of P 125

constexpr std::array kTerminalRows = {
    variable(p(120), kStored, kValue.input_inversion, "Input inversion", {0, 0, 0x1007E}, {},
             "SERCOS manual Table 10.1 (the sibling drive); bits as in P 121; ENPO and ISDSH never: ours"),
    variable(p(143), kTx, kValue.output_state, "MPRO_OUTPUT_STATE", {}, {}, "MSD manual Table 10.7"),
    variable(p(213), kStored, kValue.brake_lift_time, "Motor brake lift time", {0, 0, 10000}, "ms",
             "SERCOS manual Table 10.1; default ours"),
    variable(p(214), kStored, kValue.brake_close_time, "Motor brake close time", {0, 0, 10000}, "ms",
             "SERCOS manual Table 10.1; default ours"),
    array_length(0x60FE, "Digital outputs", 2, "MSD manual 10.4.5; structure CiA 402"),
    element(0x60FE, 1, kRx, kValue.physical_outputs, "Physical outputs", {}, {}, "MSD manual Table 10.9"),
    element(0x60FE, 2, kRxStored, kValue.output_mask, "Bit mask", {0x00C70000}, {},
            "CiA 402; default ours: every output of Table 10.9"),
};

std::vector<EntryRow> make_terminal_rows() {
  std::vector<EntryRow> rows(kTerminalRows.begin(), kTerminalRows.end());
  for (std::size_t i = 0; i < kInputNames.size(); ++i) {
    rows.push_back(variable(p(static_cast<std::uint16_t>(100 + i)), kStored, kValue.input_functions[i], kInputNames[i],
                            {0, 0, 15}, {}, i < kTerminals ? kSelector : kFreeSelector));
  }
  for (std::size_t i = 0; i < kOutputNames.size(); ++i) {
    const bool brake = i == 3;
    rows.push_back(variable(p(static_cast<std::uint16_t>(122 + i)), kStored, kValue.output_functions[i],
                            kOutputNames[i], {brake ? kBrakeFunction : 0.0, 0, 40}, {},
                            brake ? "SERCOS manual Table 10.1: motor brake; number of the function ours"
                                  : "MSD manual Table 10.8; default ours"));
  }
  return rows;
}

}  // namespace

std::span<const EntryRow> terminal_rows() {
  static const std::vector<EntryRow> kRows = make_terminal_rows();
  return kRows;
}

}  // namespace driveline::slaves::msd

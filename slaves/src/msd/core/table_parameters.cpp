// Rows of the manufacturer's parameters that every mode uses.
#include <array>

#include "table_row.hpp"

namespace driveline::slaves::msd {
namespace {

using enum esi::DataType;
using esi::ObjectCode;

constexpr std::array kParameterRows = {
    text(p(3), kStored, "DV_DeviceAliasName", "X-Axis", 100, "MSD manual 8.2.4"),
    constant(p(11), 0, ObjectCode::kArray, kUnsigned8, "PARA_SetCmd", 4,
             "MSD manual 7.5.3; element 0 is not described"),
    element(p(11), 1, access::kReadWrite, kValue.save_parameters, "Save parameters", {0, kNoMinimum, 1}, {},
            "MSD manual 7.5.3"),
    element(p(11), 3, access::kReadWrite, kValue.factory_reset, "Reset to factory setting", {0, kNoMinimum, 1}, {},
            "MSD manual 7.5.4"),
    power_off(element(p(11), 4, access::kReadWrite, kValue.parameter_download, "Download without logic check",
                      {0, kNoMinimum, 1}, {}, "MSD manual 8.2.5")),
    variable(p(121), kTx, kValue.input_state, "MPRO_INPUT_STATE", {}, {}, "MSD manual Table 10.6"),
    variable(p(153), access::kReadWrite, kValue.fault_reset_parameter, "MPRO_DRVCOM_FaultReset", {0, kNoMinimum, 1}, {},
             "MSD manual 13.2"),
    variable(p(154), kStored, kValue.external_reaction_time, "MPRO_DRVCOM_ROT0_Time", {1000, kNoMinimum, 600000}, "ms",
             "MSD manual Table 10.3; unit and range ours"),
    variable(p(159), kStored, kValue.control_location, "MPRO_CTRL_SEL", {5, kNoMinimum, 10}, {},
             "MSD manual Table 11.1: CiA402 = 5; default ours"),
    variable(p(165), kStored, kValue.reference_source, "MPRO_REF_SEL", {7, kNoMinimum, 10}, {},
             "MSD manual Table 11.1, Device Help 8: CiA402 = 7; default ours"),
    variable(p(306), kStored, kValue.reference_cycle, "CON_IpRefTs", {1.0, 0.125, 1000.0}, "ms",
             "MSD manual 7.4.2, 11.2; default and range ours"),
    variable(p(320), kStored, kValue.velocity_gain, "CON_SCON_Kp", {0, 0.0, 1e6}, "Nm/rpm", "Device Help 7"),
    variable(p(321), kStored, kValue.velocity_reset, "CON_SCON_Tn", {0, 0.0, 1e6}, "ms",
             "Device Help 7; 0 = no integral part (ours)"),
    variable(p(322), kStored, kValue.velocity_gain_scale, "CON_SCON_KpScale", {100.0, 0.0, 1000.0}, "%",
             "Device Help 7"),
    variable(p(351), kStored, kValue.velocity_filter, "CON_SCALC_TF", {0, 0.0, 1000.0}, "ms", "Device Help 7"),
    variable(p(360), kStored, kValue.position_gain, "CON_PCON_Kp", {0, 0.0, 1e6}, "1/min", "Device Help 7"),
    variable(p(370), kStored, kValue.interpolation_type, "CON_IP", {1, kNoMinimum, 5}, {},
             "MSD manual Table 12.16; default CiA 402"),
    variable(p(375), kStored, kValue.speed_feed_forward_scale, "CON_IP_SFFScale", {100.0, 0.0, 100.0}, "%",
             "MSD manual Table 12.26"),
    variable(p(376), kStored, kValue.torque_feed_forward_scale, "CON_IP_TFFScale", {100.0, 0.0, 100.0}, "%",
             "MSD manual Table 12.26; default ours"),
    element(p(379), 0, kStored, kValue.position_format, "CON_IP_FFMode", {0, kNoMinimum, 0}, {},
            "MSD manual Table 12.26: 32-bit position setpoints only"),
    element(p(379), 1, kStored, kValue.speed_feed_forward_source, "Speed feed-forward external", {0, kNoMinimum, 1}, {},
            "MSD manual Table 12.26"),
    element(p(379), 2, kStored, kValue.torque_feed_forward_source, "Torque feed-forward external", {0, kNoMinimum, 1},
            {}, "MSD manual Table 12.26"),
    variable(p(745), kStored, kValue.standstill_window, "MON_REFWINDOW", {10.0, 0.0, 10000.0}, "rpm",
             "MSD manual Table 12.20; unit and default ours"),
    variable(p(1516), kStored, kValue.total_inertia, "SCD_Jsum", {0, 0.0, 1e6}, "kg m2",
             "Device Help 7: not 0 switches the torque pre-control on"),
    constant(p(2011), 0, ObjectCode::kVariable, kUnsigned32, "COM_301_DeviceType", 0x00020192,
             "MSD manual 8.2.3: alias of 1000h"),
    variable(p(2055), kRx, kValue.dummy_byte, "COM_301_U8", {}, {}, "MSD manual 8.3.3: filler of PDOs"),
    variable(p(2060), access::kRead, kValue.nmt_state, "COM_CAN_NMT_State", {}, {}, "MSD manual Table 7.4"),
    variable(p(2208), access::kReadWrite, kValue.control_word, "MPRO_402_Controlword", {}, {},
             "MSD manual 11.3.1: alias of 6040h"),
    variable(p(2209), access::kRead, kValue.status_word, "MPRO_402_Statusword", {}, {},
             "MSD manual 11.3.2: alias of 6041h"),
    element(p(2266), 0, kStored, kValue.interpolation_period_value, "MPRO_402_IntTimePeriod", {1, 1}, {},
            "MSD manual Table 7.3: alias of 60C2h sub 1"),
    element(p(2266), 1, kStored, kValue.interpolation_period_index, "Interpolation time index", {-3, -6, 0}, {},
            "MSD manual Table 7.3: alias of 60C2h sub 2"),
};

}  // namespace

std::span<const EntryRow> parameter_rows() {
  return kParameterRows;
}

}  // namespace driveline::slaves::msd

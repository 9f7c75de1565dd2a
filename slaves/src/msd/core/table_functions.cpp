// Rows of touch probe, U/f characteristic, warnings, protection of the motor.
#include <vector>

#include "table_row.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::string_view kProbe = "MSD manual Tables 14.1, 14.4";
constexpr std::string_view kMotorProtection = "Device Help: motor protection; default ours";
constexpr std::string_view kActualValue = "SERCOS manual Table 10.1";
constexpr std::string_view kMotorData =
    "SERCOS manual Table 10.1; default the motor's; 6075h and 6076h follow, range ours";
constexpr std::string_view kCharacteristic =
    "SERCOS manual Table 10.1 (the sibling drive); rms between phases as P 312, default from the motor data: ours";
constexpr std::uint8_t kMessages = 9;  ///< P 33[0-8]

/// Returns an element of a P-parameter array whose data start at sub-index 0.
template <typename T>
constexpr EntryRow parameter(std::uint16_t number, std::uint8_t subindex, std::uint16_t access, Slot<T> value,
                             std::string_view name, RowRange range, std::string_view unit, std::string_view source) {
  return element(p(number), subindex, access, value, name, range, unit, source);
}

/// Returns a row of the motor data.
template <typename T>
constexpr EntryRow motor_data(std::uint16_t number, Slot<T> value, std::string_view name, RowRange range,
                              std::string_view unit, std::string_view source) {
  return power_off(variable(p(number), kStored, value, name, range, unit, source));
}

constexpr std::array kFunctionRows = {
    variable(p(34), kTx, kValue.warnings, "MON_WarningState", {}, {},
             "MSD manual 11.3.2; bits SERCOS manual S-0-0012, name ours"),
    variable(0x60B8, kRx, kValue.touch_probe_function, "Touch probe function", {}, {}, kProbe),
    variable(0x60B9, kTx, kValue.touch_probe_status, "Touch probe status", {}, {}, kProbe),
    variable(0x60BA, kTx, kValue.touch_probe_values[0], "Touch probe pos1 pos value", {}, "pos", kProbe),
    variable(0x60BB, kTx, kValue.touch_probe_values[1], "Touch probe pos1 neg value", {}, "pos", kProbe),
    variable(0x60BC, kTx, kValue.touch_probe_values[2], "Touch probe pos2 pos value", {}, "pos", kProbe),
    variable(0x60BD, kTx, kValue.touch_probe_values[3], "Touch probe pos2 neg value", {}, "pos", kProbe),
    variable(p(2285), kStored, kValue.touch_probe_variant, "Touch probe function selector", {1, 0, 3}, {},
             "MSD manual 14.1: 1 CiA402, 2 BECK2, 3 SPECIFIC; 0 off and default ours"),
    variable(p(313), kStored, kValue.boost_voltage, "VF control, boost voltage at zero frequency", {0, 0, 1000}, "V",
             kCharacteristic),
    variable(p(314), kStored, kValue.nominal_frequency, "VF control, nominal frequency", {400, 0.1, 10000}, "Hz",
             kCharacteristic),
    variable(p(315), kStored, kValue.nominal_voltage, "VF control, voltage at nominal frequency", {0, 0, 1000}, "V",
             kCharacteristic),
    variable(p(410), kTx, kValue.dc_link_volts, "DC link voltage", {}, "V", "SERCOS manual Table 10.1"),
    variable(p(412), kTx, kValue.actual_increments, "Actual position", {}, "inc", kActualValue),
    variable(p(413), kTx, kValue.reference_increments, "Reference position", {}, "inc", kActualValue),
    variable(p(414), kTx, kValue.increment_difference, "Actual position difference", {}, "inc", kActualValue),
    variable(p(415), kTx, kValue.actual_rpm, "Actual speed", {}, "rpm", kActualValue),
    variable(p(416), kTx, kValue.reference_rpm, "Reference speed", {}, "rpm", kActualValue),
    variable(p(418), kTx, kValue.reference_torque_nm, "Reference torque", {}, "Nm", kActualValue),
    variable(p(419), kTx, kValue.actual_torque_nm, "Actual torque", {}, "Nm", kActualValue),
    motor_data(45, kValue.motor_type, "MOT_Type", {1, 1, 1}, {},
               "MSD manual 8.2.2: PSM = 1, what the plant is, and no other"),
    motor_data(455, kValue.motor_rated_frequency, "MOT_FNOM", {200, 0.1, 10000}, "Hz",
               "MSD manual 8.2.3: read or write; default the motor's, range ours"),
    motor_data(457, kValue.motor_rated_current_a, "Motor rated current", {2.5, 0.01, 10000}, "A", kMotorData),
    motor_data(460, kValue.motor_rated_torque_nm, "Motor rated torque", {2.4F, 0.001, 100000}, "Nm", kMotorData),
    variable(p(461), access::kRead, kValue.motor_inertia, "Motor inertia", {}, "kg m2", kActualValue),
    variable(p(463), access::kRead, kValue.motor_pole_pairs, "Motor number of pole pairs", {}, {}, kActualValue),
    parameter(701, 0, kTx, kValue.overload_integrator, "MON_ActValues: I2t integrator", {}, "%",
              "Device Help: P 701[0]"),
    parameter(701, 1, kTx, kValue.motor_temperature, "Motor temperature", {}, "degC", "index ours"),
    parameter(701, 12, kStored, kValue.undervoltage_limit, "u_zkoff: undervoltage limit", {250, 0, 2000}, "V",
              "Device Help: P 701[12]; default ours"),
    parameter(731, 0, kStored, kValue.motor_temperature_max, "MON_MotorTemp_Max", {100, 0, 300}, "degC",
              "Device Help: P 731, default 100 degC"),
    parameter(732, 0, kStored, kValue.motor_temperature_sensor, "MON_MotorPTC", {1, 0, 8}, {},
              "Device Help: 0 off, 1 KTY, 2 PTC, 3 TSS, 4 PTC1, 6-8 NTC; default ours"),
    parameter(733, 0, kStored, kValue.overload_rated, "MON_MotorI2t: Inom", {100, 1, 1000}, "%", kMotorProtection),
    parameter(733, 1, kStored, kValue.overload_standstill, "I0", {100, 1, 1000}, "%", kMotorProtection),
    parameter(733, 2, kStored, kValue.overload_middle, "I1", {100, 1, 1000}, "%", kMotorProtection),
    parameter(733, 3, kStored, kValue.overload_middle_frequency, "F1", {25, 0, 10000}, "Hz", kMotorProtection),
    parameter(733, 4, kStored, kValue.overload_rated_frequency, "FN", {200, 0, 10000}, "Hz", kMotorProtection),
    parameter(733, 7, kStored, kValue.overload_time_constant, "Tth", {60, 0.1, 100000}, "s", kMotorProtection),
    parameter(735, 0, kStored, kValue.overload_type, "MON_MotorI2tType", {1, 0, 1}, {},
              "Device Help: 0 FREQ, 1 THERM; default ours"),
};

std::vector<EntryRow> make_function_rows() {
  std::vector<EntryRow> rows(kFunctionRows.begin(), kFunctionRows.end());
  for (std::uint8_t i = 0; i < kMessages; ++i) {
    EntryRow row = text(p(33), access::kRead, i == 0 ? "Actual fault" : "Actual warning", {}, 48,
                        "MSD manual 11.3.2: P 33[0-8] fault and warning texts; order ours");
    row.subindex = i;
    row.code = esi::ObjectCode::kArray;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

std::span<const EntryRow> function_rows() {
  static const std::vector<EntryRow> kRows = make_function_rows();
  return kRows;
}

}  // namespace driveline::slaves::msd

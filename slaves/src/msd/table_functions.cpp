// Rows of touch probe, U/f characteristic, warnings, protection of the motor.
#include <vector>

#include "table_row.hpp"

namespace driveline::slaves::msd {
namespace {

using enum esi::DataType;

constexpr std::string_view kProbe = "MSD manual Tables 14.1, 14.4";
constexpr std::string_view kMotorProtection = "Device Help: motor protection; default ours";
constexpr std::string_view kActualValue = "SERCOS manual Table 10.1";
constexpr std::string_view kMotorData =
    "SERCOS manual Table 10.1; default the motor's; 6075h and 6076h follow, range ours";
constexpr std::string_view kCharacteristic =
    "SERCOS manual Table 10.1 (the sibling drive); rms between phases as P 312, default from the motor data: ours";
constexpr std::uint8_t kMessages = 9;  ///< P 33[0-8]

/// Element of a P-parameter array that starts with data at 0.
constexpr EntryRow parameter(std::uint16_t number, std::uint8_t subindex, esi::DataType type, std::uint16_t access,
                             std::uint16_t slot, std::string_view name, RowRange range, std::string_view unit,
                             std::string_view source) {
  return element(p(number), subindex, type, access, slot, name, range, unit, source);
}

/// What the drive is told about its motor.
constexpr EntryRow motor_data(std::uint16_t number, esi::DataType type, std::uint16_t slot, std::string_view name,
                              RowRange range, std::string_view unit, std::string_view source) {
  EntryRow row = variable(p(number), type, kStored, slot, name, range, unit, source);
  row.power_off_only = true;
  return row;
}

constexpr std::array kFunctionRows = {
    variable(p(34), kUnsigned32, kTx, kWarnings, "MON_WarningState", {}, {},
             "MSD manual 11.3.2; bits SERCOS manual S-0-0012, name ours"),
    variable(0x60B8, kUnsigned16, kRx, kTouchProbeFunction, "Touch probe function", {}, {}, kProbe),
    variable(0x60B9, kUnsigned16, kTx, kTouchProbeStatus, "Touch probe status", {}, {}, kProbe),
    variable(0x60BA, kInteger32, kTx, kTouchProbeValueFirst + 0, "Touch probe pos1 pos value", {}, "pos", kProbe),
    variable(0x60BB, kInteger32, kTx, kTouchProbeValueFirst + 1, "Touch probe pos1 neg value", {}, "pos", kProbe),
    variable(0x60BC, kInteger32, kTx, kTouchProbeValueFirst + 2, "Touch probe pos2 pos value", {}, "pos", kProbe),
    variable(0x60BD, kInteger32, kTx, kTouchProbeValueFirst + 3, "Touch probe pos2 neg value", {}, "pos", kProbe),
    variable(p(2285), kUnsigned16, kStored, kTouchProbeVariant, "Touch probe function selector", {1, 0, 3}, {},
             "MSD manual 14.1: 1 CiA402, 2 BECK2, 3 SPECIFIC; 0 off and default ours"),
    variable(p(313), kReal32, kStored, kBoostVoltage, "VF control, boost voltage at zero frequency", {0, 0, 1000}, "V",
             kCharacteristic),
    variable(p(314), kReal32, kStored, kNominalFrequency, "VF control, nominal frequency", {400, 0.1, 10000}, "Hz",
             kCharacteristic),
    variable(p(315), kReal32, kStored, kNominalVoltage, "VF control, voltage at nominal frequency", {0, 0, 1000}, "V",
             kCharacteristic),
    variable(p(410), kReal32, kTx, kDcLinkVolts, "DC link voltage", {}, "V", "SERCOS manual Table 10.1"),
    variable(p(412), kInteger32, kTx, kActualIncrements, "Actual position", {}, "inc", kActualValue),
    variable(p(413), kInteger32, kTx, kReferenceIncrements, "Reference position", {}, "inc", kActualValue),
    variable(p(414), kInteger32, kTx, kIncrementDifference, "Actual position difference", {}, "inc", kActualValue),
    variable(p(415), kReal32, kTx, kActualRpm, "Actual speed", {}, "rpm", kActualValue),
    variable(p(416), kReal32, kTx, kReferenceRpm, "Reference speed", {}, "rpm", kActualValue),
    variable(p(418), kReal32, kTx, kReferenceTorqueNm, "Reference torque", {}, "Nm", kActualValue),
    variable(p(419), kReal32, kTx, kActualTorqueNm, "Actual torque", {}, "Nm", kActualValue),
    motor_data(45, kUnsigned16, kMotorType, "MOT_Type", {1, 1, 1}, {},
               "MSD manual 8.2.2: PSM = 1, what the plant is, and no other"),
    motor_data(455, kReal32, kMotorRatedFrequency, "MOT_FNOM", {200, 0.1, 10000}, "Hz",
               "MSD manual 8.2.3: read or write; default the motor's, range ours"),
    motor_data(457, kReal32, kMotorRatedCurrentA, "Motor rated current", {2.5, 0.01, 10000}, "A", kMotorData),
    motor_data(460, kReal32, kMotorRatedTorqueNm, "Motor rated torque", {2.4F, 0.001, 100000}, "Nm", kMotorData),
    variable(p(461), kReal32, access::kRead, kMotorInertia, "Motor inertia", {}, "kg m2", kActualValue),
    variable(p(463), kUnsigned16, access::kRead, kMotorPolePairs, "Motor number of pole pairs", {}, {}, kActualValue),
    parameter(701, 0, kReal32, kTx, kOverloadIntegrator, "MON_ActValues: I2t integrator", {}, "%",
              "Device Help: P 701[0]"),
    parameter(701, 1, kReal32, kTx, kMotorTemperature, "Motor temperature", {}, "degC", "index ours"),
    parameter(701, 12, kReal32, kStored, kUndervoltageLimit, "u_zkoff: undervoltage limit", {250, 0, 2000}, "V",
              "Device Help: P 701[12]; default ours"),
    parameter(731, 0, kReal32, kStored, kMotorTemperatureMax, "MON_MotorTemp_Max", {100, 0, 300}, "degC",
              "Device Help: P 731, default 100 degC"),
    parameter(732, 0, kUnsigned16, kStored, kMotorTemperatureSensor, "MON_MotorPTC", {1, 0, 8}, {},
              "Device Help: 0 off, 1 KTY, 2 PTC, 3 TSS, 4 PTC1, 6-8 NTC; default ours"),
    parameter(733, 0, kReal32, kStored, kOverloadRated, "MON_MotorI2t: Inom", {100, 1, 1000}, "%", kMotorProtection),
    parameter(733, 1, kReal32, kStored, kOverloadStandstill, "I0", {100, 1, 1000}, "%", kMotorProtection),
    parameter(733, 2, kReal32, kStored, kOverloadMiddle, "I1", {100, 1, 1000}, "%", kMotorProtection),
    parameter(733, 3, kReal32, kStored, kOverloadMiddleFrequency, "F1", {25, 0, 10000}, "Hz", kMotorProtection),
    parameter(733, 4, kReal32, kStored, kOverloadRatedFrequency, "FN", {200, 0, 10000}, "Hz", kMotorProtection),
    parameter(733, 7, kReal32, kStored, kOverloadTimeConstant, "Tth", {60, 0.1, 100000}, "s", kMotorProtection),
    parameter(735, 0, kUnsigned16, kStored, kOverloadType, "MON_MotorI2tType", {1, 0, 1}, {},
              "Device Help: 0 FREQ, 1 THERM; default ours"),
};

std::vector<EntryRow> make_function_rows() {
  std::vector<EntryRow> rows(kFunctionRows.begin(), kFunctionRows.end());
  for (std::uint8_t i = 0; i < kMessages; ++i) {
    EntryRow row =
        parameter(33, i, kVisibleString, access::kRead, slot::kOwn, i == 0 ? "Actual fault" : "Actual warning", {}, {},
                  "MSD manual 11.3.2: P 33[0-8] fault and warning texts; order ours");
    row.string_length = 48;
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

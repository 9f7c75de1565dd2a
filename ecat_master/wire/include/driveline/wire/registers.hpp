#pragma once

#include <array>
#include <cstdint>
#include <string_view>

/// The register space of an EtherCAT slave controller, 0x0000-0x0FFF. One table for the master, which accesses the
/// registers, and for the emulated controller, which implements them.
///
/// Sources: ETG.1000.4 chapter 6 (tables cited per row); Beckhoff ESC data sheet section II (register description)
/// where the standard leaves the details to the controller.
namespace driveline::wire {

/// Access rights of EtherCAT or PDI to a register.
enum class RegisterAccess : std::uint8_t { kNone, kRead, kWrite, kReadWrite, kReadClearOnWrite };

/// A register, or an array of equal registers with `stride` bytes between their starts. T is the element type.
template <typename T>
struct Register {
  std::uint16_t address;             ///< address of the first element
  std::string_view name;             ///< as in the ESC data sheet
  RegisterAccess ecat;               ///< access rights of the master
  RegisterAccess pdi;                ///< access rights of the slave's application
  T reset;                           ///< value after power-on
  std::string_view source;           ///< document and table
  std::uint16_t count = 1;           ///< number of elements
  std::uint16_t stride = sizeof(T);  ///< bytes from one element to the next
  /// Bits that exist; the others are reserved, read zero and ignore writes.
  T bits = static_cast<T>(~T{0});

  /// Address of element `n` of an array.
  [[nodiscard]] constexpr std::uint16_t at(unsigned n) const noexcept {
    return static_cast<std::uint16_t>(address + n * stride);
  }
};

/// Registers of a slave controller that the master or the simulated slave uses; each value states name, access of ECAT
/// and PDI, reset value and source.
namespace reg {
using A = RegisterAccess;
using U8 = Register<std::uint8_t>;
using U16 = Register<std::uint16_t>;
using U32 = Register<std::uint32_t>;
using U64 = Register<std::uint64_t>;

// Information
inline constexpr U8 kType{0x0000, "type", A::kRead, A::kRead, 0x11, "ETG.1000.4 Table 31"};
inline constexpr U8 kRevision{0x0001, "revision", A::kRead, A::kRead, 0x00, "ETG.1000.4 Table 31"};
inline constexpr U16 kBuild{0x0002, "build", A::kRead, A::kRead, 0x0002, "ETG.1000.4 Table 31"};
inline constexpr U8 kFmmuCount{0x0004, "FMMUs supported", A::kRead, A::kRead, 8, "ETG.1000.4 Table 31"};
inline constexpr U8 kSyncManagerCount{0x0005, "sync managers supported", A::kRead, A::kRead, 8, "ETG.1000.4 Table 31"};
inline constexpr U8 kRamSize{0x0006, "RAM size in KiB", A::kRead, A::kRead, 8, "ETG.1000.4 Table 31"};
inline constexpr U8 kPortDescriptor{0x0007, "port descriptor", A::kRead, A::kRead, 0x0F, "ETG.1000.4 Table 31"};
inline constexpr U16 kFeatures{0x0008, "ESC features supported", A::kRead, A::kRead, 0x01CC, "ETG.1000.4 Table 31"};
// Addressing
inline constexpr U16 kStationAddress{0x0010, "configured station address", A::kReadWrite, A::kRead,
                                     0,      "ETG.1000.4 Table 32"};
inline constexpr U16 kStationAlias{0x0012, "configured station alias", A::kRead, A::kReadWrite,
                                   0,      "ETG.1000.4 Table 32"};
// Write protection and reset
inline constexpr U8 kRegisterWriteEnable{0x0020, "register write enable", A::kWrite, A::kNone,
                                         0,      "ESC data sheet II 2.9"};
inline constexpr U8 kRegisterWriteProtection{0x0021, "register write protection", A::kReadWrite, A::kRead,
                                             0,      "ESC data sheet II 2.10"};
inline constexpr U8 kEscWriteEnable{0x0030, "ESC write enable", A::kWrite, A::kNone, 0, "ESC data sheet II 2.11"};
inline constexpr U8 kEscWriteProtection{0x0031, "ESC write protection",  A::kReadWrite, A::kRead,
                                        0,      "ESC data sheet II 2.12"};
inline constexpr U8 kResetEcat{0x0040, "ESC reset ECAT", A::kReadWrite, A::kRead, 0, "ESC data sheet II 2.13"};
inline constexpr U8 kResetPdi{0x0041, "ESC reset PDI", A::kRead, A::kReadWrite, 0, "ESC data sheet II 2.14"};
// Data link layer
inline constexpr U32 kDlControl{0x0100, "DL control", A::kReadWrite, A::kRead, 0x00070001, "ETG.1000.4 Table 34", 1,
                                4,      0x014FFF03};
inline constexpr U16 kPhysicalOffset{0x0108, "physical read/write offset", A::kReadWrite, A::kRead,
                                     0,      "ESC data sheet II 2.17"};
inline constexpr U16 kDlStatus{0x0110, "DL status", A::kRead, A::kRead, 0, "ETG.1000.4 Table 35"};
// Application layer
inline constexpr U16 kAlControl{0x0120, "AL control", A::kReadWrite, A::kRead, 0x0001, "ETG.1000.6 Table 9", 1,
                                2,      0x003F};
inline constexpr U16 kAlStatus{0x0130, "AL status", A::kRead, A::kReadWrite, 0x0001, "ETG.1000.6 Table 10"};
inline constexpr U16 kAlStatusCode{0x0134, "AL status code", A::kRead, A::kReadWrite, 0, "ETG.1000.6 Table 11"};
inline constexpr U8 kRunLedOverride{
    0x0138, "RUN LED override", A::kReadWrite, A::kReadWrite, 0, "ESC data sheet II 2.23", 1, 1, 0x1F};
inline constexpr U8 kErrLedOverride{
    0x0139, "ERR LED override", A::kReadWrite, A::kReadWrite, 0, "ESC data sheet II 2.24", 1, 1, 0x1F};
// Process data interface
inline constexpr U8 kPdiControl{0x0140, "PDI control", A::kRead, A::kRead, 0x05, "ETG.1000.4 Table 38"};
inline constexpr U8 kEscConfiguration{0x0141, "ESC configuration", A::kRead, A::kRead, 0x0E, "ESC data sheet II 2.26"};
inline constexpr U16 kPdiInformation{0x014E, "PDI information", A::kRead, A::kRead, 0x0001, "ESC data sheet II 2.27"};
inline constexpr U8 kPdiConfiguration{0x0150, "PDI configuration", A::kRead, A::kRead, 0, "ETG.1000.4 Table 38"};
inline constexpr U8 kSyncLatchConfiguration{0x0151, "SYNC/LATCH PDI configuration", A::kRead, A::kRead,
                                            0x66,   "ETG.1000.4 Table 38"};
inline constexpr U16 kPdiConfigurationExtended{0x0152, "extended PDI configuration", A::kRead, A::kRead,
                                               0,      "ESC data sheet II 2.29"};
// Interrupts
inline constexpr U16 kEcatEventMask{0x0200, "ECAT event mask", A::kReadWrite, A::kRead, 0, "ETG.1000.4 Table 41"};
inline constexpr U32 kAlEventMask{0x0204,        "PDI AL event mask", A::kRead,
                                  A::kReadWrite, 0x00FFFF0F,          "ETG.1000.4 Table 42"};
inline constexpr U16 kEcatEventRequest{0x0210, "ECAT event request", A::kRead, A::kRead, 0, "ETG.1000.4 Table 40"};
inline constexpr U32 kAlEventRequest{0x0220, "AL event request", A::kRead, A::kRead, 0, "ETG.1000.4 Table 39"};
// Error counters
inline constexpr U16 kRxErrorCounter{
    0x0300, "RX error counter (invalid frame, RX error)", A::kReadClearOnWrite, A::kRead, 0, "ETG.1000.4 Table 43", 4};
inline constexpr U8 kForwardedErrorCounter{
    0x0308, "forwarded RX error counter", A::kReadClearOnWrite, A::kRead, 0, "ETG.1000.4 Table 43", 4};
inline constexpr U8 kProcessingUnitErrorCounter{
    0x030C, "ECAT processing unit error counter", A::kReadClearOnWrite, A::kRead, 0, "ETG.1000.4 Table 45"};
inline constexpr U8 kPdiErrorCounter{0x030D, "PDI error counter",  A::kReadClearOnWrite, A::kRead,
                                     0,      "ETG.1000.4 Table 45"};
inline constexpr U16 kPdiErrorCode{0x030E, "PDI error code", A::kRead, A::kRead, 0, "ESC data sheet II 2.38"};
inline constexpr U8 kLostLinkCounter{
    0x0310, "lost link counter", A::kReadClearOnWrite, A::kRead, 0, "ETG.1000.4 Table 44", 4};
// Watchdogs
inline constexpr U16 kWatchdogDivider{0x0400, "watchdog divider",   A::kReadWrite, A::kRead,
                                      0x09C2, "ETG.1000.4 Table 46"};
inline constexpr U16 kWatchdogTimePdi{0x0410, "watchdog time PDI",  A::kReadWrite, A::kRead,
                                      0x03E8, "ETG.1000.4 Table 47"};
inline constexpr U16 kWatchdogTimeProcessData{0x0420, "watchdog time process data", A::kReadWrite, A::kRead,
                                              0x03E8, "ETG.1000.4 Table 48"};
inline constexpr U16 kWatchdogStatusProcessData{0x0440, "watchdog status process data", A::kRead, A::kRead,
                                                0,      "ETG.1000.4 Table 49"};
inline constexpr U8 kWatchdogCounterProcessData{
    0x0442, "watchdog counter process data", A::kReadClearOnWrite, A::kRead, 0, "ETG.1000.4 Table 50"};
inline constexpr U8 kWatchdogCounterPdi{0x0443, "watchdog counter PDI", A::kReadClearOnWrite, A::kRead,
                                        0,      "ETG.1000.4 Table 50"};
// Slave information interface (EEPROM)
inline constexpr U8 kSiiConfiguration{0x0500, "SII EEPROM configuration", A::kReadWrite, A::kRead,
                                      0,      "ETG.1000.4 Table 51"};
inline constexpr U8 kSiiPdiAccess{0x0501, "SII EEPROM PDI access state", A::kRead, A::kReadWrite,
                                  0,      "ETG.1000.4 Table 51"};
inline constexpr U16 kSiiControl{0x0502, "SII EEPROM control/status", A::kReadWrite, A::kReadWrite,
                                 0x0040, "ETG.1000.4 Table 52"};
inline constexpr U32 kSiiAddress{0x0504, "SII EEPROM address", A::kReadWrite, A::kReadWrite, 0, "ETG.1000.4 Table 53"};
inline constexpr U64 kSiiData{0x0508, "SII EEPROM data", A::kReadWrite, A::kReadWrite, 0, "ETG.1000.4 Table 54"};
// MII management
inline constexpr U16 kMiiControl{
    0x0510, "MII management control/status", A::kReadWrite, A::kReadWrite, 0, "ETG.1000.4 Table 55"};
inline constexpr U8 kPhyAddress{0x0512, "PHY address", A::kReadWrite, A::kReadWrite, 0, "ETG.1000.4 Table 55"};
inline constexpr U8 kPhyRegister{0x0513, "PHY register address", A::kReadWrite, A::kReadWrite,
                                 0,      "ETG.1000.4 Table 55"};
inline constexpr U16 kPhyData{0x0514, "PHY data", A::kReadWrite, A::kReadWrite, 0, "ETG.1000.4 Table 55"};
inline constexpr U8 kMiiEcatAccess{
    0x0516, "MII management ECAT access state", A::kReadWrite, A::kRead, 0, "ESC data sheet II 2.54"};
inline constexpr U8 kMiiPdiAccess{0x0517, "MII management PDI access state", A::kRead, A::kReadWrite,
                                  0,      "ESC data sheet II 2.55"};
inline constexpr U8 kPhyPortStatus{0x0518, "PHY port status", A::kReadWrite, A::kReadWrite, 0, "ESC data sheet II 2.56",
                                   4};
// FMMU and sync manager (layout of the elements: FmmuEntity, SyncManagerChannel)
inline constexpr U8 kFmmu{0x0600, "FMMU", A::kReadWrite, A::kRead, 0, "ETG.1000.4 Table 56", 16, 16};
inline constexpr U8 kSyncManager{0x0800, "sync manager", A::kReadWrite, A::kRead, 0, "ETG.1000.4 Table 59", 16, 8};
// Distributed clocks
inline constexpr U32 kReceiveTimePort{0x0900, "receive time port", A::kReadWrite, A::kRead, 0, "ETG.1000.4 Table 60",
                                      4};
inline constexpr U64 kSystemTime{0x0910, "system time", A::kReadWrite, A::kRead, 0, "ETG.1000.4 Table 60"};
inline constexpr U64 kReceiveTimeProcessingUnit{
    0x0918, "receive time ECAT processing unit", A::kRead, A::kRead, 0, "ETG.1000.4 Table 60"};
inline constexpr U64 kSystemTimeOffset{0x0920, "system time offset", A::kReadWrite, A::kRead, 0, "ETG.1000.4 Table 60"};
inline constexpr U32 kSystemTimeDelay{0x0928, "system time delay", A::kReadWrite, A::kRead, 0, "ETG.1000.4 Table 60"};
inline constexpr U32 kSystemTimeDifference{0x092C, "system time difference", A::kRead, A::kRead,
                                           0,      "ETG.1000.4 Table 60"};
inline constexpr U16 kSpeedCounterStart{
    0x0930, "speed counter start", A::kReadWrite, A::kRead, 0x1000, "ETG.1000.4 Table 60", 1, 2, 0x7FFF};
inline constexpr U16 kSpeedCounterDifference{0x0932, "speed counter difference", A::kRead, A::kRead,
                                             0,      "ETG.1000.4 Table 60"};
inline constexpr U8 kSystemTimeFilterDepth{
    0x0934, "system time difference filter depth", A::kReadWrite, A::kRead, 4, "ETG.1000.4 Table 60", 1, 1, 0x0F};
inline constexpr U8 kSpeedFilterDepth{
    0x0935, "speed counter filter depth", A::kReadWrite, A::kRead, 12, "ETG.1000.4 Table 60", 1, 1, 0x0F};
inline constexpr U8 kCyclicUnitControl{
    0x0980, "cyclic unit control", A::kReadWrite, A::kRead, 0, "ETG.1000.4 Table 61", 1, 1, 0x31};
inline constexpr U8 kDcActivation{0x0981, "DC activation", A::kReadWrite, A::kReadWrite, 0, "ETG.1000.4 Table 61", 1, 1,
                                  0x7F};
inline constexpr U16 kSyncPulseLength{0x0982, "SYNC pulse length in 10 ns", A::kRead, A::kRead,
                                      0x0064, "ETG.1000.4 Table 61"};
inline constexpr U8 kDcActivationStatus{0x0984, "DC activation status", A::kRead, A::kRead, 0, "ETG.1000.4 Table 61"};
inline constexpr U8 kSync0Status{0x098E, "SYNC0 status", A::kRead, A::kRead, 0, "ETG.1000.4 Table 61"};
inline constexpr U8 kSync1Status{0x098F, "SYNC1 status", A::kRead, A::kRead, 0, "ETG.1000.4 Table 61"};
inline constexpr U64 kStartTimeCyclic{
    0x0990, "start time of cyclic operation / next SYNC0", A::kReadWrite, A::kReadWrite, 0, "ETG.1000.4 Table 61"};
inline constexpr U64 kNextSync1{0x0998, "next SYNC1 pulse", A::kRead, A::kRead, 0, "ETG.1000.4 Table 61"};
inline constexpr U32 kSync0CycleTime{0x09A0, "SYNC0 cycle time",   A::kReadWrite, A::kReadWrite,
                                     0,      "ETG.1000.4 Table 61"};
inline constexpr U32 kSync1CycleTime{0x09A4, "SYNC1 cycle time",   A::kReadWrite, A::kReadWrite,
                                     0,      "ETG.1000.4 Table 61"};
inline constexpr U8 kLatch0Control{
    0x09A8, "LATCH0 control", A::kReadWrite, A::kReadWrite, 0, "ETG.1000.4 Table 62", 1, 1, 0x03};
inline constexpr U8 kLatch1Control{
    0x09A9, "LATCH1 control", A::kReadWrite, A::kReadWrite, 0, "ETG.1000.4 Table 62", 1, 1, 0x03};
inline constexpr U8 kLatch0Status{0x09AE, "LATCH0 status", A::kRead, A::kRead, 0, "ETG.1000.4 Table 62"};
inline constexpr U8 kLatch1Status{0x09AF, "LATCH1 status", A::kRead, A::kRead, 0, "ETG.1000.4 Table 62"};
inline constexpr U64 kLatch0PositiveEdge{0x09B0, "LATCH0 time positive edge", A::kRead, A::kRead,
                                         0,      "ETG.1000.4 Table 62"};
inline constexpr U64 kLatch0NegativeEdge{0x09B8, "LATCH0 time negative edge", A::kRead, A::kRead,
                                         0,      "ETG.1000.4 Table 62"};
inline constexpr U64 kLatch1PositiveEdge{0x09C0, "LATCH1 time positive edge", A::kRead, A::kRead,
                                         0,      "ETG.1000.4 Table 62"};
inline constexpr U64 kLatch1NegativeEdge{0x09C8, "LATCH1 time negative edge", A::kRead, A::kRead,
                                         0,      "ETG.1000.4 Table 62"};
inline constexpr U32 kEcatBufferChangeTime{0x09F0, "ECAT buffer change event time", A::kRead, A::kRead,
                                           0,      "ESC data sheet II 2.78"};
inline constexpr U32 kPdiBufferStartTime{0x09F8, "PDI buffer start event time", A::kRead, A::kRead,
                                         0,      "ESC data sheet II 2.79"};
inline constexpr U32 kPdiBufferChangeTime{0x09FC, "PDI buffer change event time", A::kRead, A::kRead,
                                          0,      "ESC data sheet II 2.80"};
// ESC specific, digital I/O and general purpose
inline constexpr U16 kPowerOnValues{0x0E00, "power-on values", A::kRead, A::kRead, 0, "ESC data sheet II 2.81", 1};
inline constexpr U32 kDigitalOutput{0x0F00, "digital I/O output data", A::kReadWrite, A::kRead,
                                    0,      "ESC data sheet II 2.85"};
inline constexpr U64 kGeneralPurposeOutput{0x0F10, "general purpose outputs", A::kReadWrite, A::kReadWrite,
                                           0,      "ESC data sheet II 2.86"};
inline constexpr U64 kGeneralPurposeInput{0x0F18, "general purpose inputs", A::kRead, A::kRead,
                                          0,      "ESC data sheet II 2.87"};
inline constexpr U8 kUserRam{0x0F80, "user RAM", A::kReadWrite, A::kReadWrite, 0, "ESC data sheet II 2.88", 128};
}  // namespace reg

/// A row of the register table, with the type of the register reduced to its size.
struct RegisterRow {
  std::uint16_t address = 0;                    ///< address of the first element
  std::uint16_t size = 0;                       ///< bytes per element
  std::uint16_t count = 1;                      ///< number of elements
  std::uint16_t stride = 0;                     ///< bytes from one element to the next
  RegisterAccess ecat = RegisterAccess::kNone;  ///< access rights of the master
  RegisterAccess pdi = RegisterAccess::kNone;   ///< access rights of the slave's application
  std::uint64_t reset = 0;                      ///< value after power-on
  std::string_view name;                        ///< as in the ESC data sheet
  std::string_view source;                      ///< document and table
  std::uint64_t bits = 0;                       ///< bits that exist
  /// First address behind the last element.
  [[nodiscard]] constexpr std::uint32_t end() const noexcept { return address + std::uint32_t{count} * stride; }
};

template <typename T>
/// The row of a typed register.
[[nodiscard]] constexpr RegisterRow register_row(const Register<T>& r) noexcept {
  return {r.address, sizeof(T), r.count, r.stride, r.ecat, r.pdi, r.reset, r.name, r.source, r.bits};
}

/// First byte behind the registers: start of the process RAM.
inline constexpr std::uint16_t kProcessRamStart = 0x1000;

/// All registers, ascending by address. Gaps are reserved: they read as zero and ignore writes.
inline constexpr std::array kRegisters = {register_row(reg::kType),
                                          register_row(reg::kRevision),
                                          register_row(reg::kBuild),
                                          register_row(reg::kFmmuCount),
                                          register_row(reg::kSyncManagerCount),
                                          register_row(reg::kRamSize),
                                          register_row(reg::kPortDescriptor),
                                          register_row(reg::kFeatures),
                                          register_row(reg::kStationAddress),
                                          register_row(reg::kStationAlias),
                                          register_row(reg::kRegisterWriteEnable),
                                          register_row(reg::kRegisterWriteProtection),
                                          register_row(reg::kEscWriteEnable),
                                          register_row(reg::kEscWriteProtection),
                                          register_row(reg::kResetEcat),
                                          register_row(reg::kResetPdi),
                                          register_row(reg::kDlControl),
                                          register_row(reg::kPhysicalOffset),
                                          register_row(reg::kDlStatus),
                                          register_row(reg::kAlControl),
                                          register_row(reg::kAlStatus),
                                          register_row(reg::kAlStatusCode),
                                          register_row(reg::kRunLedOverride),
                                          register_row(reg::kErrLedOverride),
                                          register_row(reg::kPdiControl),
                                          register_row(reg::kEscConfiguration),
                                          register_row(reg::kPdiInformation),
                                          register_row(reg::kPdiConfiguration),
                                          register_row(reg::kSyncLatchConfiguration),
                                          register_row(reg::kPdiConfigurationExtended),
                                          register_row(reg::kEcatEventMask),
                                          register_row(reg::kAlEventMask),
                                          register_row(reg::kEcatEventRequest),
                                          register_row(reg::kAlEventRequest),
                                          register_row(reg::kRxErrorCounter),
                                          register_row(reg::kForwardedErrorCounter),
                                          register_row(reg::kProcessingUnitErrorCounter),
                                          register_row(reg::kPdiErrorCounter),
                                          register_row(reg::kPdiErrorCode),
                                          register_row(reg::kLostLinkCounter),
                                          register_row(reg::kWatchdogDivider),
                                          register_row(reg::kWatchdogTimePdi),
                                          register_row(reg::kWatchdogTimeProcessData),
                                          register_row(reg::kWatchdogStatusProcessData),
                                          register_row(reg::kWatchdogCounterProcessData),
                                          register_row(reg::kWatchdogCounterPdi),
                                          register_row(reg::kSiiConfiguration),
                                          register_row(reg::kSiiPdiAccess),
                                          register_row(reg::kSiiControl),
                                          register_row(reg::kSiiAddress),
                                          register_row(reg::kSiiData),
                                          register_row(reg::kMiiControl),
                                          register_row(reg::kPhyAddress),
                                          register_row(reg::kPhyRegister),
                                          register_row(reg::kPhyData),
                                          register_row(reg::kMiiEcatAccess),
                                          register_row(reg::kMiiPdiAccess),
                                          register_row(reg::kPhyPortStatus),
                                          register_row(reg::kFmmu),
                                          register_row(reg::kSyncManager),
                                          register_row(reg::kReceiveTimePort),
                                          register_row(reg::kSystemTime),
                                          register_row(reg::kReceiveTimeProcessingUnit),
                                          register_row(reg::kSystemTimeOffset),
                                          register_row(reg::kSystemTimeDelay),
                                          register_row(reg::kSystemTimeDifference),
                                          register_row(reg::kSpeedCounterStart),
                                          register_row(reg::kSpeedCounterDifference),
                                          register_row(reg::kSystemTimeFilterDepth),
                                          register_row(reg::kSpeedFilterDepth),
                                          register_row(reg::kCyclicUnitControl),
                                          register_row(reg::kDcActivation),
                                          register_row(reg::kSyncPulseLength),
                                          register_row(reg::kDcActivationStatus),
                                          register_row(reg::kSync0Status),
                                          register_row(reg::kSync1Status),
                                          register_row(reg::kStartTimeCyclic),
                                          register_row(reg::kNextSync1),
                                          register_row(reg::kSync0CycleTime),
                                          register_row(reg::kSync1CycleTime),
                                          register_row(reg::kLatch0Control),
                                          register_row(reg::kLatch1Control),
                                          register_row(reg::kLatch0Status),
                                          register_row(reg::kLatch1Status),
                                          register_row(reg::kLatch0PositiveEdge),
                                          register_row(reg::kLatch0NegativeEdge),
                                          register_row(reg::kLatch1PositiveEdge),
                                          register_row(reg::kLatch1NegativeEdge),
                                          register_row(reg::kEcatBufferChangeTime),
                                          register_row(reg::kPdiBufferStartTime),
                                          register_row(reg::kPdiBufferChangeTime),
                                          register_row(reg::kPowerOnValues),
                                          register_row(reg::kDigitalOutput),
                                          register_row(reg::kGeneralPurposeOutput),
                                          register_row(reg::kGeneralPurposeInput),
                                          register_row(reg::kUserRam)};

/// Sorted, without overlap, inside the register space; no reserved bit is set at reset.
[[nodiscard]] constexpr bool registers_are_consistent() noexcept {
  for (std::size_t i = 0; i < kRegisters.size(); ++i) {
    const auto& row = kRegisters[i];
    if (row.stride < row.size || row.count == 0 || row.end() > kProcessRamStart || row.source.empty()) return false;
    if ((row.reset & ~row.bits) != 0) return false;
    if (i > 0 && kRegisters[i - 1].end() > row.address) return false;
  }
  return true;
}
static_assert(registers_are_consistent());

}  // namespace driveline::wire

#pragma once

#include <array>
#include <cstdint>
#include <string_view>

/// What SDO transfers over CANopen and over EtherCAT (CoE) have in common.
namespace driveline::sdo {

/// SDO abort codes (CiA 301 7.2.4.3.17, ETG.1000.6 Table 41). Other values may arrive and are retained.
enum class SdoAbort : std::uint32_t {
  kToggleNotAlternated = 0x05030000,
  kTimeout = 0x05040000,
  kInvalidCommand = 0x05040001,
  kInvalidBlockSize = 0x05040002,
  kInvalidSequenceNumber = 0x05040003,
  kCrcError = 0x05040004,
  kOutOfMemory = 0x05040005,
  kUnsupportedAccess = 0x06010000,
  kWriteOnly = 0x06010001,
  kReadOnly = 0x06010002,
  kSubindexCannotBeWritten = 0x06010003,
  kNoCompleteAccess = 0x06010004,
  kObjectTooLongForMailbox = 0x06010005,
  kMappedToRxPdo = 0x06010006,
  kObjectDoesNotExist = 0x06020000,
  kNotMappable = 0x06040041,
  kMappingTooLong = 0x06040042,
  kParameterIncompatible = 0x06040043,
  kInternalIncompatible = 0x06040047,
  kHardwareError = 0x06060000,
  kLengthMismatch = 0x06070010,
  kLengthTooHigh = 0x06070012,
  kLengthTooLow = 0x06070013,
  kSubindexDoesNotExist = 0x06090011,
  kValueRange = 0x06090030,
  kValueTooHigh = 0x06090031,
  kValueTooLow = 0x06090032,
  kMaximumBelowMinimum = 0x06090036,
  kResourceNotAvailable = 0x060A0023,
  kGeneralError = 0x08000000,
  kCannotTransferOrStore = 0x08000020,
  kLocalControl = 0x08000021,
  kDeviceState = 0x08000022,
  kNoObjectDictionary = 0x08000023,
  kNoDataAvailable = 0x08000024,
};

/// A code and its text.
struct SdoAbortText {
  SdoAbort code;
  std::string_view text;  ///< its meaning in the words of the standards
};

/// Every code of the standard with its meaning.
inline constexpr std::array kSdoAbortTexts = {
    SdoAbortText{SdoAbort::kToggleNotAlternated, "toggle bit not alternated"},
    SdoAbortText{SdoAbort::kTimeout, "SDO protocol timeout"},
    SdoAbortText{SdoAbort::kInvalidCommand, "command specifier not valid or unknown"},
    SdoAbortText{SdoAbort::kInvalidBlockSize, "block size not valid"},
    SdoAbortText{SdoAbort::kInvalidSequenceNumber, "sequence number of a block not valid"},
    SdoAbortText{SdoAbort::kCrcError, "CRC error of a block transfer"},
    SdoAbortText{SdoAbort::kOutOfMemory, "out of memory"},
    SdoAbortText{SdoAbort::kUnsupportedAccess, "unsupported access to an object"},
    SdoAbortText{SdoAbort::kWriteOnly, "object is write only"},
    SdoAbortText{SdoAbort::kReadOnly, "object is read only"},
    SdoAbortText{SdoAbort::kSubindexCannotBeWritten, "sub-index cannot be written, sub-index 0 must be 0 first"},
    SdoAbortText{SdoAbort::kNoCompleteAccess, "complete access not supported for this object"},
    SdoAbortText{SdoAbort::kObjectTooLongForMailbox, "object length exceeds the mailbox size"},
    SdoAbortText{SdoAbort::kMappedToRxPdo, "object mapped to an RxPDO, download blocked"},
    SdoAbortText{SdoAbort::kObjectDoesNotExist, "object does not exist in the object dictionary"},
    SdoAbortText{SdoAbort::kNotMappable, "object cannot be mapped to a PDO"},
    SdoAbortText{SdoAbort::kMappingTooLong, "mapped objects would exceed the PDO length"},
    SdoAbortText{SdoAbort::kParameterIncompatible, "general parameter incompatibility"},
    SdoAbortText{SdoAbort::kInternalIncompatible, "general internal incompatibility in the device"},
    SdoAbortText{SdoAbort::kHardwareError, "access failed because of a hardware error"},
    SdoAbortText{SdoAbort::kLengthMismatch, "data type does not match, length of parameter does not match"},
    SdoAbortText{SdoAbort::kLengthTooHigh, "data type does not match, length too high"},
    SdoAbortText{SdoAbort::kLengthTooLow, "data type does not match, length too low"},
    SdoAbortText{SdoAbort::kSubindexDoesNotExist, "sub-index does not exist"},
    SdoAbortText{SdoAbort::kValueRange, "value range of parameter exceeded"},
    SdoAbortText{SdoAbort::kValueTooHigh, "value of parameter too high"},
    SdoAbortText{SdoAbort::kValueTooLow, "value of parameter too low"},
    SdoAbortText{SdoAbort::kMaximumBelowMinimum, "maximum value is less than minimum value"},
    SdoAbortText{SdoAbort::kResourceNotAvailable, "resource not available: SDO connection"},
    SdoAbortText{SdoAbort::kGeneralError, "general error"},
    SdoAbortText{SdoAbort::kCannotTransferOrStore, "data cannot be transferred or stored"},
    SdoAbortText{SdoAbort::kLocalControl, "data cannot be transferred or stored because of local control"},
    SdoAbortText{SdoAbort::kDeviceState, "data cannot be transferred or stored in the present device state"},
    SdoAbortText{SdoAbort::kNoObjectDictionary, "no object dictionary present"},
    SdoAbortText{SdoAbort::kNoDataAvailable, "no data available"},
};

/// Meaning of a code; "unknown abort code" when the standard has none.
[[nodiscard]] constexpr std::string_view to_text(SdoAbort code) noexcept {
  for (const auto& row : kSdoAbortTexts) {
    if (row.code == code) return row.text;
  }
  return "unknown abort code";
}

}  // namespace driveline::sdo

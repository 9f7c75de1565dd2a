// Rows that identify the drive, record its errors and store its parameters (CiA 301).
#include "table_row.hpp"

namespace driveline::slaves::msd {
namespace {

using enum esi::DataType;
using esi::ObjectCode;

constexpr std::string_view kTable81 = "MSD manual Table 8.1";
constexpr std::uint16_t kIdentityRecord = 0x0023;

constexpr std::array kIdentityRows = {
    constant(0x1000, 0, ObjectCode::kVariable, kUnsigned32, "Device type", 0x00020192, kTable81),
    variable(0x1001, kTx, kValue.error_register, "Error register", {}, {}, kTable81),
    element(0x1003, 0, access::kReadWrite, kValue.error_count, "Pre-defined error field", {}, {},
            "MSD manual Table 8.1: one sub-entry; CiA 301: writing 0 clears"),
    element(0x1003, 1, access::kRead, kValue.last_error, "Last error", {}, {},
            "CiA 301: error code, above it number and location (ours)"),
    text(0x1008, access::kRead, "Manufacturer device name", "MSD Servo Drive", 15, kTable81),
    text(0x1009, access::kRead, "Manufacturer hardware version", "simulation", 10,
         "MSD manual Table 8.1; content ours"),
    text(0x100A, access::kRead, "Manufacturer software version", "124.30-00", 9,
         "MSD manual: applies from 124.25; format ours"),
    array_length(0x1010, "Store parameters", 1, kTable81),
    element(0x1010, 1, access::kReadWrite, kValue.store_command, "Store all parameters", {1}, {},
            "MSD manual 7.5.3; signature CiA 301"),
    array_length(0x1011, "Restore default parameters", 1, kTable81),
    element(0x1011, 1, access::kReadWrite, kValue.restore_command, "Restore all parameters", {1}, {},
            "MSD manual Table 8.1; signature CiA 301"),
    record_length(0x1018, kIdentityRecord, "Identity", 4, kTable81),
    constant(0x1018, 1, ObjectCode::kRecord, kUnsigned32, "Vendor ID", kVendorId, kTable81),
    constant(0x1018, 2, ObjectCode::kRecord, kUnsigned32, "Product code", kProductCode, "ours"),
    constant(0x1018, 3, ObjectCode::kRecord, kUnsigned32, "Revision number", kRevision, "ours"),
    field(0x1018, 4, access::kRead, kValue.serial_number, "Serial number", {}, {}, kTable81),
};

}  // namespace

std::span<const EntryRow> identity_rows() {
  return kIdentityRows;
}

}  // namespace driveline::slaves::msd

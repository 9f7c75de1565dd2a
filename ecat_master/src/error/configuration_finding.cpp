#include "driveline/ecat_master/error/configuration_finding.hpp"

#include <fmt/format.h>

#include <string_view>

namespace driveline::ecat_master {
namespace {

using Finding = ConfigurationFinding;
using Field = Finding::Field;

std::string_view field_text(Field field) {
  switch (field) {
    case Field::kStart:
      return "start address";
    case Field::kLength:
      return "length";
    case Field::kControl:
      return "control byte";
    case Field::kActivation:
      return "activation";
    case Field::kLogicalStart:
      return "logical start address";
    case Field::kType:
      break;
  }
  return "type";
}

std::string value_text(Field field, std::uint32_t value) {
  if (field == Field::kLength) return fmt::format("{}", value);
  if (field == Field::kActivation) return value == 0 ? "off" : "on";
  return fmt::format("0x{:0{}X}", value, field == Field::kLogicalStart ? 8 : field == Field::kStart ? 4 : 2);
}

}  // namespace

std::string describe(const Finding& f) {
  const auto field = field_text(f.field);
  switch (f.kind) {
    case Finding::Kind::kPdoBytes:
      return fmt::format("sync manager {} is set to {} bytes, the slave's PDO mapping has {}", f.number, f.expected,
                         f.received);
    case Finding::Kind::kPlannedBytes:
      return fmt::format("the PDOs planned for sync manager {} have {} bytes, the PDOs assigned by the slave have {}",
                         f.number, f.expected, f.received);
    case Finding::Kind::kSyncManager:
    case Finding::Kind::kFmmu:
      return fmt::format("{} {}: {} is {} instead of {}", f.kind == Finding::Kind::kFmmu ? "FMMU" : "sync manager",
                         f.number, field, value_text(f.field, f.received), value_text(f.field, f.expected));
    case Finding::Kind::kFmmuBytes:
      return fmt::format("FMMU {} maps {} bytes of sync manager {}, which has {}", f.number, f.received, f.other,
                         f.expected);
    case Finding::Kind::kOverlap:
      return fmt::format("the memory of sync managers {} (from 0x{:04X}) and {} (from 0x{:04X}) overlaps", f.number,
                         f.expected, f.other, f.received);
    case Finding::Kind::kEeprom:
      return fmt::format("sync manager {}: {} is {} by the description file, {} by the EEPROM", f.number, field,
                         value_text(f.field, f.expected), value_text(f.field, f.received));
    case Finding::Kind::kWatchdog:
      break;
  }
  return f.received == 0
             ? fmt::format("sync manager {} triggers the watchdog, which is switched off", f.number)
             : fmt::format("sync manager {} triggers the watchdog, which is set to {} us", f.number, f.received);
}

}  // namespace driveline::ecat_master

#include "persona/sdo_obstacles.hpp"

#include <algorithm>
#include <array>
#include <iterator>

#include "driveline/wire/mailbox.hpp"
#include "driveline/wire/sdo_abort.hpp"

namespace driveline::slaves {
namespace {

using wire::SdoAbort;
using Kind = PersonaKind;

/// Accesses that a rule refuses.
enum class Access : std::uint8_t { kWrite, kAny, kComplete };

/// Objects that a persona refuses to transfer.
struct Rule {
  Kind kind;
  Access access;
  std::uint16_t first;                 ///< first index
  std::uint16_t last;                  ///< last index
  std::optional<std::uint8_t> sub;     ///< sub-index; none: all
  std::optional<SdoAbort> abort_code;  ///< none: the value of the persona
};

constexpr std::optional<std::uint8_t> kAll;
constexpr std::optional<SdoAbort> kOfPersona;

constexpr std::array kRules = {
    Rule{Kind::kSyncTypeReadOnly, Access::kWrite, 0x1C32, 0x1C33, 1, SdoAbort::kReadOnly},
    Rule{Kind::kSyncTypeUnsupported, Access::kWrite, 0x1C32, 0x1C33, 1, SdoAbort::kUnsupportedAccess},
    Rule{Kind::kSyncTypeByState, Access::kWrite, 0x1C32, 0x1C33, 1, SdoAbort::kDeviceState},
    Rule{Kind::kSyncCycleReadOnly, Access::kWrite, 0x1C32, 0x1C33, 2, SdoAbort::kReadOnly},
    Rule{Kind::kSyncCycleLimited, Access::kWrite, 0x1C32, 0x1C33, 2, SdoAbort::kValueRange},
    Rule{Kind::kNoSyncObjects, Access::kAny, 0x1C32, 0x1C33, kAll, SdoAbort::kObjectDoesNotExist},
    Rule{Kind::kNoInterpolationTime, Access::kAny, 0x60C2, 0x60C2, kAll, SdoAbort::kObjectDoesNotExist},
    Rule{Kind::kInterpolationTimeReadOnly, Access::kWrite, 0x60C2, 0x60C2, kAll, SdoAbort::kReadOnly},
    Rule{Kind::kInterpolationTimeLimited, Access::kWrite, 0x60C2, 0x60C2, kAll, SdoAbort::kValueRange},
    Rule{Kind::kNoOutputAssignment, Access::kAny, 0x1C12, 0x1C12, kAll, kOfPersona},
    Rule{Kind::kNoInputAssignment, Access::kAny, 0x1C13, 0x1C13, kAll, kOfPersona},
    Rule{Kind::kNoSyncManagerTypes, Access::kAny, 0x1C00, 0x1C00, kAll, SdoAbort::kObjectDoesNotExist},
    Rule{Kind::kFixedAssignment, Access::kWrite, 0x1C12, 0x1C13, kAll, kOfPersona},
    Rule{Kind::kFixedMapping, Access::kWrite, 0x1600, 0x17FF, kAll, kOfPersona},
    Rule{Kind::kFixedMapping, Access::kWrite, 0x1A00, 0x1BFF, kAll, kOfPersona},
    Rule{Kind::kNoCompleteAccess, Access::kComplete, 0x0000, 0xFFFF, kAll, SdoAbort::kNoCompleteAccess},
};

/// An initiate request of the SDO protocol.
struct SdoRequest {
  wire::SdoHeader header;
  bool write = false;
  std::span<const std::byte> data;  ///< bytes to write that the message contains
};

/// Returns the initiate request in a mailbox message; none: it has another service or protocol.
std::optional<SdoRequest> initiate_request(std::span<const std::byte> mail) {
  const auto mailbox = wire::MailboxHeader::decode(mail);
  if (!mailbox || mailbox->type != wire::MailboxType::kCoe) return std::nullopt;
  const auto service = mail.subspan(wire::MailboxHeader::kSize, mailbox->length);
  const auto coe = wire::CoeHeader::decode(service);
  if (!coe || coe->service != wire::CoeService::kSdoRequest) return std::nullopt;
  const auto sdo = service.subspan(wire::CoeHeader::kSize);
  const auto header = wire::SdoHeader::decode(sdo);
  if (!header) return std::nullopt;
  const auto command = static_cast<wire::SdoRequestCommand>(header->specifier());
  const bool write = command == wire::SdoRequestCommand::kInitiateDownload;
  if (!write && command != wire::SdoRequestCommand::kInitiateUpload) return std::nullopt;
  // An expedited value is in the last 4 bytes of the header.
  const auto data =
      header->expedited() ? sdo.subspan(wire::SdoHeader::kSize - 4, 4) : sdo.subspan(wire::SdoHeader::kSize);
  return SdoRequest{*header, write, data};
}

bool concerns(const Rule& rule, const SdoRequest& request) noexcept {
  const auto& header = request.header;
  if (header.index < rule.first || header.index > rule.last) return false;
  if (rule.access == Access::kWrite && !request.write) return false;
  if (rule.access == Access::kComplete) return header.complete_access();
  return !rule.sub || header.complete_access() || header.subindex == *rule.sub;
}

bool is_mapping(std::uint16_t index) noexcept {
  return (index >= 0x1600 && index <= 0x17FF) || (index >= 0x1A00 && index <= 0x1BFF);
}

bool is_assignment(std::uint16_t index) noexcept {
  return index == 0x1C12 || index == 0x1C13;
}

/// Whether the persona limits the number of elements of an object.
bool limits_elements(Kind kind) noexcept {
  return kind == Kind::kMappingLimit || kind == Kind::kAssignmentLimit;
}

/// Whether the request sets the number of elements of an object to more than the persona allows. With complete access
/// it is the first byte as well.
bool exceeds_limit(const Persona& persona, const SdoRequest& request) noexcept {
  const auto& header = request.header;
  if (!limits_elements(persona.kind) || !request.write || header.subindex != 0 || request.data.empty()) return false;
  const bool limited = persona.kind == Kind::kMappingLimit ? is_mapping(header.index) : is_assignment(header.index);
  return limited && std::to_integer<std::uint32_t>(request.data.front()) > persona.value;
}

}  // namespace

SdoObstacles::SdoObstacles(std::span<const Persona> personas) {
  std::copy_if(personas.begin(), personas.end(), std::back_inserter(personas_), [](const Persona& persona) {
    return limits_elements(persona.kind) ||
           std::any_of(kRules.begin(), kRules.end(), [&](const Rule& rule) { return rule.kind == persona.kind; });
  });
}

std::optional<SdoRefusal> SdoObstacles::refuse(std::span<const std::byte> mail) const {
  if (personas_.empty()) return std::nullopt;
  const auto request = initiate_request(mail);
  if (!request) return std::nullopt;
  for (const auto& persona : personas_) {
    if (exceeds_limit(persona, *request)) {
      return SdoRefusal{request->header, static_cast<std::uint32_t>(SdoAbort::kMappingTooLong)};
    }
    for (const auto& rule : kRules) {
      if (rule.kind != persona.kind || !concerns(rule, *request)) continue;
      const auto code = rule.abort_code ? static_cast<std::uint32_t>(*rule.abort_code) : persona.value;
      return SdoRefusal{request->header, code};
    }
  }
  return std::nullopt;
}

}  // namespace driveline::slaves

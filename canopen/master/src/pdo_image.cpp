#include "driveline/canopen_master/pdo_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "driveline/canopen_wire/cob_id.hpp"

namespace driveline::canopen {
namespace {

constexpr std::size_t kMostBits = 8 * Frame::kMaxLength;
constexpr std::uint16_t kFirstRpdoMapping = 0x1600;  ///< CiA 301 7.5.2.36
constexpr std::uint16_t kFirstTpdoMapping = 0x1A00;  ///< CiA 301 7.5.2.38

using Refusal = std::optional<PdoImageError>;

Refusal node_id_error(const MasterPlan& plan, std::size_t node) {
  const auto id = plan.nodes[node].id;
  PdoImageError error;
  error.node = error.other_node = node;
  if (id == 0 || id > kMaxNodeId) {
    error.kind = PdoImageErrorKind::kNodeId;
    return error;
  }
  error.kind = PdoImageErrorKind::kSameNode;
  if (id == plan.master_id) return error;
  for (std::size_t other = 0; other < node; ++other) {
    if (plan.nodes[other].id != id) continue;
    error.other_node = other;
    return error;
  }
  return std::nullopt;
}

/// That of the predefined connection set if the plan has none; 0: neither has one.
std::uint16_t identifier_of(const NodePlan& node, const PdoPlan& pdo, bool output) {
  if (pdo.identifier != 0) return pdo.identifier;
  const auto& bases = output ? predefined::kRxPdo : predefined::kTxPdo;
  if (pdo.number < 1 || pdo.number > bases.size()) return 0;
  return static_cast<std::uint16_t>(bases[pdo.number - 1U] + node.id);
}

bool is_reserved(const MasterPlan& plan, std::uint16_t identifier) {
  if (identifier > Identifier::kBaseMask || is_restricted({identifier, false})) return true;
  if (identifier == plan.sync_identifier || identifier == predefined::kTime) return true;
  return std::any_of(plan.nodes.begin(), plan.nodes.end(),
                     [&](const NodePlan& node) { return identifier == predefined::kEmergency + node.id; });
}

std::size_t bits_of(const PdoPlan& pdo) {
  std::size_t bits = 0;
  for (const auto& object : pdo.objects) bits += object.bits;
  return bits;
}

Refusal pdo_error(const MasterPlan& plan, PdoImageError facts, const PdoPlan& pdo) {
  facts.pdo = pdo.number;
  facts.bits = bits_of(pdo);
  facts.identifier = identifier_of(plan.nodes[facts.node], pdo, facts.output);
  if (facts.bits == 0) {
    facts.kind = PdoImageErrorKind::kNoMapping;
  } else if (facts.bits > kMostBits) {
    facts.kind = PdoImageErrorKind::kTooLong;
  } else if (facts.identifier == 0) {
    facts.kind = PdoImageErrorKind::kNoIdentifier;
  } else if (is_reserved(plan, facts.identifier)) {
    facts.kind = PdoImageErrorKind::kReserved;
  } else {
    return std::nullopt;
  }
  return facts;
}

/// A PDO that has the identifier of an earlier one.
Refusal same_identifier(std::map<std::uint16_t, PdoImageError>& taken, const PdoPlace& place, bool output) {
  PdoImageError facts{PdoImageErrorKind::kSameIdentifier, place.node, place.number, output, 0, place.identifier};
  const auto [found, added] = taken.emplace(place.identifier, facts);
  if (added) return std::nullopt;
  facts.other_node = found->second.node;
  facts.other_pdo = found->second.pdo;
  facts.other_output = found->second.output;
  return facts;
}

/// The mapping with a gap up to the end of its last byte, where the next PDO starts.
motion::PdoMapping whole_bytes(const PdoPlan& pdo, bool output) {
  motion::PdoMapping mapping;
  mapping.index = static_cast<std::uint16_t>((output ? kFirstRpdoMapping : kFirstTpdoMapping) + pdo.number - 1);
  mapping.objects = pdo.objects;
  if (const auto rest = bits_of(pdo) % 8; rest != 0) {
    mapping.objects.push_back({0, 0, static_cast<std::uint8_t>(8 - rest)});
  }
  return mapping;
}

std::string pdo_text(const MasterPlan& plan, std::size_t node, std::uint16_t pdo, bool output) {
  return fmt::format("{} {} of \"{}\"", output ? "RPDO" : "TPDO", pdo, plan.nodes[node].name);
}

}  // namespace

std::string describe(const PdoImageError& error, const MasterPlan& plan) {
  const auto& node = plan.nodes[error.node];
  const auto pdo = error.pdo == 0 ? std::string{} : pdo_text(plan, error.node, error.pdo, error.output);
  switch (error.kind) {
    case PdoImageErrorKind::kNodeId:
      return fmt::format("\"{}\" has the node-ID {}; there are 1 to {}", node.name, node.id, kMaxNodeId);
    case PdoImageErrorKind::kSameNode:
      if (error.other_node == error.node) {
        return fmt::format("\"{}\" has the node-ID {}, which is that of the master", node.name, node.id);
      }
      return fmt::format("\"{}\" and \"{}\" both have the node-ID {}", plan.nodes[error.other_node].name, node.name,
                         node.id);
    case PdoImageErrorKind::kNoMapping:
      return fmt::format("{} maps no object", pdo);
    case PdoImageErrorKind::kTooLong:
      return fmt::format("{} maps {} bits; a CAN frame has {}", pdo, error.bits, kMostBits);
    case PdoImageErrorKind::kNoIdentifier:
      return fmt::format("{} needs an identifier: the predefined connection set has those of PDO 1 to 4 only", pdo);
    case PdoImageErrorKind::kReserved:
      return fmt::format("{} has the identifier {:03X}h, which belongs to another service", pdo, error.identifier);
    case PdoImageErrorKind::kSameIdentifier:
      break;
  }
  return fmt::format("{} and {} have the same identifier {:03X}h",
                     pdo_text(plan, error.other_node, error.other_pdo, error.other_output), pdo, error.identifier);
}

tl::expected<PdoImage, PdoImageError> PdoImage::build(const MasterPlan& plan) {
  PdoImage image;
  std::map<std::uint16_t, PdoImageError> taken;
  for (std::size_t node = 0; node < plan.nodes.size(); ++node) {
    if (const auto error = node_id_error(plan, node)) return tl::unexpected(*error);
    auto& added = image.nodes_.emplace_back();
    added.place = {image.outputs_.size(), image.inputs_.size()};
    for (const bool output : {true, false}) {
      auto& bytes = output ? image.outputs_ : image.inputs_;
      auto& mappings = output ? added.configuration.outputs : added.configuration.inputs;
      for (const auto& pdo : output ? plan.nodes[node].rpdos : plan.nodes[node].tpdos) {
        PdoImageError facts;
        facts.node = node;
        facts.output = output;
        if (const auto error = pdo_error(plan, facts, pdo)) return tl::unexpected(*error);
        const PdoPlace place{node,
                             pdo.number,
                             identifier_of(plan.nodes[node], pdo, output),
                             static_cast<std::uint8_t>((bits_of(pdo) + 7) / 8),
                             bytes.size(),
                             pdo.exchange,
                             pdo.transmission,
                             pdo.resend};
        if (const auto error = same_identifier(taken, place, output)) return tl::unexpected(*error);
        mappings.push_back(whole_bytes(pdo, output));
        bytes.resize(bytes.size() + place.length);
        (output ? image.rpdos_ : image.tpdos_).push_back(place);
      }
    }
  }
  return image;
}

}  // namespace driveline::canopen

#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/canopen_master/node_plan.hpp"
#include "driveline/motion/cia301/image_place.hpp"
#include "driveline/motion/cia301/pdo_configuration.hpp"

namespace driveline::canopen {

/// A PDO of the line: its frame, and its bytes in the image.
struct PdoPlace {
  std::size_t node = 0;                           ///< place of its node in MasterPlan::nodes
  std::uint16_t number = 1;                       ///< PDO of the node, 1 to 512
  std::uint16_t identifier = 0;                   ///< base identifier of its frame
  std::uint8_t length = 0;                        ///< bytes of its frame, 1 to 8
  std::size_t offset = 0;                         ///< first byte in the image of its direction
  PdoExchange exchange = PdoExchange::kWithSync;  ///< when the PDO is due
  std::uint8_t transmission = 1;                  ///< transmission type of the node
  std::chrono::nanoseconds resend{0};             ///< RPDO on change: when unchanged content is sent again
  /// Whether an answer is due after each SYNC, for TPDOs: PdoExchange::kWithSync and transmission type 1. One of
  /// another type may leave SYNCs out, so that a lost PDO cannot be noticed.
  [[nodiscard]] bool answers_each_sync() const noexcept {
    return exchange == PdoExchange::kWithSync && transmission == 1;
  }
};

/// Why a plan has no image.
enum class PdoImageErrorKind : std::uint8_t {
  kNodeId,          ///< the node-ID is not 1 to 127
  kSameNode,        ///< two nodes have the node-ID, or the node has that of the master
  kNoMapping,       ///< the mapping of the PDO is not known
  kTooLong,         ///< the PDO has `bits` bits, more than the 64 of a frame
  kNoIdentifier,    ///< the plan has no identifier for the PDO, and the predefined connection set none for its number
  kReserved,        ///< the identifier is not one for PDOs, or that of SYNC, or that of the EMCY of a node
  kSameIdentifier,  ///< two PDOs have the identifier
};

/// A plan that has no image, with its facts. `describe()` makes the sentence.
struct PdoImageError {
  PdoImageErrorKind kind = PdoImageErrorKind::kNoMapping;  ///< what is wrong
  std::size_t node = 0;                                    ///< place of the node in MasterPlan::nodes
  std::uint16_t pdo = 0;                                   ///< number of the PDO; 0: it is not about one
  bool output = false;                                     ///< it is an RPDO
  std::size_t bits = 0;                                    ///< kTooLong
  std::uint16_t identifier = 0;                            ///< kReserved, kSameIdentifier
  std::size_t other_node = 0;                              ///< kSameNode, kSameIdentifier: the other one
  std::uint16_t other_pdo = 0;                             ///< kSameIdentifier; kSameNode: 0
  bool other_output = false;                               ///< kSameIdentifier: the other one is an RPDO
};

/// Returns one sentence with the names of the nodes. Not for use in a cycle.
[[nodiscard]] std::string describe(const PdoImageError& error, const MasterPlan& plan);

/// The process data of a line: the RPDOs of all nodes one behind the other (outputs), and their TPDOs (inputs), in the
/// order of the plan. Each PDO starts with a byte of its own; bits that its last byte has left are a gap in the
/// configuration of the node, so that motion::Axis finds the objects as they are in the image.
///
/// Once a CanCycle runs, the bytes belong to it.
class PdoImage {
 public:
  /// Lays out a plan in which every PDO has its mapping.
  [[nodiscard]] static tl::expected<PdoImage, PdoImageError> build(const MasterPlan& plan);

  /// Image of the outputs. \rtsafe
  [[nodiscard]] std::span<std::byte> outputs() noexcept { return outputs_; }
  /// Image of the outputs, read only. \rtsafe
  [[nodiscard]] std::span<const std::byte> outputs() const noexcept { return outputs_; }
  /// Image of the inputs. \rtsafe
  [[nodiscard]] std::span<std::byte> inputs() noexcept { return inputs_; }
  /// Image of the inputs, read only. \rtsafe
  [[nodiscard]] std::span<const std::byte> inputs() const noexcept { return inputs_; }
  /// All RPDOs, in the order of the image. \rtsafe
  [[nodiscard]] std::span<const PdoPlace> rpdos() const noexcept { return rpdos_; }
  /// All TPDOs, in the order of the image. \rtsafe
  [[nodiscard]] std::span<const PdoPlace> tpdos() const noexcept { return tpdos_; }
  /// Number of nodes. \rtsafe
  [[nodiscard]] std::size_t nodes() const noexcept { return nodes_.size(); }
  /// Where the process data of a node are; `node`: place in the plan. \rtsafe
  [[nodiscard]] const motion::ImagePlace& place(std::size_t node) const noexcept { return nodes_[node].place; }
  /// The PDOs of a node with their objects, as they lie in the image from place() on. \rtsafe
  [[nodiscard]] const motion::PdoConfiguration& configuration(std::size_t node) const noexcept {
    return nodes_[node].configuration;
  }

 private:
  struct Node {
    motion::ImagePlace place;
    motion::PdoConfiguration configuration;
  };
  PdoImage() = default;

  std::vector<std::byte> outputs_;
  std::vector<std::byte> inputs_;
  std::vector<PdoPlace> rpdos_;
  std::vector<PdoPlace> tpdos_;
  std::vector<Node> nodes_;
};

}  // namespace driveline::canopen

#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <tl/expected.hpp>
#include <variant>
#include <vector>

#include "driveline/wire/al.hpp"
#include "driveline/wire/coe.hpp"
#include "driveline/wire/soe.hpp"

namespace driveline::slaves {

/// Identifies an element that the master reads or writes.
struct SoeAccess {
  std::uint8_t drive = 0;                               ///< 0 to 7
  wire::Idn idn;                                        ///< number of the operation datum
  wire::SoeElement element = wire::SoeElement::kValue;  ///< element of the operation datum
  wire::AlState state = wire::AlState::kNone;           ///< AL state of the slave
};

/// A value, or the reason for the refusal.
template <typename T>
using SoeAnswer = tl::expected<T, wire::SoeError>;

/// Notification that a procedure command of a drive has changed its data state.
struct SoeCommandChange {
  wire::Idn idn;                  ///< the command
  wire::SoeCommandState state{};  ///< its data state
};

/// An unsolicited message of a drive.
struct SoeMessage {
  std::uint8_t drive = 0;                                   ///< 0 to 7
  std::variant<SoeCommandChange, wire::Emergency> content;  ///< notification or emergency
};

/// Operation data of a device that its SoE server transfers.
class SoeParameters {
 public:
  virtual ~SoeParameters() = default;
  /// Whether the device has a drive of this number.
  [[nodiscard]] virtual bool has_drive(std::uint8_t drive) const noexcept = 0;
  /// Returns the element as encoded in a mailbox message: lists, names and units follow their wire::SoeListHeader.
  [[nodiscard]] virtual SoeAnswer<std::vector<std::byte>> read_element(const SoeAccess& access) = 0;
  /// Writes an element, encoded as in a mailbox message. If refused, the element is unchanged.
  [[nodiscard]] virtual SoeAnswer<void> write_element(const SoeAccess& access, std::span<const std::byte> data) = 0;
  /// Removes and returns the next unsolicited message of the drives; nullopt when there is none.
  [[nodiscard]] virtual std::optional<SoeMessage> next_message() { return std::nullopt; }
};

}  // namespace driveline::slaves

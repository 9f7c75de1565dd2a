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

/// An element that the master reads or writes.
struct SoeAccess {
  std::uint8_t drive = 0;                               ///< 0 to 7
  wire::Idn idn;                                        ///< the operation datum
  wire::SoeElement element = wire::SoeElement::kValue;  ///< of it
  wire::AlState state = wire::AlState::kNone;           ///< of the slave
};

/// A value, or why the access is refused.
template <typename T>
using SoeAnswer = tl::expected<T, wire::SoeError>;

/// A procedure command of a drive has changed its data state.
struct SoeCommandChange {
  wire::Idn idn;                  ///< the command
  wire::SoeCommandState state{};  ///< its data state
};

/// What a drive says unasked.
struct SoeMessage {
  std::uint8_t drive = 0;                                   ///< 0 to 7
  std::variant<SoeCommandChange, wire::Emergency> content;  ///< notification or emergency
};

/// The operation data of a device, behind its SoE server.
class SoeParameters {
 public:
  virtual ~SoeParameters() = default;
  /// The device has a drive of this number.
  [[nodiscard]] virtual bool has_drive(std::uint8_t drive) const noexcept = 0;
  /// The element as it stands in a mail: lists, names and units behind their wire::SoeListHeader.
  [[nodiscard]] virtual SoeAnswer<std::vector<std::byte>> read_element(const SoeAccess& access) = 0;
  /// The element has arrived, as it stands in a mail. Refused: it is as it was before.
  [[nodiscard]] virtual SoeAnswer<void> write_element(const SoeAccess& access, std::span<const std::byte> data) = 0;
  /// What a drive has to say unasked, which is then said; nothing: nobody has.
  [[nodiscard]] virtual std::optional<SoeMessage> next_message() { return std::nullopt; }
};

}  // namespace driveline::slaves

#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "driveline/slaves/generic/device_model.hpp"
#include "edited_line.hpp"

namespace driveline::bus_test {

/// An object of a drive that cannot be read or written.
struct FixedObject {
  enum class Way : std::uint8_t { kRead, kWrite, kBoth };

  std::uint16_t index = 0;
  std::optional<std::uint8_t> subindex{};  ///< empty: every sub-index
  wire::SdoAbort code{};                   ///< answer of the drive
  Way way = Way::kWrite;
};

/// A line of one CiA 402 drive of an unknown maker, with the peculiarities of real drives: objects that are fixed or
/// missing, an EEPROM with errors, states that are refused at first.
///
/// Its PDOs: 1600h (6040h, 607Ah) and 1601h (60FFh) in sync manager 2, 1A00h (6041h, 6064h) and 1A01h (606Ch) in sync
/// manager 3; 1602h (6071h) is not assigned.
class FixedDrive {
 public:
  using EditDescription = std::function<void(esi::DeviceDescription& device)>;
  using EditEeprom = std::function<void(esi::SiiImage& image)>;

  explicit FixedDrive(std::vector<FixedObject> fixed = {}, const EditDescription& edit = {},
                      const EditEeprom& edit_eeprom = {});

  rt::VirtualClock clock{milliseconds{1}};
  [[nodiscard]] EditedDevice& device() noexcept { return *device_; }
  [[nodiscard]] slaves::Slave& slave() noexcept { return line_->slave(0); }
  [[nodiscard]] ecat_master::Master& master() noexcept { return *master_; }
  /// Scans and configures; the error as a sentence, empty: SAFEOP is reached.
  [[nodiscard]] std::string to_safe_op(const ecat_master::SlavePlan& plan);
  /// The notes of the start, as sentences.
  [[nodiscard]] std::vector<std::string> notes() const;
  /// The value of an entry, read by the master; empty: it cannot be read.
  [[nodiscard]] std::optional<std::uint32_t> value(std::uint16_t index, std::uint8_t subindex);
  /// SDO downloads that the drive received, as "60C2:01".
  std::vector<std::string> written;

 private:
  void take_request(std::span<std::byte> mailbox);
  [[nodiscard]] std::size_t answer(std::span<std::byte> out, std::size_t length);

  std::vector<FixedObject> fixed_;
  std::optional<std::vector<std::byte>> abort_;  ///< SDO abort that replaces the next answer
  EditedDevice* device_ = nullptr;
  std::unique_ptr<slaves::SimulatedLine> line_;
  std::unique_ptr<ecat_master::Master> master_;
};

/// A plan for that drive with these PDOs, with all their objects.
[[nodiscard]] ecat_master::SlavePlan plan_with(const std::vector<std::uint16_t>& outputs,
                                               const std::vector<std::uint16_t>& inputs);

}  // namespace driveline::bus_test

#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "driveline/ecat_master/mailbox/mailbox_client.hpp"
#include "driveline/ecat_master/soe/soe_transfer.hpp"

namespace driveline::ecat_master {

/// Timing of a procedure command.
struct SoeCommandSettings {
  std::chrono::nanoseconds limit = std::chrono::seconds{10};         ///< time limit for the command to end
  std::chrono::nanoseconds interval = std::chrono::milliseconds{5};  ///< interval between two reads of its data state
};

/// Operation data of the drives of a slave (SoE). Any ordinary thread; not \rtsafe. In PREOP and above. Errors of all
/// functions: SoeTransfer::result(), and SoeContent when an answer does not match the attribute.
class SoeClient {
 public:
  /// For the slave of this mailbox; its engine must outlive the client.
  explicit SoeClient(MailboxClient& mailbox) : engine_(mailbox.engine()), position_(mailbox.slave().position) {}
  /// For the slave at this position; its mailbox is open in `engine`.
  SoeClient(MailboxEngine& engine, std::uint16_t position) : engine_(engine), position_(position) {}

  /// Reads elements as raw data.
  [[nodiscard]] Result<SoeReading> read(facts::SoeDatum at, wire::SoeElementSet elements);
  /// Writes one element as raw data.
  [[nodiscard]] Result<void> write(facts::SoeDatum at, wire::SoeElement element, std::span<const std::byte> data);

  /// Reads the attribute, which describes the format of the value.
  [[nodiscard]] Result<wire::SoeAttribute> attribute(facts::SoeDatum at);
  /// Reads the name.
  [[nodiscard]] Result<std::string> name(facts::SoeDatum at);
  /// Reads the value; for a list, its content without header.
  [[nodiscard]] Result<std::vector<std::byte>> value(facts::SoeDatum at);
  /// Writes the value; for a list, its content without header.
  [[nodiscard]] Result<void> write_value(facts::SoeDatum at, std::span<const std::byte> value);
  /// Reads a list of IDNs, e.g. S-0-0017.
  [[nodiscard]] Result<std::vector<wire::Idn>> idn_list(facts::SoeDatum at);
  /// Reads everything about an operation datum, element by element; skips elements that the slave refuses, except the
  /// attribute.
  [[nodiscard]] Result<SoeParameter> parameter(facts::SoeDatum at);

  /// Executes a procedure command: sets and enables it, waits until it has ended, and cancels it, also after a failure.
  /// Errors also: SoeCommandEnded, SoeCommandTimeout.
  [[nodiscard]] Result<void> execute(facts::SoeDatum command, const SoeCommandSettings& settings = {});

  /// Starts a transfer; it proceeds while a thread waits for it or steps the engine.
  std::shared_ptr<SoeTransfer> start_read(facts::SoeDatum at, wire::SoeElementSet elements);
  /// Like start_read(), for writing.
  std::shared_ptr<SoeTransfer> start_write(facts::SoeDatum at, wire::SoeElement element, std::vector<std::byte> data);

 private:
  [[nodiscard]] Result<SoeParameter> read_apart(facts::SoeDatum at, wire::SoeElementSet elements,
                                                std::optional<wire::SoeAttribute> attribute);
  [[nodiscard]] Result<wire::SoeCommandState> await_end(facts::SoeDatum command, const SoeCommandSettings& settings);

  MailboxEngine& engine_;
  std::uint16_t position_;
};

}  // namespace driveline::ecat_master

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

/// Patience with a procedure command.
struct SoeCommandSettings {
  std::chrono::nanoseconds limit = std::chrono::seconds{10};         ///< until it is over
  std::chrono::nanoseconds interval = std::chrono::milliseconds{5};  ///< from one look at its data state to the next
};

/// Operation data of the drives of one slave (SoE). Any ordinary thread; not \rtsafe. In PREOP and above. Errors of all
/// functions: SoeTransfer::result(), and SoeContent when an answer is not what the attribute says.
class SoeClient {
 public:
  /// Client for the slave of this mailbox; its engine must outlive the client.
  explicit SoeClient(MailboxClient& mailbox) : engine_(mailbox.engine()), position_(mailbox.slave().position) {}
  /// Client for the slave at this position; its mailbox is open in `engine`.
  SoeClient(MailboxEngine& engine, std::uint16_t position) : engine_(engine), position_(position) {}

  /// Reads elements as they are.
  [[nodiscard]] Result<SoeReading> read(facts::SoeDatum at, wire::SoeElementSet elements);
  /// Writes one element as it is.
  [[nodiscard]] Result<void> write(facts::SoeDatum at, wire::SoeElement element, std::span<const std::byte> data);

  /// How the value is made up.
  [[nodiscard]] Result<wire::SoeAttribute> attribute(facts::SoeDatum at);
  /// Its name.
  [[nodiscard]] Result<std::string> name(facts::SoeDatum at);
  /// The value, of a list what is in it.
  [[nodiscard]] Result<std::vector<std::byte>> value(facts::SoeDatum at);
  /// Writes the value, of a list what is to be in it.
  [[nodiscard]] Result<void> write_value(facts::SoeDatum at, std::span<const std::byte> value);
  /// The IDNs of a list of them, e.g. S-0-0017.
  [[nodiscard]] Result<std::vector<wire::Idn>> idn_list(facts::SoeDatum at);
  /// Everything about an operation datum, element by element; those that the slave refuses are left out, all but the
  /// attribute.
  [[nodiscard]] Result<SoeParameter> parameter(facts::SoeDatum at);

  /// Executes a procedure command: sets and enables it, waits until it is over, and cancels it, also after a failure.
  /// Errors also: SoeCommandEnded, SoeCommandTimeout.
  [[nodiscard]] Result<void> execute(facts::SoeDatum command, const SoeCommandSettings& settings = {});

  /// Starts a transfer; it proceeds while a thread waits for it or steps the engine.
  std::shared_ptr<SoeTransfer> start_read(facts::SoeDatum at, wire::SoeElementSet elements);
  /// Like start_read(), in the other direction.
  std::shared_ptr<SoeTransfer> start_write(facts::SoeDatum at, wire::SoeElement element, std::vector<std::byte> data);

 private:
  [[nodiscard]] Result<SoeParameter> read_apart(facts::SoeDatum at, wire::SoeElementSet elements,
                                                std::optional<wire::SoeAttribute> attribute);
  [[nodiscard]] Result<wire::SoeCommandState> await_end(facts::SoeDatum command, const SoeCommandSettings& settings);

  MailboxEngine& engine_;
  std::uint16_t position_;
};

}  // namespace driveline::ecat_master

#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "driveline/ecat_master/error.hpp"
#include "driveline/ecat_master/mailbox/dialogue.hpp"
#include "driveline/ecat_master/soe/soe_parameter.hpp"
#include "driveline/wire/soe.hpp"

namespace driveline::ecat_master {

/// Transfers elements of an operation datum to or from a drive of a slave (SoE, ETG.1000.6 5.9). An answer that is too
/// long for the mailbox arrives in fragments, each with the number of fragments to come; this number must decrease by
/// one from fragment to fragment, each must have data, and drive and IDN of the answer must match the request.
class SoeTransfer final : public MailboxDialogue {
 public:
  /// Most bytes accepted in an answer: all elements with the longest lists.
  static constexpr std::size_t kLargest = std::size_t{6} << 16;

  /// Reads elements.
  SoeTransfer(facts::SoeDatum at, wire::SoeElementSet elements);
  /// Writes one element that fits into the mailbox; SoeClient handles longer ones and sends all fragments but the last
  /// in advance.
  SoeTransfer(facts::SoeDatum at, wire::SoeElement element, std::vector<std::byte> data, std::uint8_t priority = 0);

  /// After done(): the elements that were read (none after writing). Errors: SoeRefused, SoeOther, SoeFragments,
  /// Mailbox*, ProcessDataSize, those of the bus.
  [[nodiscard]] const Result<SoeReading>& result() const noexcept { return result_; }

  /// Removes all fragments but the last from the data to be written to the slave at `position`, and returns them as
  /// services for messages with `room` bytes; empty: the data fit into one message.
  [[nodiscard]] std::vector<std::vector<std::byte>> split(std::uint16_t position, std::size_t room);
  /// A fragment sent in advance has failed: nothing more is sent, and `error` is the result.
  void abandon(const Error& error);
  /// Whether the transfer has failed already.
  [[nodiscard]] bool failed() const noexcept { return !result_; }

  void begin(std::uint16_t position, MailboxRoom room) override;
  [[nodiscard]] std::span<const std::byte> outgoing() const noexcept override { return outgoing_; }
  /// A write is not: it may be the last fragment, or start a procedure command.
  [[nodiscard]] bool repeatable() const noexcept override { return !write_ && !left_; }
  [[nodiscard]] Reaction receive(std::span<const std::byte> service) override;
  void fail(const Error& error) override;

 private:
  [[nodiscard]] wire::SoeHeader header() const noexcept;
  [[nodiscard]] Reaction receive_part(const wire::SoeHeader& header, std::span<const std::byte> data);
  [[nodiscard]] Reaction receive_confirmation(const wire::SoeHeader& header);
  [[nodiscard]] Reaction receive_last(const wire::SoeHeader& header, std::span<const std::byte> data);
  [[nodiscard]] bool append(std::span<const std::byte> data);
  [[nodiscard]] Reaction end(const ErrorFacts& facts);

  facts::SoeDatum at_;
  wire::SoeElementSet elements_;
  bool write_;
  std::vector<std::byte> data_;    ///< data to be written, or read so far
  std::size_t ahead_ = 0;          ///< bytes of `data_` sent in advance
  std::size_t confirmations_ = 0;  ///< confirmations of fragments sent in advance that may still arrive
  Result<SoeReading> result_;
  bool unusable_ = false;  ///< an unusable answer has been received

  std::uint16_t position_ = Error::kNoSlave;
  std::vector<std::byte> outgoing_;
  std::optional<std::uint16_t> left_;  ///< number of fragments to come, according to the last one
};

}  // namespace driveline::ecat_master

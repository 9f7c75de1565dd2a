#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "driveline/canopen_client/client_error.hpp"
#include "driveline/canopen_wire/cob_id.hpp"
#include "driveline/canopen_wire/sdo.hpp"
#include "driveline/canopen_wire/sdo_block.hpp"

namespace driveline::canopen {

/// The data of a frame of an SDO.
using SdoBytes = std::array<std::byte, SdoMessage::kSize>;

/// Settings of the transfers with one node.
struct SdoOptions {
  std::chrono::nanoseconds answer_timeout = std::chrono::milliseconds{500};  ///< for each answer
  std::size_t max_bytes = std::size_t{64} << 20;  ///< most that an upload may have; more is refused when announced
  bool block = false;                             ///< block transfer; a node without it aborts with 05040001h
  std::uint8_t block_segments = 127;              ///< segments of a sub-block that is uploaded, 1 to 127
  unsigned repeats = 3;  ///< sub-blocks in a row of which the other side got nothing, before the transfer fails
  Identifier request{predefined::kSdoClientToServer};  ///< of requests, before the node-ID is added
  Identifier answer{predefined::kSdoServerToClient};   ///< of answers, before the node-ID is added
};

/// One SDO transfer of a client (CiA 301 7.2.4) as a state machine: the caller sends outgoing(), passes the answers on,
/// and tells the time. It waits for nobody, so a master can have one for each node beside its cycle.
///
/// The node may answer late, in wrong order, or not at all: every answer has its time-out, toggle bits, sizes, sequence
/// numbers and CRC are checked, and a transfer that fails on this side is ended with an abort. Answers that belong to
/// another transfer are ignored and counted.
class SdoTransfer {
 public:
  /// Reads an object: expedited or segmented, as the node decides, or as a block.
  [[nodiscard]] static std::unique_ptr<SdoTransfer> upload(std::uint8_t node, SdoObject object,
                                                           const SdoOptions& options = {});
  /// Writes an object: expedited up to four bytes, else segmented, or as a block.
  [[nodiscard]] static std::unique_ptr<SdoTransfer> download(std::uint8_t node, SdoObject object,
                                                             std::span<const std::byte> data,
                                                             const SdoOptions& options = {});
  virtual ~SdoTransfer() = default;
  SdoTransfer(const SdoTransfer&) = delete;
  SdoTransfer& operator=(const SdoTransfer&) = delete;

  /// What is to be sent next; empty: the transfer waits for an answer, or is done.
  [[nodiscard]] const std::optional<SdoBytes>& outgoing() const noexcept { return outgoing_; }
  /// outgoing() has been sent.
  void sent(std::chrono::nanoseconds now);
  /// A frame of the node's SDO server has arrived; `payload` is its data.
  void receive(std::span<const std::byte> payload);
  /// Time has passed: does what is due when deadline() has come.
  void advance(std::chrono::nanoseconds now);
  /// When the answer must have come; the largest value: nothing is waited for.
  [[nodiscard]] std::chrono::nanoseconds deadline() const noexcept { return deadline_; }
  /// Ends the transfer with an abort, which is still to be sent, and this error.
  void give_up(ClientErrorKind kind);
  /// Ends the transfer with the error of the bus, over which nothing can be sent any more.
  void fail(const ClientError& error);

  /// Whether there is a result and nothing more is to be sent.
  [[nodiscard]] bool done() const noexcept { return finished_ && !outgoing_; }
  /// After done(): the data of an upload, nothing of a download, or why there is none.
  [[nodiscard]] ClientResult<std::vector<std::byte>>& result() noexcept { return result_; }
  /// Whether the node owes an answer that may still come: the transfer ended by a time-out or by give_up().
  [[nodiscard]] bool abandoned() const noexcept { return abandoned_; }

 protected:
  /// A transfer of an object of a node, 1 to 127.
  SdoTransfer(std::uint8_t node, SdoObject object, const SdoOptions& options)
      : node_(node), object_(object), options_(options) {}

  /// An answer that is no abort.
  virtual void answered(const SdoBytes& in) = 0;
  /// outgoing() has been sent; the next frame may follow at once.
  virtual void continue_sending() {}
  /// No answer came; true: the transfer goes on with what it has queued.
  [[nodiscard]] virtual bool repeated() { return false; }

  /// Whether an initiate message is about the object of this transfer.
  [[nodiscard]] bool is_about_this(const SdoMessage& message) const noexcept {
    return message.index == object_.index && message.subindex == object_.subindex;
  }
  /// Sets the frame that is to be sent.
  void queue(const SdoBytes& out) { outgoing_ = out; }
  /// Sets a message about the object that is to be sent: its command, and a size, a value or an abort code.
  void queue(std::uint8_t command, std::uint32_t number = 0) {
    queue(SdoMessage{command, object_.index, object_.subindex, bytes::to_le_bytes(number)}.encode());
  }
  /// The answer to the initiate message has come.
  void initiated() noexcept { initiating_ = false; }
  /// Whether the answer to the initiate message has not come yet.
  [[nodiscard]] bool initiating() const noexcept { return initiating_; }
  /// Counts an answer that belongs to no request of this transfer.
  void ignore() noexcept { ++ignored_; }
  /// Ends the transfer with its result.
  void finish(std::vector<std::byte> data = {});
  /// Ends the transfer because of what the node has sent. `expected` and `received`: bytes, where it is about those.
  void refuse(SdoAbort code, std::size_t expected = 0, std::size_t received = 0);
  /// The same when the node has already finished, so that there is nothing to abort.
  void reject(SdoAbort code, std::size_t expected, std::size_t received);

  /// Time-outs and limits of the transfer.
  [[nodiscard]] const SdoOptions& options() const noexcept { return options_; }

 private:
  [[nodiscard]] ClientError error_of(ClientErrorKind kind) const;
  void end(const ClientError& error);

  std::uint8_t node_;
  SdoObject object_;
  SdoOptions options_;
  std::optional<SdoBytes> outgoing_;
  std::chrono::nanoseconds deadline_ = std::chrono::nanoseconds::max();
  ClientResult<std::vector<std::byte>> result_;
  std::uint32_t ignored_ = 0;
  bool initiating_ = true;
  bool finished_ = false;
  bool abandoned_ = false;
};

}  // namespace driveline::canopen

#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "driveline/canopen_client/sdo_transfer.hpp"

namespace driveline::canopen {

/// The SDO transfers of a master with one node, one after the other, as a state machine: the caller sends outgoing(),
/// passes the answers on, and tells the time. A request whose end is awaited may ask for more: what it adds goes
/// before what was there.
///
/// After a time-out the answer that may still come is waited for once more before the next request, because an answer
/// to the same object could not be told from the new one.
class SdoScript {
 public:
  /// Receives the result of a request: the data of an upload, nothing of a download, or why there is none.
  using Then = std::function<void(ClientResult<std::vector<std::byte>>& result)>;

  /// For a node, 1 to 127.
  SdoScript(std::uint8_t node, const SdoOptions& options) : node_(node), options_(options) {}

  /// Adds an upload.
  void read(SdoObject object, Then then) { add({object, std::nullopt, std::move(then)}); }
  /// Adds a download.
  void write(SdoObject object, std::vector<std::byte> data, Then then) {
    add({object, std::move(data), std::move(then)});
  }
  /// Adds something that is done between two transfers.
  void call(std::function<void()> function) { add({{}, std::nullopt, {}, std::move(function)}); }
  /// Forgets what was added and is not under way; the transfer under way ends without telling anybody.
  void clear();

  /// A request from outside the script, which runs before everything that was added: an upload, or a download of
  /// `data`.
  void ask(SdoObject object, std::optional<std::vector<std::byte>> data, Then then);
  /// The node has started anew: it will hardly answer what was asked before, so that nothing waits for that. Requests
  /// of ask() fail with kNoAnswer. A request that the node got after its start, before its boot-up message was seen
  /// here, is answered nevertheless, within the time of an answer: that does not count as unasked().
  void forget_node();

  /// Whether there is nothing to do; requests of ask() do not count.
  [[nodiscard]] bool idle() const noexcept { return steps_.empty() && (!transfer_ || asked_); }
  /// The frame that is to be sent next; empty: none.
  [[nodiscard]] std::optional<Frame> outgoing() const;
  /// outgoing() has been sent.
  void sent(std::chrono::nanoseconds now);
  /// outgoing() cannot be sent any more: the bus is gone.
  void fail(const ClientError& error);
  /// A frame has arrived. Returns whether it was one of this node's SDO server.
  bool receive(const Frame& frame, std::chrono::nanoseconds time);
  /// Time has passed: does what is due.
  void advance(std::chrono::nanoseconds now);
  /// Answers without a request, which come when two devices have the same node-ID.
  [[nodiscard]] std::uint64_t unasked() const noexcept { return unasked_; }

 private:
  struct Step {
    SdoObject object;
    std::optional<std::vector<std::byte>> data;
    Then then;
    std::function<void()> call{};
  };

  void add(Step step);
  void begin(std::chrono::nanoseconds now);
  void begin(Step step, bool asked);
  void finish(std::chrono::nanoseconds now);
  void collect(const std::function<void()>& run);
  [[nodiscard]] bool expected(const Frame& frame) const noexcept;

  std::uint8_t node_;
  SdoOptions options_;
  std::deque<Step> steps_;
  std::deque<Step> requests_;
  std::deque<Step> added_;  ///< while a step ends
  bool collecting_ = false;
  std::unique_ptr<SdoTransfer> transfer_;
  Then then_;
  bool asked_ = false;                                 ///< the transfer is one of ask()
  SdoObject object_{};                                 ///< object of the transfer
  SdoObject last_{};                                   ///< object of the previous transfer
  std::chrono::nanoseconds answer_until_{0};           ///< until then the last request may be answered
  std::chrono::nanoseconds old_answer_until_{0};       ///< until then an answer to an abandoned transfer may come
  std::chrono::nanoseconds forgotten_until_{0};        ///< the same, of what forget_node() has forgotten
  std::chrono::nanoseconds foreign_request_until_{0};  ///< until then an answer may be that to another client
  std::uint64_t unasked_ = 0;
};

}  // namespace driveline::canopen

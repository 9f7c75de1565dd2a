#pragma once

#include <functional>
#include <vector>

#include "driveline/ecat_master/mailbox/dialogue.hpp"
#include "driveline/wire/coe.hpp"

namespace driveline::ecat_master {

/// Object, sub-index and whether all sub-indices from there on are meant (complete access).
struct SdoAddress {
  std::uint16_t index = 0;    ///< of the object
  std::uint8_t subindex = 0;  ///< of the entry; 0 or 1 with complete access
  bool complete = false;      ///< complete access: all sub-indices from `subindex` on
};

/// One SDO upload or download (ETG.1000.6 5.6.2): expedited, normal and segmented, complete access both ways.
///
/// Nothing that the slave says about lengths is trusted: what is larger than kMaxObjectBytes, or more or less than
/// announced, is cut off with an abort. Answers about another object belong to a request that was given up before; they
/// are passed over.
class SdoTransfer : public MailboxDialogue {
 public:
  /// Largest object accepted; a slave that announces or sends more is cut off with an abort.
  static constexpr std::size_t kMaxObjectBytes = std::size_t{1} << 20;
  /// Told the result: the bytes of an upload, none of a download.
  using Callback = std::function<void(const Result<std::vector<std::byte>>&)>;

  /// Upload.
  explicit SdoTransfer(SdoAddress at, std::uint8_t priority = 0);
  /// Download of `data`.
  SdoTransfer(SdoAddress at, std::vector<std::byte> data, std::uint8_t priority = 0);

  /// Called once when the transfer is over, by the thread that has finished it; before it is submitted only.
  void on_completion(Callback callback) { callback_ = std::move(callback); }
  /// After done(): what was read (empty for a download), or why not. Errors: SdoAbort, Mailbox*
  /// and SdoSize, each with slave, index and sub-index; those of the bus, with slave and register.
  [[nodiscard]] const Result<std::vector<std::byte>>& result() const noexcept { return result_; }
  /// What is transferred.
  [[nodiscard]] const SdoAddress& address() const noexcept { return at_; }

  void begin(std::uint16_t position, MailboxRoom room) override;
  [[nodiscard]] std::span<const std::byte> outgoing() const noexcept override { return outgoing_; }
  [[nodiscard]] bool awaits_answer() const noexcept override { return phase_ != Phase::kAborting; }
  [[nodiscard]] Reaction receive(std::span<const std::byte> service) override;
  void fail(const Error& error) override;
  [[nodiscard]] bool takes_leave() override;
  void completed() override;

 private:
  enum class Phase : std::uint8_t { kInitiate, kSegments, kAborting };

  [[nodiscard]] Reaction receive_initiated(std::span<const std::byte> sdo);
  [[nodiscard]] Reaction receive_uploaded(const wire::SdoHeader& header, std::span<const std::byte> rest);
  [[nodiscard]] Reaction receive_segment(std::span<const std::byte> sdo);
  [[nodiscard]] Reaction receive_uploaded_segment(const wire::SdoSegmentHeader& segment,
                                                  std::span<const std::byte> data);
  [[nodiscard]] Reaction stray();
  [[nodiscard]] Reaction give_up(const Error& error, wire::SdoAbort code);
  void request_segment();
  void load(std::span<const std::byte> sdo);
  void load_abort(wire::SdoAbort code);
  [[nodiscard]] facts::ObjectAddress object() const noexcept;
  [[nodiscard]] Error size_error(std::size_t expected, std::size_t received) const noexcept;

  SdoAddress at_;
  bool download_;
  std::vector<std::byte> data_;  ///< download: what to write; upload: what has arrived
  Callback callback_;
  Result<std::vector<std::byte>> result_;

  Phase phase_ = Phase::kInitiate;
  std::uint16_t position_ = Error::kNoSlave;
  std::vector<std::byte> outgoing_;
  std::size_t max_sdo_ = 0;        ///< bytes that fit behind the CoE header
  std::size_t done_bytes_ = 0;     ///< download: sent
  std::size_t segment_bytes_ = 0;  ///< download: in the segment on its way
  std::size_t complete_size_ = 0;  ///< upload: announced
  bool toggle_ = false;
  bool stray_ = false;
};

}  // namespace driveline::ecat_master

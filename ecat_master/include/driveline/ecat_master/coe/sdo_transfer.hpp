#pragma once

#include <functional>
#include <vector>

#include "driveline/ecat_master/mailbox/dialogue.hpp"
#include "driveline/wire/coe.hpp"

namespace driveline::ecat_master {

/// Address of an SDO transfer: an object entry, or all sub-indices from there on (complete access).
struct SdoAddress {
  std::uint16_t index = 0;    ///< index of the object
  std::uint8_t subindex = 0;  ///< sub-index of the entry; 0 or 1 with complete access
  bool complete = false;      ///< complete access: all sub-indices from `subindex` on
};

/// An SDO upload or download (ETG.1000.6 5.6.2): expedited, normal and segmented, complete access in both directions.
///
/// Does not trust lengths reported by the slave: data larger than kMaxObjectBytes, or more or less than announced, end
/// the transfer with an abort. Answers about another object belong to an earlier, abandoned request; they are skipped.
class SdoTransfer : public MailboxDialogue {
 public:
  /// Largest object accepted, in bytes; a slave that announces or sends more gets an abort.
  static constexpr std::size_t kMaxObjectBytes = std::size_t{1} << 20;
  /// Receives the result: the bytes of an upload, none for a download.
  using Callback = std::function<void(const Result<std::vector<std::byte>>&)>;

  /// Creates an upload.
  explicit SdoTransfer(SdoAddress at, std::uint8_t priority = 0);
  /// Creates a download of `data`.
  SdoTransfer(SdoAddress at, std::vector<std::byte> data, std::uint8_t priority = 0);

  /// Sets a function that is called once when the transfer has ended, by the thread that ended it. Call before
  /// submitting.
  void on_completion(Callback callback) { callback_ = std::move(callback); }
  /// After done(): the uploaded data (empty for a download), or the error: SdoAbort, Mailbox* and SdoSize, each with
  /// slave, index and sub-index; those of the bus, with slave and register.
  [[nodiscard]] const Result<std::vector<std::byte>>& result() const noexcept { return result_; }
  /// The address of the transfer.
  [[nodiscard]] const SdoAddress& address() const noexcept { return at_; }

  void begin(std::uint16_t position, MailboxRoom room) override;
  [[nodiscard]] std::span<const std::byte> outgoing() const noexcept override { return outgoing_; }
  [[nodiscard]] bool awaits_answer() const noexcept override { return phase_ != Phase::kAborting; }
  /// A segment is not: with the toggle bit of the last one it would end the transfer.
  [[nodiscard]] bool repeatable() const noexcept override { return phase_ == Phase::kInitiate; }
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
  std::vector<std::byte> data_;  ///< download: data to write; upload: data received so far
  Callback callback_;
  Result<std::vector<std::byte>> result_;

  Phase phase_ = Phase::kInitiate;
  std::uint16_t position_ = Error::kNoSlave;
  std::vector<std::byte> outgoing_;
  std::size_t max_sdo_ = 0;        ///< bytes that fit behind the CoE header
  std::size_t done_bytes_ = 0;     ///< download: bytes sent
  std::size_t segment_bytes_ = 0;  ///< download: bytes of the segment in flight
  std::size_t complete_size_ = 0;  ///< upload: size announced by the slave
  bool toggle_ = false;
  bool stray_ = false;
};

}  // namespace driveline::ecat_master

#pragma once

#include <string>
#include <vector>

#include "driveline/bytes/endian.hpp"
#include "driveline/ecat_master/coe/sdo_information.hpp"
#include "driveline/ecat_master/coe/sdo_transfer.hpp"
#include "driveline/ecat_master/mailbox/mailbox_client.hpp"

namespace driveline::ecat_master {

/// The result of an SDO transfer in progress. May be copied; the engine must outlive it.
class SdoFuture {
 public:
  /// Created by CoeClient.
  SdoFuture(MailboxEngine& engine, std::shared_ptr<SdoTransfer> transfer)
      : engine_(&engine), transfer_(std::move(transfer)) {}
  /// Whether the transfer has ended, successfully or not; get() then does not wait.
  [[nodiscard]] bool ready() const noexcept { return transfer_->done(); }
  /// Waits for the end of the transfer, driving the engine meanwhile.
  void wait() const { engine_->wait(*transfer_); }
  /// Waits for the result. Errors: see SdoTransfer::result().
  [[nodiscard]] const Result<std::vector<std::byte>>& get() const {
    wait();
    return transfer_->result();
  }

 private:
  MailboxEngine* engine_;
  std::shared_ptr<SdoTransfer> transfer_;
};

/// SDO transfers with one slave (ETG.1000.6 5.6.2) in three styles: blocking calls, calls with a callback, and futures.
/// Simultaneous transfers with several slaves share frames. Any ordinary thread; not \rtsafe (the cycle uses
/// SdoRequest). Errors of all transfers: SdoAbort, Mailbox* and SdoSize, each with slave, index and sub-index; those of
/// the bus, with slave and register.
class CoeClient {
 public:
  /// Largest object accepted from a slave, in bytes.
  static constexpr std::size_t kMaxObjectBytes = SdoTransfer::kMaxObjectBytes;
  /// Called on the thread that serves the mailboxes when a transfer has ended.
  using Callback = SdoTransfer::Callback;

  /// For the slave of this mailbox, whose engine must outlive the client.
  explicit CoeClient(MailboxClient& mailbox) : engine_(mailbox.engine()), position_(mailbox.slave().position) {}
  /// For the slave at this position, whose mailbox is open in `engine`.
  CoeClient(MailboxEngine& engine, std::uint16_t position) : engine_(engine), position_(position) {}

  /// Reads an object entry. `complete` reads all sub-indices from `subindex` (0 or 1) on.
  [[nodiscard]] Result<std::vector<std::byte>> upload(std::uint16_t index, std::uint8_t subindex,
                                                      bool complete = false);
  /// Writes an object entry. `complete` writes all sub-indices from `subindex` (0 or 1) on.
  [[nodiscard]] Result<void> download(std::uint16_t index, std::uint8_t subindex, std::span<const std::byte> data,
                                      bool complete = false);

  /// Starts a transfer; the thread that waits for the future, or steps the engine, carries it out and calls `callback`
  /// (may be empty).
  SdoFuture start_upload(SdoAddress at, Callback callback = {}, std::uint8_t priority = 0);
  /// Like start_upload(), for a download; `data` is copied.
  SdoFuture start_download(SdoAddress at, std::span<const std::byte> data, Callback callback = {},
                           std::uint8_t priority = 0);

  template <bytes::Integer T>
  /// Uploads a number. Further error: SdoSize when its size differs.
  [[nodiscard]] Result<T> upload_as(std::uint16_t index, std::uint8_t subindex) {
    auto data = upload(index, subindex);
    if (!data) return tl::unexpected(data.error());
    if (data->size() != sizeof(T)) return tl::unexpected(size_error(index, subindex, sizeof(T), data->size()));
    return bytes::load_le<T>(*data);
  }
  template <bytes::Integer T>
  /// Downloads a number, little endian.
  [[nodiscard]] Result<void> download_as(std::uint16_t index, std::uint8_t subindex, T value) {
    return download(index, subindex, bytes::to_le_bytes(value));
  }

  /// \name SDO information (ETG.1000.6 5.6.3). Errors: SdoAbort with the slave's reason, Mailbox*, those of the bus.
  /// @{

  /// Indices of the objects in a list of the slave.
  [[nodiscard]] Result<std::vector<std::uint16_t>> object_list(ObjectList list = ObjectList::kAll);
  /// The slave's description of an object.
  [[nodiscard]] Result<ObjectDescription> object_description(std::uint16_t index);
  /// The slave's description of an entry of an object.
  [[nodiscard]] Result<EntryDescription> entry_description(std::uint16_t index, std::uint8_t subindex);
  /// @}

 private:
  [[nodiscard]] Result<std::vector<std::byte>> ask(const std::shared_ptr<SdoInformationQuery>& query);
  [[nodiscard]] Error size_error(std::uint16_t index, std::uint8_t subindex, std::size_t expected,
                                 std::size_t received) const noexcept;

  MailboxEngine& engine_;
  std::uint16_t position_;
};

}  // namespace driveline::ecat_master

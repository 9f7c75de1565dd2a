#pragma once

#include <string>
#include <vector>

#include "driveline/ecat_master/coe/sdo_information.hpp"
#include "driveline/ecat_master/coe/sdo_transfer.hpp"
#include "driveline/ecat_master/mailbox/mailbox_client.hpp"
#include "driveline/wire/endian.hpp"

namespace driveline::ecat_master {

/// The result of an SDO transfer that is still under way. May be copied; the engine must outlive it.
class SdoFuture {
 public:
  /// Made by CoeClient.
  SdoFuture(MailboxEngine& engine, std::shared_ptr<SdoTransfer> transfer)
      : engine_(&engine), transfer_(std::move(transfer)) {}
  /// The transfer is over, well or not; get() does not wait then.
  [[nodiscard]] bool ready() const noexcept { return transfer_->done(); }
  /// Waits, driving the engine meanwhile.
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

/// SDO transfers with one slave (ETG.1000.6 5.6.2) in three styles: calls that wait, calls with a callback, and
/// futures. Transfers with many slaves at the same time travel together. Any ordinary thread; not \rtsafe (the cycle
/// uses SdoRequest). Errors of all transfers: SdoAbort, Mailbox* and SdoSize, each with slave,
/// index and sub-index; those of the bus, with slave and register.
class CoeClient {
 public:
  /// Longest object that is taken from a slave.
  static constexpr std::size_t kMaxObjectBytes = SdoTransfer::kMaxObjectBytes;
  /// Called on the thread that serves the mailboxes when a transfer is over.
  using Callback = SdoTransfer::Callback;

  /// Of the slave of this mailbox, whose engine must outlive the client.
  explicit CoeClient(MailboxClient& mailbox) : engine_(mailbox.engine()), position_(mailbox.slave().position) {}
  /// Of the slave at this position, whose mailbox is open in `engine`.
  CoeClient(MailboxEngine& engine, std::uint16_t position) : engine_(engine), position_(position) {}

  /// Reads an object entry. `complete` reads all sub-indices from `subindex` (0 or 1) on.
  [[nodiscard]] Result<std::vector<std::byte>> upload(std::uint16_t index, std::uint8_t subindex,
                                                      bool complete = false);
  /// Writes an object entry. `complete` writes all sub-indices from `subindex` (0 or 1) on.
  [[nodiscard]] Result<void> download(std::uint16_t index, std::uint8_t subindex, std::span<const std::byte> data,
                                      bool complete = false);

  /// Starts a transfer; whoever waits for the future, or steps the engine, carries it out. `callback` (may be empty) is
  /// called by that thread.
  SdoFuture start_upload(SdoAddress at, Callback callback = {}, std::uint8_t priority = 0);
  /// Like start_upload(), in the other direction; `data` is copied.
  SdoFuture start_download(SdoAddress at, std::span<const std::byte> data, Callback callback = {},
                           std::uint8_t priority = 0);

  template <wire::WireInteger T>
  /// Uploads a number. Further error: SdoSize when it has another size.
  [[nodiscard]] Result<T> upload_as(std::uint16_t index, std::uint8_t subindex) {
    auto data = upload(index, subindex);
    if (!data) return tl::unexpected(data.error());
    if (data->size() != sizeof(T)) return tl::unexpected(size_error(index, subindex, sizeof(T), data->size()));
    return wire::load_le<T>(*data);
  }
  template <wire::WireInteger T>
  /// Downloads a number, little endian.
  [[nodiscard]] Result<void> download_as(std::uint16_t index, std::uint8_t subindex, T value) {
    return download(index, subindex, wire::to_le_bytes(value));
  }

  /// \name SDO information (ETG.1000.6 5.6.3). Errors: SdoAbort with the slave's reason, Mailbox*, those of the bus.
  /// @{

  /// Indices of the objects in a list of the slave, by SDO information.
  [[nodiscard]] Result<std::vector<std::uint16_t>> object_list(ObjectList list = ObjectList::kAll);
  /// What the slave says about an object.
  [[nodiscard]] Result<ObjectDescription> object_description(std::uint16_t index);
  /// What the slave says about an entry of an object.
  [[nodiscard]] Result<EntryDescription> entry_description(std::uint16_t index, std::uint8_t subindex);
  /// @}

 private:
  [[nodiscard]] Result<std::vector<std::byte>> ask(const std::shared_ptr<SdoInformationQuery>& query);
  [[nodiscard]] Error size_error(std::uint16_t index, std::uint8_t subindex, std::size_t expected,
                                 std::size_t received) const noexcept;

  MailboxEngine& engine_;
  std::uint16_t position_;
};

/// Values to be written to objects of one slave, in this order.
struct SdoScript {
  std::uint16_t position = 0;  ///< of the slave
  /// One value and where it goes.
  struct Step {
    SdoAddress at;                ///< object and entry
    std::vector<std::byte> data;  ///< to be written

    /// `value` in the byte order of the wire.
    template <typename T>
    static Step of(std::uint16_t index, std::uint8_t subindex, T value) {
      const auto bytes = wire::to_le_bytes(value);
      return {{index, subindex, false}, {bytes.begin(), bytes.end()}};
    }
  };
  std::vector<Step> steps;  ///< in their order
};

/// Writes the scripts of many slaves at the same time: each slave's in order, all slaves side by side. A script ends at
/// its first failure, the others go on. Returns one result per script.
[[nodiscard]] std::vector<Result<void>> run_scripts(MailboxEngine& engine, std::span<const SdoScript> scripts);

}  // namespace driveline::ecat_master

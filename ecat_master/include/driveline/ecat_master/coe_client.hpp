#pragma once

#include <string>
#include <vector>

#include "driveline/ecat_master/mailbox_client.hpp"

namespace driveline::ecat_master {

/// SDO transfers with one slave (ETG.1000.6 5.6.2): expedited, normal and segmented. Not real-time safe; one thread
/// at a time. Errors of all transfers: kSdoAbort (code: abort code), kMailbox* and kSdoSize, each with slave, index and
/// sub-index; those of the bus, with slave and register.
class CoeClient {
 public:
  /// Largest object accepted; a slave that announces or sends more is cut off with an abort.
  static constexpr std::size_t kMaxObjectBytes = std::size_t{1} << 20;

  explicit CoeClient(MailboxClient& mailbox) : mailbox_(mailbox) {}

  /// Reads an object entry. `complete` reads all sub-indices from `subindex` (0 or 1) on.
  [[nodiscard]] Result<std::vector<std::byte>> upload(std::uint16_t index, std::uint8_t subindex,
                                                      bool complete = false);
  /// Writes an object entry. `complete` writes all sub-indices from `subindex` (0 or 1) on.
  [[nodiscard]] Result<void> download(std::uint16_t index, std::uint8_t subindex, std::span<const std::byte> data,
                                      bool complete = false);

  template <wire::WireInteger T>
  [[nodiscard]] Result<T> upload_as(std::uint16_t index, std::uint8_t subindex) {
    auto data = upload(index, subindex);
    if (!data) return tl::unexpected(data.error());
    if (data->size() != sizeof(T)) return tl::unexpected(size_error(index, subindex, sizeof(T), data->size()));
    return wire::load_le<T>(*data);
  }
  template <wire::WireInteger T>
  [[nodiscard]] Result<void> download_as(std::uint16_t index, std::uint8_t subindex, T value) {
    return download(index, subindex, wire::to_le_bytes(value));
  }

 private:
  struct Address {
    std::uint16_t index;
    std::uint8_t subindex;
  };
  [[nodiscard]] Result<std::vector<std::byte>> transact(Address at, std::span<const std::byte> sdo);
  [[nodiscard]] Result<void> upload_segments(Address at, std::vector<std::byte>& data, std::size_t complete_size);
  [[nodiscard]] Result<void> download_segments(Address at, std::span<const std::byte> rest);
  void abort(Address at, wire::SdoAbort code);
  [[nodiscard]] Error size_error(std::uint16_t index, std::uint8_t subindex, std::size_t expected,
                                 std::size_t received) const noexcept;
  [[nodiscard]] Error malformed(Address at) const noexcept;

  MailboxClient& mailbox_;
};

}  // namespace driveline::ecat_master

#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "driveline/slaves/mailbox/file_store.hpp"
#include "driveline/slaves/mailbox/mailbox_server.hpp"

namespace driveline::slaves {

/// Files over EtherCAT of a device (ETG.1000.6 5.8): one transfer at a time; a new request ends an unfinished one,
/// which leaves the file as it was.
class FoeServer final : public MailboxProtocol {
 public:
  /// `files` must outlive this.
  explicit FoeServer(FileStore& files) noexcept : files_(&files) {}

  /// FoE, type 4.
  [[nodiscard]] wire::MailboxType type() const noexcept override { return wire::MailboxType::kFoe; }
  [[nodiscard]] tl::expected<std::size_t, wire::MailboxErrorCode> request(const MailboxRequest& request,
                                                                          std::span<std::byte> out) override;
  [[nodiscard]] std::size_t unsolicited(std::span<std::byte> /*out*/) override { return 0; }
  void stop() noexcept override;

 private:
  enum class Phase : std::uint8_t {
    kReading,
    kWriting,
    kKeeping,  ///< the last packet has come and is repeated until the device has kept the file
  };
  /// A file on its way. Its memory is that of a transfer, not of a drive.
  struct Transfer {
    Phase phase = Phase::kReading;
    std::string name{};
    std::uint32_t password = 0;
    wire::AlState state = wire::AlState::kNone;  ///< as of the last mail
    std::vector<std::byte> content{};
    std::size_t sent = 0;      ///< reading: bytes, the packet on its way included
    std::size_t limit = 0;     ///< writing: most bytes
    std::uint32_t packet = 0;  ///< the last one that was sent, or taken
    bool last = false;         ///< reading: it was the last one

    /// The name is valid as long as the transfer.
    [[nodiscard]] FileRequest file() const noexcept { return {name, password, state}; }
  };

  [[nodiscard]] std::size_t start_reading(const FileRequest& file, std::span<std::byte> out);
  [[nodiscard]] std::size_t start_writing(const FileRequest& file, std::span<std::byte> out);
  [[nodiscard]] std::size_t acknowledged(std::uint32_t number, std::span<std::byte> out);
  [[nodiscard]] std::size_t take_data(std::uint32_t number, std::span<const std::byte> data, std::size_t room,
                                      std::span<std::byte> out);
  [[nodiscard]] std::size_t keep(std::span<std::byte> out);
  [[nodiscard]] std::size_t send_packet(std::span<std::byte> out);
  [[nodiscard]] std::size_t refuse(const FileRefusal& refusal, std::span<std::byte> out);
  [[nodiscard]] bool in(Phase phase) const noexcept { return transfer_ != nullptr && transfer_->phase == phase; }

  FileStore* files_;
  std::unique_ptr<Transfer> transfer_;  ///< null: none
};

}  // namespace driveline::slaves

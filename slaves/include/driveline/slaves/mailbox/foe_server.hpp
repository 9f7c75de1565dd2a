#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "driveline/slaves/mailbox/file_store.hpp"
#include "driveline/slaves/mailbox/mailbox_server.hpp"

namespace driveline::slaves {

/// File access over EtherCAT server of a device (ETG.1000.6 5.8): one transfer at a time; a new request aborts an
/// unfinished transfer, which leaves the file unchanged.
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
    kKeeping,  ///< the master repeats the last packet until the device has stored the file
  };
  /// A transfer in progress. Allocated per transfer, so that an idle device needs no memory for it.
  struct Transfer {
    Phase phase = Phase::kReading;
    std::string name{};
    std::uint32_t password = 0;
    wire::AlState state = wire::AlState::kNone;  ///< as of the last mailbox message
    std::vector<std::byte> content{};
    std::size_t sent = 0;      ///< reading: bytes, including the packet in flight
    std::size_t limit = 0;     ///< writing: maximum size in bytes
    std::uint32_t packet = 0;  ///< number of the last packet that was sent or received
    bool last = false;         ///< reading: `packet` is the last one of the file

    /// The name is valid for the life of the transfer.
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

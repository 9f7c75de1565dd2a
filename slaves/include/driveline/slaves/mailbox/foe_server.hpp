#pragma once

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
    kIdle,
    kReading,
    kWriting,
    kKeeping,  ///< the last packet has come and is repeated until the device has kept the file
  };

  [[nodiscard]] std::size_t start_reading(std::span<std::byte> out);
  [[nodiscard]] std::size_t start_writing(std::span<std::byte> out);
  [[nodiscard]] std::size_t acknowledged(std::uint32_t number, std::span<std::byte> out);
  [[nodiscard]] std::size_t take_data(std::uint32_t number, std::span<const std::byte> data, std::size_t room,
                                      std::span<std::byte> out);
  [[nodiscard]] std::size_t keep(std::span<std::byte> out);
  [[nodiscard]] std::size_t send_packet(std::span<std::byte> out);
  [[nodiscard]] std::size_t refuse(const FileRefusal& refusal, std::span<std::byte> out);
  [[nodiscard]] FileRequest file() const noexcept { return {name_, password_, state_}; }

  FileStore* files_;
  Phase phase_ = Phase::kIdle;
  std::string name_;
  std::uint32_t password_ = 0;
  wire::AlState state_ = wire::AlState::kNone;
  std::vector<std::byte> content_;
  std::size_t sent_ = 0;      ///< reading: bytes, the packet on its way included
  std::size_t limit_ = 0;     ///< writing: most bytes
  std::uint32_t packet_ = 0;  ///< the last one that was sent, or taken
  bool last_ = false;         ///< reading: it was the last one
};

}  // namespace driveline::slaves

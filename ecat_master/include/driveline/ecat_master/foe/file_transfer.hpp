#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <vector>

#include "driveline/ecat_master/mailbox/dialogue.hpp"
#include "driveline/wire/foe.hpp"

namespace driveline::ecat_master {

/// A file of a slave.
struct FileName {
  std::string name;            ///< name of the file in the slave
  std::uint32_t password = 0;  ///< 0: none
};

/// Time limits and size limit of a file transfer.
struct FileSettings {
  std::chrono::nanoseconds timeout =
      std::chrono::seconds{10};  ///< time-out of each answer; slaves may erase memory before answering
  /// First pause before a busy slave is asked again; doubled each time the slave is still busy.
  std::chrono::nanoseconds first_pause = std::chrono::milliseconds{5};
  std::chrono::nanoseconds longest_pause = std::chrono::milliseconds{500};  ///< upper limit of the pause
  std::chrono::nanoseconds busy_limit =
      std::chrono::minutes{2};                  ///< largest sum of pauses without progress; then the transfer fails
  std::size_t largest = std::size_t{64} << 20;  ///< largest accepted file, bytes
};

/// A file transfer to or from a slave (FoE, ETG.1000.6 5.8). Packets are numbered from 1, in 32 bits; a packet shorter
/// than the mailbox allows is the last, so a file that fills its packets ends with an empty packet.
///
/// Ignores repeated packets and answers to an abandoned transfer; any other unexpected packet number ends the transfer
/// with an error to the slave.
class FileTransfer final : public MailboxDialogue {
 public:
  /// Reads a file.
  explicit FileTransfer(FileName file, const FileSettings& settings = {});
  /// Writes `content` to a file.
  FileTransfer(FileName file, std::vector<std::byte> content, const FileSettings& settings = {});

  /// After done(): the content that was read (empty after writing). Errors: FileRefused, FilePacket, FileSize,
  /// FileBusy, Mailbox*, ProcessDataSize (the name is longer than the mailbox), those of the bus.
  [[nodiscard]] const Result<std::vector<std::byte>>& result() const noexcept { return result_; }
  /// After done(): the text of the slave's error; may be empty.
  [[nodiscard]] const std::string& slave_text() const noexcept { return slave_text_; }
  /// Bytes transferred so far; when writing, only acknowledged bytes. Any thread. \rtsafe
  [[nodiscard]] std::size_t transferred() const noexcept { return transferred_.load(std::memory_order_relaxed); }
  /// Size of the file in bytes when writing; 0 when reading.
  [[nodiscard]] std::size_t size() const noexcept { return write_ ? size_ : 0; }

  void begin(std::uint16_t position, MailboxRoom room) override;
  [[nodiscard]] std::span<const std::byte> outgoing() const noexcept override { return outgoing_; }
  [[nodiscard]] bool awaits_answer() const noexcept override { return !last_word_; }
  [[nodiscard]] std::optional<std::chrono::nanoseconds> timeout() const noexcept override { return settings_.timeout; }
  [[nodiscard]] std::chrono::nanoseconds pause() const noexcept override { return pause_; }
  [[nodiscard]] Reaction receive(std::span<const std::byte> service) override;
  void fail(const Error& error) override;
  [[nodiscard]] bool takes_leave() override;

 private:
  [[nodiscard]] Reaction receive_ack(std::uint32_t number);
  [[nodiscard]] Reaction receive_data(std::uint32_t number, std::span<const std::byte> data);
  [[nodiscard]] Reaction receive_busy();
  [[nodiscard]] Reaction receive_error(std::uint32_t code, std::span<const std::byte> text);
  [[nodiscard]] Reaction stray();
  [[nodiscard]] Reaction give_up(const Error& error, wire::FoeError code);
  [[nodiscard]] Reaction wrong_packet(std::uint32_t number);
  void load(wire::FoeOpCode op_code, std::uint32_t value, std::span<const std::byte> data = {});
  void load_packet();

  FileName file_;
  bool write_;
  FileSettings settings_;
  std::vector<std::byte> content_;  ///< data to be written, or read so far
  std::size_t size_ = 0;
  Result<std::vector<std::byte>> result_;
  std::string slave_text_;
  std::atomic<std::size_t> transferred_{0};

  std::uint16_t position_ = Error::kNoSlave;
  std::vector<std::byte> outgoing_;
  std::size_t out_room_ = 0;      ///< data bytes that fit into a packet to the slave
  std::size_t in_room_ = 0;       ///< data bytes that fit into a packet from the slave
  std::uint32_t packet_ = 0;      ///< number of the packet whose acknowledgement or data is expected
  std::size_t packet_bytes_ = 0;  ///< data bytes of the packet in flight
  bool last_packet_ = false;      ///< the packet in flight is the last one
  bool last_word_ = false;        ///< outgoing() is the final message of the dialogue
  bool stray_ = false;            ///< an unusable answer has been received
  std::chrono::nanoseconds pause_{0};
  std::chrono::nanoseconds paused_{0};  ///< sum of the pauses since the slave's last progress
};

}  // namespace driveline::ecat_master

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "driveline/ecat_master/foe/file_transfer.hpp"
#include "driveline/ecat_master/mailbox/mailbox_client.hpp"

namespace driveline::ecat_master {

/// Why a file could not be transferred.
struct FileFailure {
  Error error;             ///< the error
  std::string slave_text;  ///< the slave's text of the error; may be empty
};

/// A value, or the failure of the transfer.
template <typename T>
using FileResult = tl::expected<T, FileFailure>;

/// The failure as one sentence, followed by the slave's text.
[[nodiscard]] std::string describe(const FileFailure& failure);

/// File transfers to and from a slave (FoE). Any ordinary thread; not \rtsafe. In BOOT, PREOP and above, depending on
/// the slave.
class FoeClient {
 public:
  /// For the slave of this mailbox; its engine must outlive the client.
  explicit FoeClient(MailboxClient& mailbox) : engine_(mailbox.engine()), position_(mailbox.slave().position) {}
  /// For the slave at this position; its mailbox is open in `engine`.
  FoeClient(MailboxEngine& engine, std::uint16_t position) : engine_(engine), position_(position) {}

  /// Reads a file and waits for the end. Errors: see FileTransfer::result().
  [[nodiscard]] FileResult<std::vector<std::byte>> read(const FileName& file, const FileSettings& settings = {});
  /// Writes a file and waits until the slave has accepted it. Errors: see FileTransfer::result().
  [[nodiscard]] FileResult<void> write(const FileName& file, std::vector<std::byte> content,
                                       const FileSettings& settings = {});

  /// Starts a transfer; it proceeds while a thread waits for it or steps the engine.
  std::shared_ptr<FileTransfer> start_read(const FileName& file, const FileSettings& settings = {});
  /// Like start_read(), for writing.
  std::shared_ptr<FileTransfer> start_write(const FileName& file, std::vector<std::byte> content,
                                            const FileSettings& settings = {});

 private:
  MailboxEngine& engine_;
  std::uint16_t position_;
};

/// The result of a finished transfer.
[[nodiscard]] FileResult<std::vector<std::byte>> result_of(const FileTransfer& transfer);

}  // namespace driveline::ecat_master

#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "driveline/ecat_master/error.hpp"
#include "driveline/ecat_master/mailbox/mailbox_engine.hpp"

namespace driveline::ecat_master {

/// An SDO transfer with a slave that the cycle requests and the mailbox engine executes: the cycle starts it, polls
/// state() in later cycles and reads the value when it is available. Created by make_request().
///
/// The ownership of the buffers follows the state: they belong to the cycle except in kPending and kBusy. Only one
/// thread (the cycle) uses start_*(), data() and error().
class SdoRequest final : public DialogueRequest, public std::enable_shared_from_this<SdoRequest> {
 public:
  /// State of the request.
  enum class State : std::uint8_t {
    kIdle,     ///< never started
    kPending,  ///< started, not yet seen by the engine
    kBusy,     ///< transfer in progress
    kDone,     ///< data() holds the uploaded value, or the value has been downloaded
    kFailed,   ///< error() holds the reason
  };

  /// For objects of at most `capacity` bytes; allocates all memory in advance.
  SdoRequest(std::uint16_t position, std::uint16_t index, std::uint8_t subindex, std::size_t capacity);
  SdoRequest(const SdoRequest&) = delete;
  SdoRequest& operator=(const SdoRequest&) = delete;

  /// Starts an upload. Returns false when a transfer is in progress. \rtsafe
  [[nodiscard]] bool start_upload() noexcept;
  /// Starts a download. Returns false when a transfer is in progress or `data` is longer than the capacity. \rtsafe
  [[nodiscard]] bool start_download(std::span<const std::byte> data) noexcept;
  /// State of the current or last transfer. \rtsafe
  [[nodiscard]] State state() const noexcept { return state_.load(std::memory_order_acquire); }
  /// The value read by the last upload; empty unless state() is kDone. \rtsafe
  [[nodiscard]] std::span<const std::byte> data() const noexcept;
  /// Why the last transfer failed: errors of SdoTransfer, and SdoSize when the value is longer than the capacity.
  /// \rtsafe
  [[nodiscard]] const Error& error() const noexcept { return error_; }

  // Used by the engine.
  [[nodiscard]] std::uint16_t position() const noexcept override { return position_; }
  /// The transfer that executes the request.
  [[nodiscard]] std::shared_ptr<MailboxDialogue> take() override;

 private:
  void finish(const Result<std::vector<std::byte>>& result) noexcept;

  std::uint16_t position_;
  std::uint16_t index_;
  std::uint8_t subindex_;
  bool download_ = false;
  std::size_t used_ = 0;
  std::vector<std::byte> buffer_;
  Error error_;
  std::atomic<State> state_{State::kIdle};
};

/// Creates an SDO request for the slave at `position`, executed by `engine`. `capacity`: largest size of its value in
/// bytes. Any ordinary thread.
[[nodiscard]] std::shared_ptr<SdoRequest> make_request(MailboxEngine& engine, std::uint16_t position,
                                                       std::uint16_t index, std::uint8_t subindex,
                                                       std::size_t capacity);

}  // namespace driveline::ecat_master

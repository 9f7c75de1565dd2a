#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "driveline/ecat_master/error.hpp"
#include "driveline/ecat_master/mailbox/mailbox_engine.hpp"

namespace driveline::ecat_master {

/// One SDO of one slave, asked for by the cycle and carried out by the mailbox engine: the cycle starts it, looks at
/// state() in later cycles and reads the value when it is there. Made by make_request().
///
/// The buffers change hands with the state: they belong to the cycle but in kPending and kBusy. One thread (the cycle)
/// uses start_*(), data() and error().
class SdoRequest final : public DialogueRequest, public std::enable_shared_from_this<SdoRequest> {
 public:
  /// Where the request is.
  enum class State : std::uint8_t {
    kIdle,     ///< never started
    kPending,  ///< started, not seen by the engine yet
    kBusy,     ///< on its way
    kDone,     ///< data() holds the value read, or the value has been written
    kFailed,   ///< error() tells why
  };

  /// For objects of at most `capacity` bytes; allocates all that it will need.
  SdoRequest(std::uint16_t position, std::uint16_t index, std::uint8_t subindex, std::size_t capacity);
  SdoRequest(const SdoRequest&) = delete;
  SdoRequest& operator=(const SdoRequest&) = delete;

  /// Starts an upload. False: one is under way. \rtsafe
  [[nodiscard]] bool start_upload() noexcept;
  /// Starts a download. False: one is under way, or `data` is longer than the capacity. \rtsafe
  [[nodiscard]] bool start_download(std::span<const std::byte> data) noexcept;
  /// \rtsafe
  [[nodiscard]] State state() const noexcept { return state_.load(std::memory_order_acquire); }
  /// What the last upload has read; empty unless state() is kDone. \rtsafe
  [[nodiscard]] std::span<const std::byte> data() const noexcept;
  /// Why the last transfer failed: as for SdoTransfer, and SdoSize when the value is longer than the capacity. \rtsafe
  [[nodiscard]] const Error& error() const noexcept { return error_; }

  // The engine's side.
  [[nodiscard]] std::uint16_t position() const noexcept override { return position_; }
  /// The transfer that carries it out.
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

/// An SDO of the slave at `position` that the cycle may ask for, looked after by `engine`. `capacity`: most bytes of
/// its value. Any ordinary thread.
[[nodiscard]] std::shared_ptr<SdoRequest> make_request(MailboxEngine& engine, std::uint16_t position,
                                                       std::uint16_t index, std::uint8_t subindex,
                                                       std::size_t capacity);

}  // namespace driveline::ecat_master

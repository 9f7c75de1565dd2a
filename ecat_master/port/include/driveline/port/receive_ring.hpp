#pragma once

#include <cstddef>
#include <ctime>
#include <optional>
#include <span>

namespace driveline::port {

/// The receive queue of a packet socket as memory that the kernel fills and this process reads (packet(7),
/// PACKET_RX_RING, version 2): checking for a frame is a load instead of a system call. 256 KiB for 128 frames; when
/// all slots are full, the kernel drops arriving frames.
///
/// May be destroyed before or after its socket is closed: the memory lives as long as either. One thread at a time.
class ReceiveRing {
 public:
  /// A frame that has arrived.
  struct Frame {
    std::span<const std::byte> bytes;  ///< in the ring; valid until the next take() or release()
    std::size_t length =
        0;  ///< length of the frame on the wire, in bytes; longer than `bytes` if the frame did not fit
    std::timespec arrival{};  ///< CLOCK_REALTIME at which the kernel received it
  };

  /// Gives the packet socket a ring; empty if the kernel cannot provide one, the socket is then unchanged. Call it
  /// before the socket is bound, or frames that have arrived are lost.
  [[nodiscard]] static std::optional<ReceiveRing> map(int socket) noexcept;

  /// `other` has no ring afterwards and may only be destroyed.
  ReceiveRing(ReceiveRing&& other) noexcept;
  ReceiveRing(const ReceiveRing&) = delete;
  ReceiveRing& operator=(const ReceiveRing&) = delete;
  ReceiveRing& operator=(ReceiveRing&&) = delete;
  ~ReceiveRing();

  /// Returns the oldest frame, if there is one, and gives the previously taken frame back to the kernel. \rtsafe
  [[nodiscard]] std::optional<Frame> take() noexcept;

  /// Gives the frame taken last back to the kernel: until then poll() reports the socket as readable. \rtsafe
  void release() noexcept;

 private:
  explicit ReceiveRing(std::byte* memory) noexcept;

  std::byte* memory_;
  std::size_t next_ = 0;       ///< slot of the next frame
  std::byte* held_ = nullptr;  ///< slot of the frame taken last; null: none
};

}  // namespace driveline::port

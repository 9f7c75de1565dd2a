#pragma once

#include <cstddef>
#include <ctime>
#include <optional>
#include <span>

namespace driveline::port {

/// The receive queue of a packet socket as memory that the kernel fills and this process reads (packet(7),
/// PACKET_RX_RING, version 2): looking for a frame is a load instead of a system call. 256 KiB for 128 frames; when all
/// are full the kernel drops what arrives.
///
/// Destroy it before its socket is closed or after: the memory lives as long as either. One thread at a time.
class ReceiveRing {
 public:
  /// A frame that has arrived.
  struct Frame {
    std::span<const std::byte> bytes;  ///< in the ring, until the next take() or release()
    std::size_t length = 0;            ///< of the frame on the wire; longer than `bytes` if it did not fit
    std::timespec arrival{};           ///< CLOCK_REALTIME when the kernel got it
  };

  /// Gives the packet socket a ring; nothing if the kernel has none to give, and then the socket is as before. Before
  /// the socket is bound, or frames that have arrived are lost.
  [[nodiscard]] static std::optional<ReceiveRing> map(int socket) noexcept;

  /// `other` has none afterwards, and may only be destroyed.
  ReceiveRing(ReceiveRing&& other) noexcept;
  ReceiveRing(const ReceiveRing&) = delete;
  ReceiveRing& operator=(const ReceiveRing&) = delete;
  ReceiveRing& operator=(ReceiveRing&&) = delete;
  ~ReceiveRing();

  /// The oldest frame, if there is one; gives the one taken before back to the kernel. \rtsafe
  [[nodiscard]] std::optional<Frame> take() noexcept;

  /// Gives the frame taken last back to the kernel: until then poll() finds the socket readable. \rtsafe
  void release() noexcept;

 private:
  explicit ReceiveRing(std::byte* memory) noexcept;

  std::byte* memory_;
  std::size_t next_ = 0;       ///< slot of the next frame
  std::byte* held_ = nullptr;  ///< slot taken last
};

}  // namespace driveline::port

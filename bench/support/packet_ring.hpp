#pragma once

#include <cstddef>
#include <span>

namespace driveline::bench {

/// The bare receive ring of a packet socket (packet(7), PACKET_RX_RING, version 2), for the bare loops that
/// port::ReceiveRing is compared with.
class PacketRing {
 public:
  /// Gives `socket` a ring, before it is bound. Throws std::runtime_error if the kernel has none.
  explicit PacketRing(int socket);
  PacketRing(const PacketRing&) = delete;
  PacketRing& operator=(const PacketRing&) = delete;
  ~PacketRing();

  /// Copies the oldest frame into `buffer`, as recv() does, and returns its slot; false: none has come in.
  bool take_into(std::span<std::byte> buffer) noexcept;
  /// Drops the oldest frame; false: there is none.
  bool discard() noexcept;

 private:
  std::byte* memory_ = nullptr;
  unsigned slot_ = 0;
};

}  // namespace driveline::bench

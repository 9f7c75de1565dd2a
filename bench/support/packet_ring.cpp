#include "support/packet_ring.hpp"

#include <linux/if_packet.h>
#include <sys/mman.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace driveline::bench {
namespace {

constexpr unsigned kRingSlotBytes = 2048;
constexpr unsigned kRingBlockBytes = 1U << 16;
constexpr unsigned kRingBlocks = 2;
constexpr unsigned kRingSlots = kRingBlockBytes / kRingSlotBytes * kRingBlocks;
constexpr std::size_t kRingBytes = std::size_t{kRingBlockBytes} * kRingBlocks;

tpacket2_hdr* header_at(std::byte* memory, unsigned slot) noexcept {
  return reinterpret_cast<tpacket2_hdr*>(memory + std::size_t{slot} * kRingSlotBytes);
}

bool is_full(const tpacket2_hdr* header) noexcept {
  return (__atomic_load_n(&header->tp_status, __ATOMIC_ACQUIRE) & TP_STATUS_USER) != 0;
}

}  // namespace

PacketRing::PacketRing(int socket) {
  const int version = TPACKET_V2;
  setsockopt(socket, SOL_PACKET, PACKET_VERSION, &version, sizeof version);
  tpacket_req request{};
  request.tp_block_size = kRingBlockBytes;
  request.tp_block_nr = kRingBlocks;
  request.tp_frame_size = kRingSlotBytes;
  request.tp_frame_nr = kRingSlots;
  if (setsockopt(socket, SOL_PACKET, PACKET_RX_RING, &request, sizeof request) != 0) {
    throw std::runtime_error("no receive ring");
  }
  void* memory = mmap(nullptr, kRingBytes, PROT_READ | PROT_WRITE, MAP_SHARED, socket, 0);
  if (memory == MAP_FAILED) throw std::runtime_error("the receive ring cannot be mapped");
  memory_ = static_cast<std::byte*>(memory);
}

PacketRing::~PacketRing() {
  munmap(memory_, kRingBytes);
}

bool PacketRing::take_into(std::span<std::byte> buffer) noexcept {
  const auto* header = header_at(memory_, slot_);
  if (!is_full(header)) return false;
  std::memcpy(buffer.data(), reinterpret_cast<const std::byte*>(header) + header->tp_mac,
              std::min<std::size_t>(header->tp_snaplen, buffer.size()));
  return discard();
}

bool PacketRing::discard() noexcept {
  auto* header = header_at(memory_, slot_);
  if (!is_full(header)) return false;
  __atomic_store_n(&header->tp_status, __u32{TP_STATUS_KERNEL}, __ATOMIC_RELEASE);
  slot_ = (slot_ + 1) % kRingSlots;
  return true;
}

}  // namespace driveline::bench

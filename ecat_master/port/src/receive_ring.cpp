#include "driveline/port/receive_ring.hpp"

#include <linux/if_packet.h>
#include <sys/mman.h>
#include <sys/socket.h>

#include <algorithm>
#include <atomic>
#include <utility>

namespace driveline::port {

namespace {

constexpr std::size_t kSlotBytes = 2048;  // the kernel's header and the longest frame, rounded up to a power of two
constexpr std::size_t kBlockBytes =
    16 * 1024;  // contiguous pages: larger blocks are harder to allocate on a machine with a long uptime
constexpr std::size_t kSlots = 128;  // frames that may wait between two polls
constexpr std::size_t kRingBytes = kSlots * kSlotBytes;

/// The kernel's header at the start of a slot; the only casts of this class.
tpacket2_hdr& header_of(std::byte* slot) noexcept {
  return *reinterpret_cast<tpacket2_hdr*>(slot);
}

std::atomic_ref<__u32> status_of(std::byte* slot) noexcept {
  return std::atomic_ref<__u32>(header_of(slot).tp_status);
}

}  // namespace

std::optional<ReceiveRing> ReceiveRing::map(int socket) noexcept {
  const int version = TPACKET_V2;
  if (setsockopt(socket, SOL_PACKET, PACKET_VERSION, &version, sizeof version) != 0) return std::nullopt;
  tpacket_req request{};
  request.tp_block_size = kBlockBytes;
  request.tp_block_nr = kRingBytes / kBlockBytes;
  request.tp_frame_size = kSlotBytes;
  request.tp_frame_nr = kSlots;
  if (setsockopt(socket, SOL_PACKET, PACKET_RX_RING, &request, sizeof request) != 0) return std::nullopt;
  void* memory = mmap(nullptr, kRingBytes, PROT_READ | PROT_WRITE, MAP_SHARED, socket, 0);
  if (memory != MAP_FAILED) return ReceiveRing(static_cast<std::byte*>(memory));
  // Removes the ring, so that the socket queues frames itself again.
  request = {};
  static_cast<void>(setsockopt(socket, SOL_PACKET, PACKET_RX_RING, &request, sizeof request));
  return std::nullopt;
}

ReceiveRing::ReceiveRing(std::byte* memory) noexcept : memory_{memory} {}

ReceiveRing::ReceiveRing(ReceiveRing&& other) noexcept
    : memory_{std::exchange(other.memory_, nullptr)}, next_{other.next_}, held_{std::exchange(other.held_, nullptr)} {}

ReceiveRing::~ReceiveRing() {
  if (memory_ != nullptr) munmap(memory_, kRingBytes);
}

std::optional<ReceiveRing::Frame> ReceiveRing::take() noexcept {
  release();
  std::byte* const slot = memory_ + next_ * kSlotBytes;
  if ((status_of(slot).load(std::memory_order_acquire) & TP_STATUS_USER) == 0) return std::nullopt;
  held_ = slot;
  next_ = (next_ + 1) % kSlots;
  const tpacket2_hdr& header = header_of(slot);
  // Limit to the slot whatever the header says: the kernel truncates a frame that does not fit and reports its true
  // length.
  const std::size_t begin = std::min<std::size_t>(header.tp_mac, kSlotBytes);
  const std::size_t there = std::min<std::size_t>(header.tp_snaplen, kSlotBytes - begin);
  Frame frame{{slot + begin, there}, header.tp_len, {}};
  frame.arrival.tv_sec = static_cast<std::time_t>(header.tp_sec);
  frame.arrival.tv_nsec = static_cast<decltype(frame.arrival.tv_nsec)>(header.tp_nsec);
  return frame;
}

void ReceiveRing::release() noexcept {
  if (held_ == nullptr) return;
  status_of(held_).store(TP_STATUS_KERNEL, std::memory_order_release);
  held_ = nullptr;
}

}  // namespace driveline::port

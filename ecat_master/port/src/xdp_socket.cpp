#include "xdp_socket.hpp"

#include <linux/if_xdp.h>
#include <sys/mman.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <thread>

namespace driveline::port {

namespace {

constexpr std::uint32_t kQueueSlots = XdpSocket::kReceiveFrames;  // slots of each queue; a power of two
constexpr std::size_t kFrameMemoryBytes =
    std::size_t{XdpSocket::kReceiveFrames + XdpSocket::kSendFrames} * XdpSocket::kFrameBytes;

bool set_size(int socket, int option, std::uint32_t slots) noexcept {
  return setsockopt(socket, SOL_XDP, option, &slots, sizeof slots) == 0;
}

/// `we_produce`: this side writes the producer index.
bool map_queue(int socket, const xdp_ring_offset& where, std::uint64_t page, std::size_t entry_bytes, bool we_produce,
               XdpQueue& queue) noexcept {
  const std::size_t size = where.desc + kQueueSlots * entry_bytes;
  void* memory =
      mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, socket, static_cast<off_t>(page));
  if (memory == MAP_FAILED) return false;
  auto* const begin = static_cast<std::byte*>(memory);
  queue.mapping = XdpMapping(begin, size);
  const auto index_at = [begin](std::uint64_t offset) { return reinterpret_cast<std::uint32_t*>(begin + offset); };
  queue.ours = index_at(we_produce ? where.producer : where.consumer);
  queue.theirs = index_at(we_produce ? where.consumer : where.producer);
  queue.flags = index_at(where.flags);
  queue.entries = begin + where.desc;
  queue.mine = *queue.ours;
  return true;
}

xdp_desc& descriptor_of(const XdpQueue& queue, std::uint32_t number) noexcept {
  return reinterpret_cast<xdp_desc*>(queue.entries)[number % kQueueSlots];
}

std::uint64_t& address_of(const XdpQueue& queue, std::uint32_t number) noexcept {
  return reinterpret_cast<std::uint64_t*>(queue.entries)[number % kQueueSlots];
}

bool wants_call(const XdpQueue& queue) noexcept {
  auto& flags = const_cast<std::uint32_t&>(*queue.flags);
  return (std::atomic_ref<std::uint32_t>(flags).load(std::memory_order_relaxed) & XDP_RING_NEED_WAKEUP) != 0;
}

/// Retries for three seconds: the kernel frees the queue of a closed socket later, when its work queues get to it.
bool bind_patiently(int socket, const sockaddr_xdp& address) noexcept {
  for (int attempt = 0;; ++attempt) {
    if (bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return true;
    if (errno != EBUSY || attempt == 300) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds{10});
  }
}

}  // namespace

XdpMapping::~XdpMapping() {
  if (memory_ != nullptr) munmap(memory_, size_);
}

tl::expected<XdpSocket, XdpRefusal> XdpSocket::open(int interface_index, bool zero_copy) {
  const auto refused = [](XdpRefusal::Step step) { return tl::unexpected(XdpRefusal{step, errno}); };
  XdpSocket result;
  result.socket_ = rt::FileDescriptor{::socket(AF_XDP, SOCK_RAW | SOCK_CLOEXEC, 0)};
  if (!result.socket_.valid()) return refused(XdpRefusal::Step::kSocket);
  const int socket = result.socket_.get();

  void* memory =
      mmap(nullptr, kFrameMemoryBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  if (memory == MAP_FAILED) return refused(XdpRefusal::Step::kMemory);
  result.frames_ = XdpMapping(static_cast<std::byte*>(memory), kFrameMemoryBytes);
  xdp_umem_reg region{};
  region.addr = reinterpret_cast<std::uintptr_t>(memory);
  region.len = kFrameMemoryBytes;
  region.chunk_size = kFrameBytes;
  if (setsockopt(socket, SOL_XDP, XDP_UMEM_REG, &region, sizeof region) != 0) return refused(XdpRefusal::Step::kMemory);
  if (!result.map_queues()) return refused(XdpRefusal::Step::kMemory);

  for (std::uint32_t i = 0; i < kReceiveFrames; ++i) result.give(std::uint64_t{i} * kFrameBytes);
  for (std::uint32_t i = 0; i < kSendFrames; ++i) {
    result.free_[result.free_count_++] = std::uint64_t{kReceiveFrames + i} * kFrameBytes;
  }

  sockaddr_xdp address{};
  address.sxdp_family = AF_XDP;
  address.sxdp_ifindex = static_cast<std::uint32_t>(interface_index);
  address.sxdp_queue_id = 0;
  address.sxdp_flags = static_cast<std::uint16_t>((zero_copy ? XDP_ZEROCOPY : XDP_COPY) | XDP_USE_NEED_WAKEUP);
  if (!bind_patiently(socket, address)) return refused(XdpRefusal::Step::kBind);
  result.zero_copy_ = zero_copy;
  return result;
}

bool XdpSocket::map_queues() noexcept {
  const int socket = socket_.get();
  for (const int option : {XDP_UMEM_FILL_RING, XDP_UMEM_COMPLETION_RING, XDP_RX_RING, XDP_TX_RING}) {
    if (!set_size(socket, option, kQueueSlots)) return false;
  }
  xdp_mmap_offsets offsets{};
  socklen_t size = sizeof offsets;
  if (getsockopt(socket, SOL_XDP, XDP_MMAP_OFFSETS, &offsets, &size) != 0) return false;
  constexpr std::size_t kAddress = sizeof(std::uint64_t);
  return map_queue(socket, offsets.fr, XDP_UMEM_PGOFF_FILL_RING, kAddress, true, fill_) &&
         map_queue(socket, offsets.cr, XDP_UMEM_PGOFF_COMPLETION_RING, kAddress, false, completed_) &&
         map_queue(socket, offsets.rx, XDP_PGOFF_RX_RING, sizeof(xdp_desc), false, received_) &&
         map_queue(socket, offsets.tx, XDP_PGOFF_TX_RING, sizeof(xdp_desc), true, sending_);
}

/// Gives the frame memory at this address to the kernel to receive into.
void XdpSocket::give(std::uint64_t address) noexcept {
  address_of(fill_, fill_.mine) = address;
  fill_.advance();
}

std::byte* XdpSocket::frame_at(std::uint64_t address) const noexcept {
  return frames_.data() + address;
}

std::optional<std::span<std::byte>> XdpSocket::take() noexcept {
  if (held_) {
    // Return the start of the frame memory, wherever in it the packet started.
    give(*held_ / kFrameBytes * kFrameBytes);
    held_.reset();
    if (zero_copy_ && wants_call(fill_)) {
      static_cast<void>(recvfrom(socket_.get(), nullptr, 0, MSG_DONTWAIT, nullptr, nullptr));
    }
  }
  if (received_.other() == received_.mine) return std::nullopt;
  const auto descriptor = descriptor_of(received_, received_.mine);
  received_.advance();
  // Limit to the memory whatever the kernel says.
  const std::uint64_t address = std::min<std::uint64_t>(descriptor.addr, kFrameMemoryBytes - kFrameBytes);
  const std::size_t room = kFrameBytes - address % kFrameBytes;
  held_ = address;
  return std::span{frame_at(address), std::min<std::size_t>(descriptor.len, room)};
}

/// Takes back the memory of frames that were sent.
void XdpSocket::reclaim() noexcept {
  const std::uint32_t there = completed_.other();
  while (completed_.mine != there && free_count_ < free_.size()) {
    free_[free_count_++] = address_of(completed_, completed_.mine);
    completed_.advance();
  }
}

int XdpSocket::send(std::span<const std::byte> frame) noexcept {
  reclaim();
  // A poll() may have sent it in the meantime. The kernel's index sometimes lags by one, but never leads.
  if (refused_ && static_cast<std::int32_t>(sending_.other() - *refused_) > 0) refused_.reset();
  if (refused_) {
    // The kernel checks this entry again on the next call and then finds this frame instead of the old one.
    auto& waiting = descriptor_of(sending_, *refused_);
    std::copy(frame.begin(), frame.end(), frame_at(waiting.addr));
    waiting.len = static_cast<std::uint32_t>(frame.size());
  } else {
    if (free_count_ == 0) return EAGAIN;
    const std::uint64_t address = free_[--free_count_];
    std::copy(frame.begin(), frame.end(), frame_at(address));
    descriptor_of(sending_, sending_.mine) = {address, static_cast<std::uint32_t>(frame.size()), 0};
    sending_.advance();
    if (zero_copy_ && !wants_call(sending_)) return 0;
  }
  if (sendto(socket_.get(), nullptr, 0, MSG_DONTWAIT, nullptr, 0) >= 0) {
    refused_.reset();
    return 0;
  }
  const int error_number = errno;
  // In copy mode the kernel takes the frame in this call or not at all; EBUSY means that it took the frame and dropped
  // it. With zero copy the driver takes the frame at any later time.
  refused_.reset();
  if (!zero_copy_ && error_number != EBUSY) refused_ = sending_.mine - 1;
  return zero_copy_ && error_number == EAGAIN ? 0 : error_number;
}

}  // namespace driveline::port

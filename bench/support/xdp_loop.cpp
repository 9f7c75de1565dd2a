#include "support/xdp_loop.hpp"

#include <linux/if_xdp.h>
#include <net/if.h>
#include <sys/mman.h>
#include <sys/socket.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <thread>

namespace driveline::bench {
namespace {

constexpr std::uint32_t kSlots = 64;  // of each queue
constexpr std::uint32_t kFrameBytes = 2048;
constexpr std::uint32_t kFrames = 64;
constexpr std::size_t kMemoryBytes = std::size_t{kFrames} * kFrameBytes;
/// Address of the frame for sending; all other frames are for receiving.
constexpr std::uint64_t kSendAddress = std::uint64_t{kFrames - 1} * kFrameBytes;

[[noreturn]] void fail(const char* what) {
  throw std::runtime_error(std::string("AF_XDP: ") + what + ": " + std::strerror(errno));
}

/// Retries for three seconds: the kernel frees the queue of a closed socket later, when its work queues get to it.
void bind_patiently(int socket, const sockaddr_xdp& address) {
  constexpr int kAttempts = 300;
  for (int attempt = 0; bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0; ++attempt) {
    if (errno != EBUSY || attempt == kAttempts) fail("cannot bind");
    std::this_thread::sleep_for(std::chrono::milliseconds{10});
  }
}

std::uint32_t look(const std::uint32_t* index) noexcept {
  return __atomic_load_n(index, __ATOMIC_ACQUIRE);
}

void step(std::uint32_t* index) noexcept {
  __atomic_store_n(index, *index + 1, __ATOMIC_RELEASE);
}

}  // namespace

XdpLoop::XdpLoop(const std::string& interface) : socket_(::socket(AF_XDP, SOCK_RAW | SOCK_CLOEXEC, 0)) {
  if (!socket_.valid()) fail("no socket");
  void* memory = mmap(nullptr, kMemoryBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  if (memory == MAP_FAILED) fail("no memory");
  frames_ = static_cast<std::byte*>(memory);
  xdp_umem_reg region{};
  region.addr = reinterpret_cast<std::uintptr_t>(memory);
  region.len = kMemoryBytes;
  region.chunk_size = kFrameBytes;
  if (setsockopt(socket_.get(), SOL_XDP, XDP_UMEM_REG, &region, sizeof region) != 0) fail("its memory is refused");
  map(XDP_UMEM_FILL_RING, XDP_UMEM_PGOFF_FILL_RING, sizeof(std::uint64_t), fill_);
  map(XDP_UMEM_COMPLETION_RING, XDP_UMEM_PGOFF_COMPLETION_RING, sizeof(std::uint64_t), completed_);
  map(XDP_RX_RING, XDP_PGOFF_RX_RING, sizeof(xdp_desc), received_);
  map(XDP_TX_RING, XDP_PGOFF_TX_RING, sizeof(xdp_desc), sending_);
  for (std::uint64_t frame = 0; frame + 1 < kFrames; ++frame) give(frame * kFrameBytes);
  sockaddr_xdp address{};
  address.sxdp_family = AF_XDP;
  address.sxdp_ifindex = if_nametoindex(interface.c_str());
  address.sxdp_flags = XDP_COPY | XDP_USE_NEED_WAKEUP;
  bind_patiently(socket_.get(), address);
  auto program = port::XdpProgram::attach(static_cast<int>(address.sxdp_ifindex), socket_.get(), false);
  if (!program) {
    errno = program.error().error_number;
    fail("its program is refused");
  }
  program_.emplace(std::move(*program));
}

XdpLoop::~XdpLoop() {
  for (const auto& queue : {fill_, completed_, received_, sending_}) munmap(queue.memory, queue.bytes);
  munmap(frames_, kMemoryBytes);
}

void XdpLoop::map(int option, std::uint64_t page, std::size_t entry_bytes, Queue& queue) {
  if (setsockopt(socket_.get(), SOL_XDP, option, &kSlots, sizeof kSlots) != 0) fail("a queue is refused");
  xdp_mmap_offsets offsets{};
  socklen_t size = sizeof offsets;
  if (getsockopt(socket_.get(), SOL_XDP, XDP_MMAP_OFFSETS, &offsets, &size) != 0)
    fail("the offsets of its queues cannot be read");
  const auto& where = option == XDP_UMEM_FILL_RING         ? offsets.fr
                      : option == XDP_UMEM_COMPLETION_RING ? offsets.cr
                      : option == XDP_RX_RING              ? offsets.rx
                                                           : offsets.tx;
  queue.bytes = where.desc + kSlots * entry_bytes;
  void* memory = mmap(nullptr, queue.bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, socket_.get(),
                      static_cast<off_t>(page));
  if (memory == MAP_FAILED) fail("a queue cannot be mapped");
  queue.memory = static_cast<std::byte*>(memory);
  queue.producer = reinterpret_cast<std::uint32_t*>(queue.memory + where.producer);
  queue.consumer = reinterpret_cast<std::uint32_t*>(queue.memory + where.consumer);
  queue.entries = queue.memory + where.desc;
}

void XdpLoop::give(std::uint64_t address) noexcept {
  reinterpret_cast<std::uint64_t*>(fill_.entries)[*fill_.producer % kSlots] = address;
  step(fill_.producer);
}

bool XdpLoop::send(std::span<const std::byte> frame) noexcept {
  while (look(completed_.producer) != *completed_.consumer) step(completed_.consumer);
  std::memcpy(frames_ + kSendAddress, frame.data(), frame.size());
  reinterpret_cast<xdp_desc*>(sending_.entries)[*sending_.producer % kSlots] = {
      kSendAddress, static_cast<std::uint32_t>(frame.size()), 0};
  step(sending_.producer);
  return sendto(socket_.get(), nullptr, 0, MSG_DONTWAIT, nullptr, 0) >= 0;
}

std::optional<std::span<const std::byte>> XdpLoop::take() noexcept {
  if (held_) give(*held_ / kFrameBytes * kFrameBytes);
  held_.reset();
  if (look(received_.producer) == *received_.consumer) return std::nullopt;
  const auto descriptor = reinterpret_cast<const xdp_desc*>(received_.entries)[*received_.consumer % kSlots];
  step(received_.consumer);
  held_ = descriptor.addr;
  return std::span<const std::byte>(frames_ + descriptor.addr, descriptor.len);
}

}  // namespace driveline::bench

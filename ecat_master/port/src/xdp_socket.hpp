#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <tl/expected.hpp>
#include <utility>

#include "driveline/rt/file_descriptor.hpp"
#include "xdp_program.hpp"

namespace driveline::port {

/// Owns mapped memory and unmaps it on destruction.
class XdpMapping {
 public:
  XdpMapping() = default;
  XdpMapping(std::byte* memory, std::size_t size) noexcept : memory_(memory), size_(size) {}
  XdpMapping(XdpMapping&& other) noexcept : memory_(std::exchange(other.memory_, nullptr)), size_(other.size_) {}
  XdpMapping& operator=(XdpMapping&& other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~XdpMapping();

  [[nodiscard]] std::byte* data() const noexcept { return memory_; }

 private:
  std::byte* memory_ = nullptr;
  std::size_t size_ = 0;
};

/// One of the four queues of an AF_XDP socket, in memory shared with the kernel. It has two indices that only grow;
/// each side writes one of them. This side stores a copy of its own index, so that no write by the kernel can corrupt
/// it.
struct XdpQueue {
  XdpMapping mapping;
  std::uint32_t* ours = nullptr;         ///< index that this side writes
  std::uint32_t* theirs = nullptr;       ///< index that the kernel writes
  const std::uint32_t* flags = nullptr;  ///< whether the kernel needs a system call to continue
  std::byte* entries = nullptr;
  std::uint32_t mine = 0;  ///< copy of `*ours`

  [[nodiscard]] std::uint32_t other() const noexcept {
    return std::atomic_ref<std::uint32_t>(*theirs).load(std::memory_order_acquire);
  }
  /// Tells the kernel that one more entry was written or read.
  void advance() noexcept { std::atomic_ref<std::uint32_t>(*ours).store(++mine, std::memory_order_release); }
};

/// An AF_XDP socket with its memory: 128 frames to receive into, 64 to send from. 390 KiB, locked by the kernel.
/// One thread at a time.
class XdpSocket {
 public:
  static constexpr std::uint32_t kFrameBytes = 2048;
  static constexpr std::uint32_t kReceiveFrames = 128;
  static constexpr std::uint32_t kSendFrames = 64;

  /// Opens a socket bound to queue 0 of an interface. `zero_copy`: refused (kBind) if the driver does not support it;
  /// else frames are copied.
  [[nodiscard]] static tl::expected<XdpSocket, XdpRefusal> open(int interface_index, bool zero_copy);

  [[nodiscard]] int descriptor() const noexcept { return socket_.get(); }
  [[nodiscard]] bool zero_copy() const noexcept { return zero_copy_; }

  /// Returns the oldest frame, if there is one, and gives the previously taken frame back to the kernel. \rtsafe
  [[nodiscard]] std::optional<std::span<std::byte>> take() noexcept;

  /// Sends a frame of at most kFrameBytes. Returns 0 or errno; EAGAIN also when all frames are in flight. A refused
  /// frame stays in the queue until the next frame replaces it: if the interface works again before that, poll() may
  /// send it (with zero copy the driver may send it at any time). \rtsafe
  [[nodiscard]] int send(std::span<const std::byte> frame) noexcept;

 private:
  XdpSocket() = default;
  [[nodiscard]] bool map_queues() noexcept;
  void give(std::uint64_t address) noexcept;
  void reclaim() noexcept;
  [[nodiscard]] std::byte* frame_at(std::uint64_t address) const noexcept;

  rt::FileDescriptor socket_;
  bool zero_copy_ = false;
  XdpMapping frames_;
  XdpQueue fill_;
  XdpQueue completed_;
  XdpQueue received_;
  XdpQueue sending_;
  std::optional<std::uint64_t> held_;  ///< address of the frame taken last
  std::array<std::uint64_t, kSendFrames> free_{};
  std::size_t free_count_ = 0;
  std::optional<std::uint32_t> refused_;  ///< index of an entry of `sending_` that the kernel has refused
};

}  // namespace driveline::port

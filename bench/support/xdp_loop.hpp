#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "driveline/rt/file_descriptor.hpp"
#include "xdp_program.hpp"

namespace driveline::bench {

/// A bare loop on an AF_XDP socket in copy mode, like XdpPort without driver support: one frame in flight at a time,
/// two frames of memory for receiving. The XDP program at the interface is that of the port, because its set-up is not
/// measured.
class XdpLoop {
 public:
  /// On queue 0 of `interface`, in native mode. Throws std::runtime_error.
  explicit XdpLoop(const std::string& interface);
  XdpLoop(const XdpLoop&) = delete;
  XdpLoop& operator=(const XdpLoop&) = delete;
  ~XdpLoop();

  /// False: the kernel does not accept the frame.
  [[nodiscard]] bool send(std::span<const std::byte> frame) noexcept;
  /// The next received frame, valid until the next call; none: there is none yet.
  [[nodiscard]] std::optional<std::span<const std::byte>> take() noexcept;

 private:
  /// A queue that is shared with the kernel (Documentation/networking/af_xdp.rst).
  struct Queue {
    std::byte* memory = nullptr;
    std::size_t bytes = 0;
    std::uint32_t* producer = nullptr;
    std::uint32_t* consumer = nullptr;
    std::byte* entries = nullptr;
  };
  void map(int option, std::uint64_t page, std::size_t entry_bytes, Queue& queue);
  void give(std::uint64_t address) noexcept;

  rt::FileDescriptor socket_;
  std::byte* frames_ = nullptr;
  Queue fill_;
  Queue completed_;
  Queue received_;
  Queue sending_;
  std::optional<std::uint64_t> held_;  ///< address of the last received frame
  std::optional<port::XdpProgram> program_;
};

}  // namespace driveline::bench

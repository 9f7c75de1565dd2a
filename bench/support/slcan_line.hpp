#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <thread>

#include "driveline/rt/file_descriptor.hpp"

namespace driveline::bench {

/// A TCP client of 127.0.0.1 that sends small pieces at once.
class TcpClient {
 public:
  /// Throws std::runtime_error.
  explicit TcpClient(std::uint16_t port);

  [[nodiscard]] int get() const noexcept { return socket_.get(); }
  /// Sends all of it, and waits for `size` bytes. Throws Disturbed if they do not come within seconds.
  std::string exchange(std::string_view request, std::size_t size);

 private:
  rt::FileDescriptor socket_;
};

/// Answers every piece that it receives with `answer`: what any server over TCP does at least. Has a thread.
class TcpEcho {
 public:
  explicit TcpEcho(std::string answer);
  [[nodiscard]] std::uint16_t port() const noexcept { return port_; }

 private:
  void run(const std::stop_token& stop, const std::string& answer);

  rt::FileDescriptor listener_;
  std::uint16_t port_ = 0;
  std::jthread thread_;
};

/// A line of eight MSD drives on a CAN bus of 1 Mbit/s, served by slcan on TCP as `driveline simulate` does. Has a
/// thread.
class SlcanLine {
 public:
  SlcanLine();
  ~SlcanLine();
  SlcanLine(const SlcanLine&) = delete;
  SlcanLine& operator=(const SlcanLine&) = delete;

  [[nodiscard]] std::uint16_t port() const noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// What a full bus has carried from one client to another.
struct FullBus {
  std::uint64_t sent = 0;
  std::uint64_t lost = 0;  ///< those that did not come, or not in their order
  double bits = 0.0;       ///< of all frames that came, by the arithmetic
  double seconds = 0.0;    ///< until the last one came
};

/// Sends frames of 8 bytes from one client of the line to another as fast as the line takes them. Throws Disturbed if
/// they do not come within seconds.
[[nodiscard]] FullBus fill_bus(std::uint16_t port, std::chrono::duration<double> duration);

}  // namespace driveline::bench

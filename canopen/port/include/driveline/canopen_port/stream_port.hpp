#pragma once

#include <optional>
#include <string_view>
#include <utility>

#include "driveline/canopen_port/byte_stream.hpp"
#include "driveline/canopen_port/can_port.hpp"
#include "driveline/canopen_port/can_port_options.hpp"

namespace driveline::canopen {

/// What the ports have in common whose frames come in a stream of bytes. A port tells what a byte of the other end
/// means and writes frames.
class StreamPort : public CanPort {
 public:
  /// How long the other end may take to answer when a port is opened.
  static constexpr std::chrono::nanoseconds kPatience = std::chrono::seconds{3};

  StreamPort(const StreamPort&) = delete;
  StreamPort& operator=(const StreamPort&) = delete;
  ~StreamPort() override = default;

  [[nodiscard]] SendStatus send(const Frame& frame) noexcept final;
  [[nodiscard]] std::optional<ReceivedFrame> receive() noexcept final;
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept final;
  [[nodiscard]] PortStatistics statistics() const noexcept final;

 protected:
  /// A time that never comes.
  static constexpr std::chrono::nanoseconds kNever = std::chrono::nanoseconds::max();

  /// `clock` must outlive the port.
  StreamPort(rt::FileDescriptor descriptor, const CanPortOptions& options, rt::Clock& clock) noexcept
      : stream_(std::move(descriptor), clock), options_(options), clock_(clock) {}

  /// Takes the next byte of the other end; returns the frame that is complete with it. \rtsafe
  [[nodiscard]] virtual std::optional<Frame> take(char byte) noexcept = 0;
  /// Hands a valid frame to the stream. \rtsafe
  [[nodiscard]] virtual SendStatus write_frame(const Frame& frame) noexcept = 0;
  /// Input that was skipped since the start. \rtsafe
  [[nodiscard]] virtual std::uint64_t malformed() const noexcept = 0;
  /// Does what is due at `now`, without waiting. \rtsafe
  virtual void act(std::chrono::nanoseconds /*now*/) noexcept {}
  /// When act() has something to do. \rtsafe
  [[nodiscard]] virtual std::chrono::nanoseconds next_act() const noexcept { return kNever; }

  /// Returns the next byte, waiting for it until `deadline`; empty: there is none. For the time before the port is in
  /// use.
  [[nodiscard]] std::optional<char> await_byte(std::chrono::nanoseconds deadline) noexcept;
  /// The connection. \rtsafe
  [[nodiscard]] ByteStream& stream() noexcept { return stream_; }
  /// What the port was opened with. \rtsafe
  [[nodiscard]] const CanPortOptions& options() const noexcept { return options_; }
  /// The port's clock. \rtsafe
  [[nodiscard]] rt::Clock& clock() const noexcept { return clock_; }
  /// Counters, to which a port adds what its protocol tells of the bus. \rtsafe
  [[nodiscard]] PortStatistics& counters() noexcept { return counters_; }

 private:
  [[nodiscard]] std::optional<Frame> take_buffered() noexcept;
  [[nodiscard]] bool look_for_frame() noexcept;

  ByteStream stream_;
  CanPortOptions options_;
  rt::Clock& clock_;
  PortStatistics counters_;
  std::string_view input_;             ///< of the stream, not yet taken
  std::optional<ReceivedFrame> next_;  ///< what receive() returns
  bool told_end_ = false;              ///< wait_readable() has returned because the connection ended
};

}  // namespace driveline::canopen

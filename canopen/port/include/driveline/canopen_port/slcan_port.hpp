#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

#include "driveline/canopen_port/can_port_error.hpp"
#include "driveline/canopen_port/slcan_reader.hpp"
#include "driveline/canopen_port/stream_port.hpp"

namespace driveline::canopen {

/// A serial CAN adapter (LAWICEL AB, CAN232 and CANUSB manuals; known as slcan) at a terminal, or over TCP. Opening it
/// closes its channel, sets the bit rate and opens the channel, and takes a tenth of a second, in which an adapter ends
/// what an earlier program left. An adapter that does not answer is refused. The destructor closes the channel.
///
/// The state of the bus comes from the command F, once a second, if the adapter knows it; the protocol has no flag for
/// bus off and no error frames. A frame that the adapter refuses afterwards counts as lost. With `listen_only` send()
/// gives kNotValid.
class SlcanPort final : public StreamPort {
 public:
  /// Opens the adapter at a terminal, a serial device or a pseudo-terminal, with 115200 bit/s where that matters.
  [[nodiscard]] static tl::expected<std::unique_ptr<SlcanPort>, CanPortError> open_terminal(
      const std::filesystem::path& path, const CanPortOptions& options, rt::Clock& clock);
  /// Opens the adapter at a TCP address, "HOST:PORT".
  [[nodiscard]] static tl::expected<std::unique_ptr<SlcanPort>, CanPortError> open_tcp(std::string_view address,
                                                                                       const CanPortOptions& options,
                                                                                       rt::Clock& clock);
  /// Opens the adapter at the other end of a descriptor; `place` is for errors.
  [[nodiscard]] static tl::expected<std::unique_ptr<SlcanPort>, CanPortError> on(
      rt::FileDescriptor descriptor, std::string_view place, const CanPortOptions& options, rt::Clock& clock,
      std::chrono::nanoseconds patience = kPatience);
  ~SlcanPort() override;

 private:
  enum class Answer : std::uint8_t { kOk, kRefused, kNone };

  SlcanPort(rt::FileDescriptor descriptor, const CanPortOptions& options, rt::Clock& clock) noexcept
      : StreamPort(std::move(descriptor), options, clock) {}

  [[nodiscard]] tl::expected<void, CanPortError> start(std::string_view place, std::chrono::nanoseconds patience);
  [[nodiscard]] CanPortError no_start(Answer answer, std::string_view text, std::string_view place);
  Answer command(std::string_view text, std::chrono::nanoseconds patience) noexcept;
  void let_finish(std::chrono::nanoseconds quiet) noexcept;
  void answered(bool good) noexcept;
  void take_flags() noexcept;

  [[nodiscard]] std::optional<Frame> take(char byte) noexcept override;
  [[nodiscard]] SendStatus write_frame(const Frame& frame) noexcept override;
  [[nodiscard]] std::uint64_t malformed() const noexcept override { return reader_.malformed(); }
  void act(std::chrono::nanoseconds now) noexcept override;
  [[nodiscard]] std::chrono::nanoseconds next_act() const noexcept override { return next_flags_; }

  SlcanReader reader_;
  std::uint64_t unanswered_ = 0;         ///< frames without an answer, of those before the last F
  std::uint64_t unanswered_behind_ = 0;  ///< of those behind it
  bool flags_pending_ = false;           ///< F has no answer yet
  std::chrono::nanoseconds next_flags_ = kNever;
};

}  // namespace driveline::canopen

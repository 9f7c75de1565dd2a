#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/port/interface_port.hpp"
#include "driveline/rt/counter.hpp"
#include "driveline/rt/file_descriptor.hpp"

namespace driveline::port {

class XdpProgram;
class XdpSocket;

/// How frames get from the driver into the memory of an XdpPort, fastest mode first.
enum class XdpMode : std::uint8_t {
  kZeroCopy,  ///< the network card writes and reads that memory itself
  kNative,    ///< the driver runs the XDP program, the kernel copies
  kGeneric,   ///< the kernel runs the XDP program and copies; works with every driver, no faster than a packet socket
};

/// "zero copy", "native, copied" or "generic, copied".
[[nodiscard]] const char* to_text(XdpMode mode) noexcept;

/// Settings of an XdpPort.
struct XdpConfig {
  std::string interface;               ///< name as in `ip link`, at most 15 characters
  XdpMode first = XdpMode::kZeroCopy;  ///< mode that is tried first
  XdpMode last = XdpMode::kGeneric;    ///< mode that is tried last
};

/// Counters of an XdpPort.
struct XdpStatistics {
  std::uint64_t sent = 0;           ///< frames handed to the driver
  std::uint64_t send_failures = 0;  ///< frames refused for any reason
  std::uint64_t received = 0;       ///< frames returned by receive()
  std::uint64_t too_short = 0;      ///< discarded: too short for an EtherCAT header
  std::uint64_t too_long = 0;       ///< discarded: longer than kMaxFrameBytes
};

/// EtherCAT on a network interface of this machine through AF_XDP (kernel: Documentation/networking/af_xdp.rst): frames
/// are in memory shared with the kernel and, where the driver supports it, never become packets of its network stack.
///
/// - A program of 20 instructions at the interface's receive side (XDP) takes the frames of EtherType 0x88A4, with or
///   without an 802.1Q or 802.1ad tag; the kernel handles all others as usual. The program is attached by a link: the
///   kernel removes it when the port is closed or its process ends, however it ends.
/// - Meanwhile nothing else on the machine sees received EtherCAT frames: no packet socket, no tcpdump. CapturePort
///   does.
/// - send() and receive() do not wait. send() makes one system call (with zero copy none while the driver polls),
///   receive() none (with zero copy one while the driver requests it); a few more when a frame is refused.
/// - Frames are taken from receive queue 0 of the interface, where network cards put frames that are not IP.
/// - Some drivers restart the link when a program is attached: open() waits for it.
/// - Tags are removed before frames are handed out. Time stamps, own frames and a pulled cable are handled as by
///   RawSocketPort.
///
/// The clock must run in real time (MonotonicClock): it gives the time stamps and the deadline of wait_readable().
class XdpPort final : public InterfacePort {
 public:
  /// Opens the interface, which must exist, carry Ethernet and be up, in the first of the modes from `first` to `last`
  /// that works. Needs CAP_NET_RAW, CAP_NET_ADMIN and CAP_BPF (before Linux 5.8 CAP_SYS_ADMIN instead of the latter)
  /// and Linux 5.9. `clock` must outlive the port. Errors: those of RawSocketPort::open(), kSystem also if another
  /// program or socket uses the interface, and kUnsupported with the reason of the last mode.
  [[nodiscard]] static tl::expected<std::unique_ptr<XdpPort>, PortError> open(const XdpConfig& config,
                                                                              rt::Clock& clock);

  XdpPort(const XdpPort&) = delete;
  XdpPort& operator=(const XdpPort&) = delete;
  ~XdpPort() override;

  /// kTooLong also for a frame longer than the MTU that the interface had when it was opened; kBusy also for a frame
  /// that the kernel refuses for any other reason. \rtsafe
  [[nodiscard]] SendStatus send(std::span<const std::byte> frame) noexcept override;

  /// \rtsafe
  [[nodiscard]] std::optional<ReceivedFrame> receive() noexcept override;

  /// May also return true for a frame that receive() then discards (see XdpStatistics).
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override;

  /// \rtsafe
  [[nodiscard]] std::chrono::nanoseconds last_send_time() const noexcept override { return last_send_time_; }

  [[nodiscard]] const wire::MacAddress& mac() const noexcept override { return mac_; }
  [[nodiscard]] bool link_up() const noexcept override;
  [[nodiscard]] std::string access_method() const override;

  /// The mode in use.
  [[nodiscard]] XdpMode mode() const noexcept { return mode_; }
  /// Why no faster mode is used, one sentence for each mode tried; also other remarks on the interface.
  [[nodiscard]] const std::vector<std::string>& steps_down() const noexcept { return steps_down_; }
  /// Counters so far. Any thread. \rtsafe
  [[nodiscard]] XdpStatistics statistics() const noexcept;

 private:
  XdpPort(std::unique_ptr<XdpSocket> socket, std::unique_ptr<XdpProgram> program, rt::FileDescriptor asking,
          std::string interface, int index, rt::Clock& clock) noexcept;

  [[nodiscard]] static tl::expected<std::unique_ptr<XdpPort>, PortError> try_mode(XdpMode mode,
                                                                                  const std::string& interface,
                                                                                  rt::Clock& clock);
  void wait_for_link() const;
  [[nodiscard]] SendStatus classify_failure(int error_number) const noexcept;

  std::unique_ptr<XdpSocket> socket_;    ///< declared before the program: the kernel sends no frames to a closed socket
  std::unique_ptr<XdpProgram> program_;  ///< attached for the lifetime of this object
  rt::FileDescriptor asking_;            ///< socket for queries about interfaces
  std::string interface_;
  int index_;
  wire::MacAddress mac_{};
  std::size_t longest_ = kMaxFrameBytes;  ///< longest frame by the MTU, in bytes
  XdpMode mode_ = XdpMode::kGeneric;
  std::vector<std::string> steps_down_;
  rt::Clock& clock_;
  std::chrono::nanoseconds last_send_time_{};

  rt::Counter sent_;
  rt::Counter send_failures_;
  rt::Counter received_;
  rt::Counter too_short_;
  rt::Counter too_long_;
};

/// Whether an XDP program of any process is attached to the interface; false if the kernel does not report it or there
/// is no such interface. Not for the cycle.
[[nodiscard]] bool has_xdp_program(const std::string& interface);

}  // namespace driveline::port

#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

#include "driveline/slaves/ethernet_link.hpp"
#include "driveline/slaves/mailbox/mailbox_server.hpp"
#include "driveline/wire/eoe.hpp"
#include "driveline/wire/eoe_frames.hpp"

namespace driveline::slaves {

/// What a device has before a master gives it another: 192.168.39.5/24 (MSD manual 7.6), no gateway, and a locally
/// administered MAC address with the serial number in it.
[[nodiscard]] wire::EoeIpParameters factory_address(std::uint32_t serial_number) noexcept;

/// What EoeServer has seen.
struct EoeCounters {
  std::uint64_t to_network = 0;     ///< frames from the master that went on
  std::uint64_t to_master = 0;      ///< frames from the network that went on, as far as their first fragment
  std::uint64_t filtered = 0;       ///< frames from the master that the address filter stopped
  std::uint64_t dropped = 0;        ///< frames from the master for which the network had no room, or was not there
  std::uint64_t stamps_missed = 0;  ///< time stamps that the master fetched too late to get
  constexpr bool operator==(const EoeCounters&) const = default;
};

/// Ethernet over EtherCAT of a device (ETG.1000.6 5.7): frames between the master and the device's network, IP
/// parameters, address filter, and time stamps of frames that ask for one.
///
/// Frames pass while the mailbox runs in PREOP, SAFEOP and OP. Allocates nothing. Address and filter stay until
/// restart().
class EoeServer final : public MailboxProtocol {
 public:
  /// The device's addresses after each restart().
  explicit EoeServer(const wire::EoeIpParameters& factory) noexcept : factory_(factory), address_(factory) {}

  /// The network behind the port, which must outlive this or be replaced; null: none. Tells it address and link.
  void connect(EthernetLink* link) noexcept;
  /// The device was switched on: factory address, no filter, link down. \rtsafe
  void restart() noexcept;
  /// The device is in this AL state: the link is up above INIT, but not in BOOT. \rtsafe
  void enter(wire::AlState state) noexcept;
  /// The device's own time, for time stamps. \rtsafe
  void set_time(std::chrono::nanoseconds now) noexcept { now_ = now; }

  /// Of the device, as set. \rtsafe
  [[nodiscard]] const wire::EoeIpParameters& address() const noexcept { return address_; }
  /// Frames pass. \rtsafe
  [[nodiscard]] bool link_up() const noexcept { return up_; }
  /// Since construction. \rtsafe
  [[nodiscard]] const EoeCounters& counters() const noexcept { return counters_; }
  /// Fragments from the master, since construction. \rtsafe
  [[nodiscard]] const wire::EoeAssembly& assembly() const noexcept { return assembler_.seen(); }

  /// EoE, type 2.
  [[nodiscard]] wire::MailboxType type() const noexcept override { return wire::MailboxType::kEoe; }
  /// Fragments have none.
  [[nodiscard]] bool without_answer(std::span<const std::byte> data) const noexcept override;
  /// Frames go on as long as they come.
  [[nodiscard]] bool endless() const noexcept override { return true; }
  [[nodiscard]] tl::expected<std::size_t, wire::MailboxErrorCode> request(const MailboxRequest& request,
                                                                          std::span<std::byte> out) override;
  [[nodiscard]] std::size_t unsolicited(std::span<std::byte> out) override;
  /// Link down; assembly, frame on its way and time stamp are forgotten.
  void stop() noexcept override;

 private:
  using Answer = tl::expected<std::size_t, wire::MailboxErrorCode>;
  /// Asked for by a frame, not fetched yet.
  struct TimeStamp {
    wire::EoeHeader header;
    std::uint32_t time_ns = 0;
  };

  void take_fragment(const wire::EoeHeader& header, std::span<const std::byte> data) noexcept;
  void forward(std::span<const std::byte> frame) noexcept;
  [[nodiscard]] bool passes(std::span<const std::byte> frame) const noexcept;
  [[nodiscard]] wire::EoeResult set_address(std::span<const std::byte> data) noexcept;
  [[nodiscard]] wire::EoeResult set_filter(std::span<const std::byte> data) noexcept;
  [[nodiscard]] std::size_t send_stamp(std::span<std::byte> out) noexcept;

  wire::EoeIpParameters factory_;
  wire::EoeIpParameters address_;
  std::optional<wire::EoeAddressFilter> filter_;
  EthernetLink* link_ = nullptr;
  bool up_ = false;
  std::chrono::nanoseconds now_{0};
  std::optional<TimeStamp> stamp_;
  wire::EoeAssembler assembler_;
  wire::EoeFragmenter fragmenter_;
  std::array<std::byte, wire::kMaxEoeFrame> frame_{};  ///< to the master
  EoeCounters counters_;
};

}  // namespace driveline::slaves

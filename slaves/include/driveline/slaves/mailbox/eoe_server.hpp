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

/// Returns the addresses that a device has until a master changes them: 192.168.39.5/24 (MSD manual 7.6), no gateway,
/// and a locally administered MAC address that contains the serial number.
[[nodiscard]] wire::EoeIpParameters factory_address(std::uint32_t serial_number) noexcept;

/// Counters of EoeServer.
struct EoeCounters {
  std::uint64_t to_network = 0;     ///< frames from the master that were forwarded
  std::uint64_t to_master = 0;      ///< frames from the network whose transfer to the master was started
  std::uint64_t filtered = 0;       ///< frames from the master that the address filter discarded
  std::uint64_t dropped = 0;        ///< frames from the master lost because the network was full or missing
  std::uint64_t stamps_missed = 0;  ///< time stamps lost because the master fetched too late
  constexpr bool operator==(const EoeCounters&) const = default;
};

/// Ethernet over EtherCAT server of a device (ETG.1000.6 5.7): frames between the master and the device's network, IP
/// parameters, address filter, and time stamps of frames that request one.
///
/// Frames pass while the mailbox runs in PREOP, SAFEOP and OP. Does not allocate. Addresses and filter are retained
/// until restart().
class EoeServer final : public MailboxProtocol {
 public:
  /// Sets the device's addresses after each restart().
  explicit EoeServer(const wire::EoeIpParameters& factory) noexcept : factory_(factory), address_(factory) {}

  /// Connects the network at the port, which must outlive this or be replaced; null: none. Sets its addresses and link.
  void connect(EthernetLink* link) noexcept;
  /// Resets to the state after power-on: factory address, no filter, link down. \rtsafe
  void restart() noexcept;
  /// Notifies that the device has entered this AL state: the link is up above INIT, but not in BOOT. \rtsafe
  void enter(wire::AlState state) noexcept;
  /// Sets the device's time, for time stamps. \rtsafe
  void set_time(std::chrono::nanoseconds now) noexcept { now_ = now; }

  /// Returns the device's current addresses. \rtsafe
  [[nodiscard]] const wire::EoeIpParameters& address() const noexcept { return address_; }
  /// Whether the link is up, so that frames pass. \rtsafe
  [[nodiscard]] bool link_up() const noexcept { return up_; }
  /// Returns the counts since construction. \rtsafe
  [[nodiscard]] const EoeCounters& counters() const noexcept { return counters_; }
  /// Returns the counts of fragments from the master since construction. \rtsafe
  [[nodiscard]] const wire::EoeAssembly& assembly() const noexcept { return assembler_.seen(); }

  /// EoE, type 2.
  [[nodiscard]] wire::MailboxType type() const noexcept override { return wire::MailboxType::kEoe; }
  /// True for fragments.
  [[nodiscard]] bool without_answer(std::span<const std::byte> data) const noexcept override;
  /// True: frames may arrive without end.
  [[nodiscard]] bool endless() const noexcept override { return true; }
  [[nodiscard]] tl::expected<std::size_t, wire::MailboxErrorCode> request(const MailboxRequest& request,
                                                                          std::span<std::byte> out) override;
  [[nodiscard]] std::size_t unsolicited(std::span<std::byte> out) override;
  /// Takes the link down; discards the frames in progress in both directions and the time stamp.
  void stop() noexcept override;

 private:
  using Answer = tl::expected<std::size_t, wire::MailboxErrorCode>;
  /// Time stamp that a frame requested and the master has not fetched yet.
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
  std::array<std::byte, wire::kMaxEoeFrame> frame_{};  ///< frame in transfer to the master
  EoeCounters counters_;
};

}  // namespace driveline::slaves

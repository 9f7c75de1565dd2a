#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "driveline/slaves/esc/datagram.hpp"

namespace driveline::slaves {

/// Kind of a frame for a slave controller.
enum class FrameKind : std::uint8_t {
  kForeign,     ///< not EtherCAT: forwarded or destroyed
  kNoCommands,  ///< EtherCAT of another type (e.g. mailbox gateway): forwarded as it is
  kCommands,    ///< datagrams
};

/// The datagrams of one frame, taken apart once per way through the line and put back at its end. Accepts EtherType
/// 0x88A4, EtherCAT in UDP (IPv4, destination port 0x88A4), both with at most one VLAN tag.
///
/// An incomplete datagram ends the list and sets malformed(). \rtsafe throughout.
class FrameDatagrams {
 public:
  /// As many as fit into the longest frame.
  static constexpr std::size_t kMaxCount = 128;

  /// Takes `frame` apart; the frame must stay where it is until store().
  FrameKind load(std::span<std::byte> frame) noexcept;
  /// In the order of the frame; to be changed in place. Until the next load().
  [[nodiscard]] std::span<Datagram> datagrams() noexcept { return {datagrams_.data(), count_}; }
  /// The frame says that it holds more than it does, or a datagram is cut off.
  [[nodiscard]] bool malformed() const noexcept { return malformed_; }
  /// Writes the changed header fields and working counters back; `circulating` sets the bit of that name.
  void store(bool circulating) noexcept;
  /// True when the first datagram has come with the circulating bit set.
  [[nodiscard]] bool circulating() const noexcept { return circulating_; }

 private:
  /// Offset of the EtherCAT header, 0 when this is no EtherCAT frame.
  [[nodiscard]] std::size_t find_ethercat() noexcept;

  std::span<std::byte> frame_;
  std::array<Datagram, kMaxCount> datagrams_;
  std::size_t count_ = 0;
  std::size_t udp_checksum_ = 0;  ///< offset, 0: none
  bool malformed_ = false;
  bool circulating_ = false;
};

}  // namespace driveline::slaves

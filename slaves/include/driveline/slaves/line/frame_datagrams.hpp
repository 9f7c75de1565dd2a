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
  kNoCommands,  ///< EtherCAT of another type (e.g. mailbox gateway): forwarded unchanged
  kCommands,    ///< EtherCAT datagrams
};

/// Datagrams of a frame, decoded before its passage through the line and written back afterwards. Accepts EtherType
/// 0x88A4 and EtherCAT in UDP (IPv4, destination port 0x88A4), both with at most one VLAN tag.
///
/// An incomplete datagram ends the list and sets malformed(). \rtsafe throughout.
class FrameDatagrams {
 public:
  /// Maximum number of datagrams in the longest frame.
  static constexpr std::size_t kMaxCount = 128;

  /// Decodes `frame`, which must stay in place until store().
  FrameKind load(std::span<std::byte> frame) noexcept;
  /// Returns the datagrams in the order of the frame, to be changed in place. Valid until the next load().
  [[nodiscard]] std::span<Datagram> datagrams() noexcept { return {datagrams_.data(), count_}; }
  /// Whether the frame is shorter than its header states, or a datagram is truncated.
  [[nodiscard]] bool malformed() const noexcept { return malformed_; }
  /// Writes the changed header fields and working counters back; `circulating` sets the circulating bit.
  void store(bool circulating) noexcept;
  /// Whether the first datagram arrived with the circulating bit set.
  [[nodiscard]] bool circulating() const noexcept { return circulating_; }

 private:
  /// Returns the offset of the EtherCAT header; 0 when this is not an EtherCAT frame.
  [[nodiscard]] std::size_t find_ethercat() noexcept;

  std::span<std::byte> frame_;
  std::array<Datagram, kMaxCount> datagrams_;
  std::size_t count_ = 0;
  std::size_t udp_checksum_ = 0;  ///< offset; 0: none
  bool malformed_ = false;
  bool circulating_ = false;
};

}  // namespace driveline::slaves

#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "driveline/ecat_master/bus/datagram_exchange.hpp"
#include "driveline/rt/counter.hpp"

namespace driveline::ecat_master {

/// Frames of other senders that the cycle receives, and the most serious datagram of another master among them.
class ForeignFrames {
 public:
  /// Takes a frame that is not of this master. Returns false for a harmless frame, which does not count. For the
  /// cycle. \rtsafe
  bool note(std::span<const std::byte> frame) noexcept;
  /// Frames so far. Any thread. \rtsafe
  [[nodiscard]] std::uint64_t count() const noexcept { return frames_.value(); }
  /// EtherCAT frames of another master so far. Any thread. \rtsafe
  [[nodiscard]] OtherMaster other_master() const noexcept;

 private:
  rt::Counter frames_;
  rt::Counter frames_of_masters_;
  std::atomic<std::uint64_t> source_{0};    ///< source address of the other master, first byte lowest
  std::atomic<std::uint64_t> datagram_{0};  ///< weight, command, ADP and ADO
};

}  // namespace driveline::ecat_master

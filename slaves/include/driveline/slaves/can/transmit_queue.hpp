#pragma once

#include <vector>

#include "driveline/canopen_wire/frame.hpp"

namespace driveline::slaves::can {

using canopen::Frame;

/// Frames of a node that wait for the bus: first the one that wins the arbitration, so that a frame of low priority
/// never stands in front of the same node's SYNC; equal ones in the order in which they came. Allocates only when it is
/// constructed.
class TransmitQueue {
 public:
  /// Holds at most `capacity` frames.
  explicit TransmitQueue(std::size_t capacity) : capacity_(capacity) { waiting_.reserve(capacity + 1); }

  /// Adds a frame; false: the queue is full or the frame is not valid, it is dropped and counted. \rtsafe
  bool push(const Frame& frame) noexcept;
  /// The frame to send next, or nullptr. \rtsafe
  [[nodiscard]] const Frame* front() const noexcept { return waiting_.empty() ? nullptr : &waiting_.back(); }
  /// Removes front(). Precondition: not empty. \rtsafe
  void pop() noexcept { waiting_.pop_back(); }
  /// Puts a frame back that was at the front, before equal ones; there is always room for one. \rtsafe
  void put_back(const Frame& frame) noexcept;
  /// Removes all frames; they are not counted as dropped. \rtsafe
  void clear() noexcept { waiting_.clear(); }
  /// Number of frames that wait. \rtsafe
  [[nodiscard]] std::size_t size() const noexcept { return waiting_.size(); }
  /// Frames that found no room since the start. \rtsafe
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_; }

 private:
  std::size_t capacity_;
  std::vector<Frame> waiting_;  ///< the next one to be sent is at the end
  std::uint64_t dropped_ = 0;
};

}  // namespace driveline::slaves::can

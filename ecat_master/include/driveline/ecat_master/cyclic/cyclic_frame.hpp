#pragma once

#include <array>
#include <optional>

#include "driveline/ecat_master/frame_tag.hpp"
#include "driveline/ecat_master/process_image.hpp"
#include "driveline/port/port.hpp"
#include "driveline/wire/al.hpp"

namespace driveline::ecat_master {

/// What the broadcast read of the AL status in the first cyclic frame said.
struct LineAlStatus {
  std::uint16_t slaves = 0;    ///< that answered
  std::uint16_t combined = 0;  ///< OR of their AL status registers
  /// True when every one of `expected` slaves is in OP without an error indication.
  [[nodiscard]] constexpr bool all_op(std::uint16_t expected) const noexcept {
    return slaves == expected && combined == wire::AlStatus{wire::AlState::kOp, false, false}.raw();
  }
};

/// One frame of the cyclic exchange, laid out once; a cycle only exchanges its data and its number. \rtsafe throughout
/// but the constructor.
class CyclicFrame {
 public:
  /// `segment` travels in it as LRW (none: no process data); `with_status` adds the broadcast read of the AL status.
  CyclicFrame(const ProcessSegment* segment, bool with_status);

  /// Sends the frame with the outputs out of `image`.
  [[nodiscard]] port::SendStatus send(port::Port& port, const ProcessImage& image, FrameTag tag) noexcept;

  /// Takes a received frame when it is the answer to the last send(); false: it is another one or damaged. Inputs are
  /// copied into `image` only if the working counter is as expected.
  [[nodiscard]] bool accept(std::span<const std::byte> frame, FrameTag tag, ProcessImage& image) noexcept;

  /// Facts of the last cycle.
  [[nodiscard]] bool received() const noexcept { return received_; }
  [[nodiscard]] std::uint16_t working_counter() const noexcept { return working_counter_; }
  [[nodiscard]] std::uint16_t expected_working_counter() const noexcept { return segment_.expected_working_counter; }
  [[nodiscard]] bool valid() const noexcept {
    return received_ && working_counter_ == segment_.expected_working_counter;
  }
  [[nodiscard]] const std::optional<LineAlStatus>& al_status() const noexcept { return al_status_; }

 private:
  std::array<std::byte, port::kMaxFrameBytes> buffer_{};
  std::size_t size_ = 0;
  ProcessSegment segment_{};
  std::optional<wire::DatagramPlace> status_place_;
  std::optional<wire::DatagramPlace> data_place_;
  FrameTag tag_{};
  bool awaited_ = false;
  bool received_ = false;
  std::uint16_t working_counter_ = 0;
  std::optional<LineAlStatus> al_status_;
};

}  // namespace driveline::ecat_master

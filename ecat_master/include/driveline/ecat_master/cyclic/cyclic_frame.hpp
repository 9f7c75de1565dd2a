#pragma once

#include <array>
#include <optional>
#include <vector>

#include "driveline/ecat_master/bus/frame_tag.hpp"
#include "driveline/ecat_master/dc/drift_datagram.hpp"
#include "driveline/ecat_master/process_data/process_image.hpp"
#include "driveline/port/port.hpp"
#include "driveline/wire/al.hpp"

namespace driveline::ecat_master {

/// Answer to the broadcast read of the AL status in the first cyclic frame.
struct LineAlStatus {
  std::uint16_t slaves = 0;    ///< that answered
  std::uint16_t combined = 0;  ///< OR of their AL status registers
  /// True when every one of `expected` slaves is in OP without an error indication.
  [[nodiscard]] constexpr bool all_op(std::uint16_t expected) const noexcept {
    return slaves == expected && combined == wire::AlStatus{wire::AlState::kOp, false, false}.raw();
  }
};

/// State of one slave as seen by the cycle.
struct SlaveCondition {
  bool absent = false;         ///< its status byte came back untouched
  bool down = false;           ///< its AL status is below SAFEOP: it may add to the working counter or not
  bool recovering = false;     ///< left out on request: it may add to the working counter or not
  std::uint8_t al_status = 0;  ///< low byte of its AL status; 0: not known
};

/// Result of one datagram in the last cycle it was sent in.
struct DatagramResult {
  bool received = false;  ///< it came back within its cycle
  /// The working counter is that of all present slaves: the missing part is the share of slaves that are absent by
  /// their status bytes, or recovering.
  bool good = false;
  bool complete = false;              ///< no slave is missing
  bool disturbed = false;             ///< slaves are missing besides those that are recovering
  std::uint16_t working_counter = 0;  ///< as it came back; 0 when it did not
};

/// One frame of the cyclic exchange, laid out once; a cycle only exchanges its data and its number. \rtsafe throughout
/// but the constructor.
class CyclicFrame {
 public:
  /// Frame `number` of `image`, whose layout must not change any more; the first one carries the broadcast read of the
  /// AL status as well, and `with_drift` the drift compensation of the distributed clocks.
  CyclicFrame(const ProcessImage& image, std::size_t number, bool with_drift = false);

  /// What the drift datagram is to do in the next send(). Only with one.
  void set_drift(const dc::DriftDatagram& drift) noexcept;

  /// Puts the outputs out of `image` into the frame, or zeros: what takes its time about sending, and can be done
  /// before it is time.
  void prepare(const ProcessImage& image, bool zero_outputs = false) noexcept;
  /// Sends the frame as it was prepared last.
  [[nodiscard]] port::SendStatus send(port::Port& port, FrameTag tag) noexcept;
  /// Both.
  [[nodiscard]] port::SendStatus send(port::Port& port, const ProcessImage& image, FrameTag tag,
                                      bool zero_outputs = false) noexcept {
    prepare(image, zero_outputs);
    return send(port, tag);
  }
  /// Of the last prepare().
  [[nodiscard]] bool outputs_are_zero() const noexcept { return zero_outputs_; }

  /// Takes a received frame when it is the answer to the last send(); false: it is another one or damaged. Inputs are
  /// copied into `image` and status bytes into `conditions` (by slave) as far as the working counters vouch for them.
  [[nodiscard]] bool accept(std::span<const std::byte> frame, FrameTag tag, ProcessImage& image,
                            std::span<SlaveCondition> conditions) noexcept;

  /// Judges the datagrams that carry no status bytes, now that all frames of the cycle are back.
  void judge_outputs(const ProcessImage& image, std::span<const SlaveCondition> conditions) noexcept;

  /// All its datagrams belong to this group of the image.
  [[nodiscard]] std::size_t group() const noexcept { return group_; }
  /// Of the last send().
  [[nodiscard]] FrameTag tag() const noexcept { return tag_; }
  /// Facts of the last cycle it was sent in.
  [[nodiscard]] bool received() const noexcept { return received_; }
  /// It came back complete, and so did the answer before it, with the same status bytes: nothing that it says of a
  /// slave is new.
  [[nodiscard]] bool steady() const noexcept { return received_ && steady_; }
  /// Sum over its process datagrams as they came back.
  [[nodiscard]] std::uint16_t working_counter() const noexcept;
  /// The same of a line without a missing slave.
  [[nodiscard]] std::uint16_t expected_working_counter() const noexcept { return expected_working_counter_; }
  /// All datagrams are back with the working counter of the line, without the slaves that are recovering.
  [[nodiscard]] bool valid() const noexcept;
  /// By number within the frame; the first is datagram first_datagram() of the image.
  [[nodiscard]] std::span<const DatagramResult> results() const noexcept { return results_; }
  /// Number in ProcessImage::datagrams() of the first one in this frame.
  [[nodiscard]] std::size_t first_datagram() const noexcept { return first_datagram_; }
  /// Of the first frame's broadcast; nothing in the others and when it did not come back.
  [[nodiscard]] const std::optional<LineAlStatus>& al_status() const noexcept { return al_status_; }
  /// What the drift datagram came back with.
  [[nodiscard]] const std::optional<dc::DriftAnswer>& drift() const noexcept { return drift_; }

 private:
  struct Part {
    ProcessDatagram datagram;
    wire::DatagramPlace place;
    std::size_t first_share = 0;
    std::size_t share_count = 0;
    /// Places in the frame of what slaves tell about themselves (AL status, mailbox status), and what they told last.
    std::vector<std::uint32_t> status_places;
    std::vector<std::byte> status_bytes;
    bool was_complete = false;
  };

  [[nodiscard]] bool is_answer(std::span<const std::byte> frame) const noexcept;
  void collect_status_places(const ProcessImage& image);
  [[nodiscard]] static bool status_changed(Part& part, std::span<const std::byte> frame) noexcept;
  void take(const Part& part, DatagramResult& result, std::span<const std::byte> data, ProcessImage& image,
            std::span<SlaveCondition> conditions) noexcept;
  void explain(const Part& part, const ProcessImage& image, std::span<const SlaveCondition> conditions,
               DatagramResult& result) const noexcept;

  std::array<std::byte, port::kMaxFrameBytes> buffer_{};
  std::size_t size_ = 0;
  std::size_t group_ = 0;
  std::size_t first_datagram_ = 0;
  std::optional<wire::DatagramPlace> status_place_;
  std::optional<wire::DatagramPlace> drift_place_;
  std::vector<Part> parts_;
  std::vector<DatagramResult> results_;
  std::uint16_t expected_working_counter_ = 0;
  FrameTag tag_{};
  bool zero_outputs_ = false;
  bool awaited_ = false;
  bool received_ = false;
  bool steady_ = false;
  std::optional<LineAlStatus> al_status_;
  std::optional<dc::DriftAnswer> drift_;
};

}  // namespace driveline::ecat_master

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
  std::uint16_t slaves = 0;    ///< number of slaves that answered
  std::uint16_t combined = 0;  ///< OR of their AL status registers
  /// Whether all `expected` slaves are in OP without an error indication.
  [[nodiscard]] constexpr bool all_op(std::uint16_t expected) const noexcept {
    return slaves == expected && combined == wire::AlStatus{wire::AlState::kOp, false, false}.raw();
  }
};

/// State of a slave as seen by the cycle.
struct SlaveCondition {
  bool absent = false;         ///< its status byte came back untouched
  bool down = false;           ///< its AL status is below SAFEOP: it may add to the working counter or not
  bool recovering = false;     ///< excluded on request: it may add to the working counter or not
  bool outputs_off = false;    ///< in SAFEOP with an error: it may take outputs or not, its inputs stay valid
  std::uint8_t al_status = 0;  ///< low byte of its AL status; 0: not known
};

/// Result of a datagram in the last cycle in which it was sent.
struct DatagramResult {
  bool received = false;  ///< it came back within its cycle
  /// The working counter is that of all present slaves: only the shares of slaves are missing that are absent by their
  /// status bytes, or recovering.
  bool good = false;
  bool complete = false;              ///< no slave is missing
  bool disturbed = false;             ///< slaves are missing other than the recovering ones
  std::uint16_t working_counter = 0;  ///< as received; 0 if the datagram did not come back
};

/// A frame of the cyclic exchange. Its layout is built once; a cycle only replaces its data and its number. All
/// functions except the constructor are \rtsafe.
class CyclicFrame {
 public:
  /// Frame `number` of `image`, whose layout must not change any more. The first frame also carries the broadcast read
  /// of the AL status and, with `with_drift`, the drift compensation of the distributed clocks.
  CyclicFrame(const ProcessImage& image, std::size_t number, bool with_drift = false);

  /// Sets the drift datagram of the next send(); only for a frame that has one.
  void set_drift(const dc::DriftDatagram& drift) noexcept;

  /// Copies the outputs of `image`, or zeros, into the frame: the time-consuming part of sending, which can be done in
  /// advance.
  void prepare(const ProcessImage& image, bool zero_outputs = false) noexcept;
  /// Sends the frame as last prepared.
  [[nodiscard]] port::SendStatus send(port::Port& port, FrameTag tag) noexcept;
  /// Prepares and sends the frame.
  [[nodiscard]] port::SendStatus send(port::Port& port, const ProcessImage& image, FrameTag tag,
                                      bool zero_outputs = false) noexcept {
    prepare(image, zero_outputs);
    return send(port, tag);
  }
  /// Whether the last prepare() wrote zeros.
  [[nodiscard]] bool outputs_are_zero() const noexcept { return zero_outputs_; }

  /// Takes a received frame if it is the answer to the last send(); false: it is another frame or damaged. Inputs are
  /// copied into `image` and status bytes into `conditions` (by slave) as far as the working counters confirm them.
  [[nodiscard]] bool accept(std::span<const std::byte> frame, FrameTag tag, ProcessImage& image,
                            std::span<SlaveCondition> conditions) noexcept;

  /// Evaluates the datagrams that carry no status bytes, once all frames of the cycle are back.
  void judge_outputs(const ProcessImage& image, std::span<const SlaveCondition> conditions) noexcept;

  /// Group of the image that all its datagrams belong to.
  [[nodiscard]] std::size_t group() const noexcept { return group_; }
  /// Tag of the last send().
  [[nodiscard]] FrameTag tag() const noexcept { return tag_; }
  /// Whether the frame came back in the last cycle in which it was sent.
  [[nodiscard]] bool received() const noexcept { return received_; }
  /// Whether this answer and the previous one were complete, with the same status bytes: then it reports nothing new
  /// about any slave.
  [[nodiscard]] bool steady() const noexcept { return received_ && steady_; }
  /// Sum of the working counters of its process datagrams as received.
  [[nodiscard]] std::uint16_t working_counter() const noexcept;
  /// That sum for a line without a missing slave.
  [[nodiscard]] std::uint16_t expected_working_counter() const noexcept { return expected_working_counter_; }
  /// Whether all datagrams are back with the working counter of the line, apart from recovering slaves.
  [[nodiscard]] bool valid() const noexcept;
  /// Results by number within the frame; the first is datagram first_datagram() of the image.
  [[nodiscard]] std::span<const DatagramResult> results() const noexcept { return results_; }
  /// Index in ProcessImage::datagrams() of the first datagram of this frame.
  [[nodiscard]] std::size_t first_datagram() const noexcept { return first_datagram_; }
  /// Answer to the broadcast of the first frame; empty in other frames, and if it did not come back.
  [[nodiscard]] const std::optional<LineAlStatus>& al_status() const noexcept { return al_status_; }
  /// Answer to the drift datagram.
  [[nodiscard]] const std::optional<dc::DriftAnswer>& drift() const noexcept { return drift_; }

 private:
  struct Part {
    ProcessDatagram datagram;
    wire::DatagramPlace place;
    std::size_t first_share = 0;
    std::size_t share_count = 0;
    /// Offsets in the frame of the status bytes of slaves (AL status, mailbox status), and their last values.
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

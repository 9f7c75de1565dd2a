#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "driveline/ecat_master/cyclic/acyclic_channel.hpp"
#include "driveline/ecat_master/cyclic/cyclic_frame.hpp"
#include "driveline/ecat_master/cyclic/motion.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "driveline/rt/histogram.hpp"
#include "driveline/snapshot/snapshot.hpp"

namespace driveline::ecat_master {

/// Rings the cycle writes its samples to; both may be left out.
struct SampleRings {
  rt::SpscRing<snapshot::LineSample>* lines = nullptr;
  rt::SpscRing<snapshot::AxisSample>* axes = nullptr;
};

/// What the cycle has counted while counting was on; owned by the cycle, to be read when it rests.
struct CycleStatistics {
  std::uint64_t cycles = 0;
  std::uint64_t missed_periods = 0;
  std::uint64_t wkc_errors = 0;    ///< frames that came back with another working counter than expected
  std::uint64_t lost_frames = 0;   ///< cyclic frames that did not come back within their cycle
  std::uint64_t stale_frames = 0;  ///< frames that came back after their cycle
  std::uint64_t foreign_frames = 0;
  rt::Histogram wake_latency;
  rt::Histogram cost;         ///< wake-up to the end of the cycle's work
  rt::Histogram master_cost;  ///< the same without the time inside the port
  rt::Histogram round_trip;   ///< send of the first to receive of the last cyclic frame
};

/// The cyclic exchange: sends the outputs prepared in the cycle before right after wake-up, so that they leave with
/// the least jitter; waits for the answer by polling the port up to a deadline inside the period; then reads the
/// inputs and prepares the next outputs.
///
/// A frame that is lost or late costs its cycle at most the waiting time and the next cycle nothing: the grid stands.
/// cycle() is \rtsafe and noexcept; it belongs to one thread.
class CyclicCore {
 public:
  struct Settings {
    std::chrono::nanoseconds period = std::chrono::microseconds{125};
    /// Longest wait for the answer, from the grid time on.
    std::chrono::nanoseconds receive_window = std::chrono::microseconds{90};
    std::uint16_t slaves = 0;        ///< on the line, for the AL status broadcast
    std::uint8_t instance = 0;       ///< FrameTag::instance
    std::uint32_t sample_every = 1;  ///< samples of every n-th cycle go to the rings
  };

  /// `motion` may be null: process data are exchanged as the image holds them.
  CyclicCore(port::Port& port, rt::Clock& clock, ProcessImage image, Motion* motion, SampleRings rings,
             Settings settings);

  /// One cycle. \rtsafe
  void cycle(const rt::CycleStart& start) noexcept;

  [[nodiscard]] AcyclicChannel& acyclic() noexcept { return acyclic_; }
  [[nodiscard]] const Settings& settings() const noexcept { return settings_; }

  // Any thread, \rtsafe.
  /// Switches the statistics on (at first they are) or off from the next cycle on; switching them on starts anew.
  void count(bool on) noexcept { counting_wanted_.store(on, std::memory_order_release); }
  /// Cycles so far, counting or not.
  [[nodiscard]] std::uint64_t cycles() const noexcept { return cycles_shared_.load(std::memory_order_relaxed); }
  /// Cycles in a row whose process data were not all valid.
  [[nodiscard]] std::uint32_t bad_cycles() const noexcept { return bad_cycles_.load(std::memory_order_relaxed); }
  /// Newest AL status of the line; slaves == 0 while no frame comes back.
  [[nodiscard]] LineAlStatus al_status() const noexcept {
    const auto raw = al_status_shared_.load(std::memory_order_relaxed);
    return {static_cast<std::uint16_t>(raw >> 16), static_cast<std::uint16_t>(raw & 0xFFFF)};
  }

  /// Only while no cycle runs.
  [[nodiscard]] const CycleStatistics& statistics() const noexcept { return statistics_; }
  [[nodiscard]] ProcessImage& image() noexcept { return image_; }

 private:
  void send() noexcept;
  void receive(std::chrono::nanoseconds deadline) noexcept;
  void dispatch(const port::ReceivedFrame& frame) noexcept;
  void evaluate() noexcept;
  void tally(const rt::CycleStart& start, std::chrono::nanoseconds cost) noexcept;
  void publish(const rt::CycleStart& start, std::chrono::nanoseconds cost) noexcept;
  [[nodiscard]] bool all_received() const noexcept;

  port::Port& port_;
  rt::Clock& clock_;
  ProcessImage image_;
  Motion* motion_;
  SampleRings rings_;
  Settings settings_;
  std::vector<CyclicFrame> frames_;
  std::unique_ptr<bool[]> slave_valid_;
  AcyclicChannel acyclic_;
  CycleStatistics statistics_;
  bool counting_ = true;
  std::uint64_t cycles_ = 0;
  std::uint32_t sequence_ = 0;
  std::chrono::nanoseconds sent_at_{};
  std::chrono::nanoseconds received_at_{};
  std::chrono::nanoseconds in_port_{};
  std::uint32_t missed_now_ = 0;
  std::atomic<bool> counting_wanted_{true};
  std::atomic<std::uint64_t> cycles_shared_{0};
  std::atomic<std::uint32_t> bad_cycles_{0};
  std::atomic<std::uint32_t> al_status_shared_{0};
};

}  // namespace driveline::ecat_master

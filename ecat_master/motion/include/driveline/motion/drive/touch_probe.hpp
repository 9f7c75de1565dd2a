#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "driveline/motion/cia301/image_place.hpp"
#include "driveline/motion/cia301/pdo_configuration.hpp"
#include "driveline/motion/cia301/pdo_entry.hpp"
#include "driveline/motion/drive/probe_trigger.hpp"

namespace driveline::motion {

/// The touch probe of a drive as the master uses it: one event at a time, single trigger, according to CiA 402-2 (60B8h
/// to 60BDh; MSD manual 14.1.1, P 2285 = 1). A value that the drive latched before arming is never used: the drive must
/// first show that the probe is off, and then that it is on.
///
/// A plain value; everything except the constructor is \rtsafe.
class TouchProbe {
 public:
  /// Progress of a latch.
  enum class Phase : std::uint8_t {
    kOff,
    kClearing,  ///< waiting until the drive has cleared an earlier latch
    kArming,    ///< the drive has been commanded to arm
    kArmed,     ///< the drive waits for the event
    kLatched,   ///< value() is that of the event
  };

  /// `place` and `pdos` say where the objects lie in the image.
  TouchProbe(const ImagePlace& place, const PdoConfiguration& pdos);

  /// Whether the process data contain 60B8h, 60B9h and the value object of the event.
  [[nodiscard]] bool possible(ProbeTrigger trigger) const noexcept;
  /// Starts to latch the next event of this kind; discards an earlier one.
  void arm(ProbeTrigger trigger) noexcept;
  /// Switches the probe off.
  void disarm() noexcept { phase_ = Phase::kOff; }
  /// Phase as of the last exchange.
  [[nodiscard]] Phase phase() const noexcept { return phase_; }
  /// Position of the drive at the event, increments; valid in Phase::kLatched.
  [[nodiscard]] std::int32_t value() const noexcept { return value_; }

  /// Decodes the inputs of an exchange; `fresh` false: they are those of an earlier one.
  void read(std::span<const std::byte> image, bool fresh) noexcept;
  /// Writes 60B8h.
  void write(std::span<std::byte> image) const noexcept;

 private:
  [[nodiscard]] std::uint16_t function() const noexcept;

  std::optional<PdoEntry<std::uint16_t>> function_{};                 ///< 60B8h
  std::optional<PdoEntry<std::uint16_t>> status_{};                   ///< 60B9h
  std::array<std::optional<PdoEntry<std::int32_t>>, 4> positions_{};  ///< 60BAh to 60BDh
  ProbeTrigger trigger_ = ProbeTrigger::kFirstRising;
  Phase phase_ = Phase::kOff;
  std::int32_t value_ = 0;
};

}  // namespace driveline::motion

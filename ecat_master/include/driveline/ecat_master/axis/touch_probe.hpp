#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "driveline/ecat_master/axis/probe_trigger.hpp"
#include "driveline/ecat_master/process_data/pdo_configuration.hpp"
#include "driveline/ecat_master/process_data/pdo_entry.hpp"
#include "driveline/ecat_master/process_data/process_image.hpp"

namespace driveline::ecat_master {

/// The touch probe of a drive from the master's side: one event at a time, as CiA 402-2 has it (60B8h to 60BDh; MSD
/// manual 14.1.1, P 2285 = 1), single trigger. What the drive has latched before it was armed is never taken: it must
/// have shown first that it was switched off, and then that it is on.
///
/// A plain value; everything but the constructor is \rtsafe.
class TouchProbe {
 public:
  /// How far it is.
  enum class Phase : std::uint8_t {
    kOff,
    kClearing,  ///< what was latched before has to go
    kArming,    ///< the drive has been told
    kArmed,     ///< it waits for the event
    kLatched,   ///< value() is that of the event
  };

  /// `place` and `pdos` say where the objects lie in the image.
  TouchProbe(const ProcessDataPlace& place, const PdoConfiguration& pdos);

  /// Whether the process data hold 60B8h, 60B9h and the value of the event.
  [[nodiscard]] bool possible(ProbeTrigger trigger) const noexcept;
  /// The next event of this kind is to be latched; what was before is over.
  void arm(ProbeTrigger trigger) noexcept;
  /// No event is wanted.
  void disarm() noexcept { phase_ = Phase::kOff; }
  /// As of the last exchange.
  [[nodiscard]] Phase phase() const noexcept { return phase_; }
  /// Position of the drive at the event, increments; with Phase::kLatched.
  [[nodiscard]] std::int32_t value() const noexcept { return value_; }

  /// Takes over the inputs of an exchange; `fresh` false: they are those of an earlier one.
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

}  // namespace driveline::ecat_master

#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "driveline/ecat_master/configuration/process_variables.hpp"
#include "driveline/motion/single_axis/couplings.hpp"
#include "driveline/runtime/axes/coupling_order.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// Gears and cams of a line in operation. Made before the cycle starts; it must outlive the cycle. Afterwards any
/// thread may call it, with a lock of the caller held (AxisRequests has one).
class LineCouplings {
 public:
  /// Returns the age of the inputs of a slave when they arrive, by the number of its [[slave]].
  using InputAge = std::function<std::chrono::nanoseconds(std::size_t slave)>;

  /// `axes` and `config` must outlive it. Errors, with the place in the file: the process data do not contain the entry
  /// of an encoder, or the entry cannot be an encoder.
  [[nodiscard]] static Result<std::unique_ptr<LineCouplings>> make(const LineConfig& config, motion::SingleAxes& axes,
                                                                   const ecat_master::ProcessVariables& variables,
                                                                   const InputAge& input_age);
  LineCouplings(const LineCouplings&) = delete;
  LineCouplings& operator=(const LineCouplings&) = delete;

  /// Whether the axis is the slave of a [[coupling]].
  [[nodiscard]] bool has(std::size_t slave) const noexcept { return plan_.of(slave) != nullptr; }
  /// Whether the axis is coupled.
  [[nodiscard]] bool coupled(std::size_t slave) const noexcept;
  /// Forwards an order to the cycle. Returns its number; 0: the queue to the cycle is full, or there is no coupling to
  /// end.
  [[nodiscard]] std::uint64_t submit(std::size_t slave, const CouplingOrder& order);
  /// Returns what `report` means for the order `number`. A slave has reached its target only when it is synchronous;
  /// orders about the phase are known only here.
  [[nodiscard]] motion::RequestReport judge(std::size_t slave, std::uint64_t number,
                                            motion::RequestReport report) const;
  /// Whether the number is that of an order to shift the phase.
  [[nodiscard]] static bool is_phase(std::uint64_t number) noexcept { return (number & kPhaseBit) != 0; }
  /// Whether the cycle has taken the order to shift the phase with this number.
  [[nodiscard]] bool phase_taken(std::size_t slave, std::uint64_t number) const noexcept;
  /// Whether the number is that of the last order to couple the axis.
  [[nodiscard]] bool is_order(std::size_t slave, std::uint64_t number) const;
  /// Returns why the last coupling failed; kNone: its master no longer leads.
  [[nodiscard]] trajectory::CouplingRefusal refusal(std::size_t slave) const noexcept;
  /// Returns the state of the coupling; the axis must be the slave of a [[coupling]].
  [[nodiscard]] CouplingStatus status(std::size_t slave) const;

 private:
  /// Marks the numbers of phase orders, which are no requests of the axis.
  static constexpr std::uint64_t kPhaseBit = std::uint64_t{1} << 63;

  explicit LineCouplings(const LineConfig& config) : config_(config), plan_(config.couplings) {}
  [[nodiscard]] Result<void> add_signals(motion::SingleAxes& axes, const ecat_master::ProcessVariables& variables,
                                         const InputAge& input_age);
  [[nodiscard]] Result<void> add_encoder(const CouplingConfig& coupling, const ecat_master::ProcessVariables& variables,
                                         const InputAge& input_age);

  const LineConfig& config_;
  const CouplingPlan& plan_;
  std::vector<std::unique_ptr<motion::MasterSignal>> signals_;
  std::vector<motion::Couplings::Pair> pairs_;
  std::unique_ptr<motion::Couplings> couplings_;
  std::map<std::size_t, std::uint64_t> orders_;  ///< last coupling order of each slave
};

}  // namespace driveline::runtime

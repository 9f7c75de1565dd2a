#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "driveline/ecat_master/configuration/process_variables.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/ecat_master/single_axis/couplings.hpp"
#include "driveline/runtime/axes/coupling_order.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// The gears and cams of a line in operation. Made before the cycle starts; it must outlive that. Then any thread, with
/// a lock of the caller around it (AxisDoor has one).
class LineCouplings {
 public:
  /// `axes` must outlive it, and `config`, too. Errors, with the place in the file: an encoder that the process data do
  /// not have, or that cannot be one.
  [[nodiscard]] static Result<std::unique_ptr<LineCouplings>> make(const LineConfig& config,
                                                                   ecat_master::SingleAxes& axes,
                                                                   const ecat_master::ProcessVariables& variables,
                                                                   const ecat_master::Master& master);
  LineCouplings(const LineCouplings&) = delete;
  LineCouplings& operator=(const LineCouplings&) = delete;

  /// The axis is the slave of a [[coupling]].
  [[nodiscard]] bool has(std::size_t slave) const noexcept { return plan_.of(slave) != nullptr; }
  /// It is coupled.
  [[nodiscard]] bool coupled(std::size_t slave) const noexcept;
  /// Hands an order on: its number; 0: there are more than the cycle can take, or there is nothing to end.
  [[nodiscard]] std::uint64_t submit(std::size_t slave, const CouplingOrder& order);
  /// What `report` of the number of an order means: a slave that is led has reached what it was asked for when it is in
  /// synchronism, and orders of a phase are known here alone.
  [[nodiscard]] ecat_master::RequestReport judge(std::size_t slave, std::uint64_t number,
                                                 ecat_master::RequestReport report) const;
  /// Of an order to shift a phase.
  [[nodiscard]] static bool is_phase(std::uint64_t number) noexcept { return (number & kPhaseBit) != 0; }
  /// Of an order to be coupled, the last one.
  [[nodiscard]] bool is_order(std::size_t slave, std::uint64_t number) const;
  /// Why the last one came to nothing; kNone: its master leads no more.
  [[nodiscard]] trajectory::CouplingRefusal refusal(std::size_t slave) const noexcept;
  /// The axis is the slave of a [[coupling]].
  [[nodiscard]] CouplingStatus status(std::size_t slave) const;

 private:
  /// Of numbers of phases, which are no requests of the axis.
  static constexpr std::uint64_t kPhaseBit = std::uint64_t{1} << 63;

  explicit LineCouplings(const LineConfig& config) : config_(config), plan_(config.couplings) {}
  [[nodiscard]] Result<void> add_signals(ecat_master::SingleAxes& axes, const ecat_master::ProcessVariables& variables,
                                         const ecat_master::Master& master);
  [[nodiscard]] Result<void> add_encoder(const CouplingConfig& coupling, const ecat_master::ProcessVariables& variables,
                                         const ecat_master::Master& master);

  const LineConfig& config_;
  const CouplingPlan& plan_;
  std::vector<std::unique_ptr<ecat_master::MasterSignal>> signals_;
  std::vector<ecat_master::Couplings::Pair> pairs_;
  std::unique_ptr<ecat_master::Couplings> couplings_;
  std::map<std::size_t, std::uint64_t> orders_;  ///< the last one of each slave
};

}  // namespace driveline::runtime

#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "driveline/canopen_client/sdo_transfer.hpp"
#include "driveline/canopen_master/can_cycle.hpp"
#include "driveline/canopen_master/master_event.hpp"
#include "driveline/canopen_master/node_plan.hpp"
#include "driveline/canopen_master/node_view.hpp"
#include "driveline/canopen_master/pdo_image.hpp"
#include "driveline/canopen_port/can_port.hpp"
#include "driveline/motion/cycle/cycle_runner.hpp"
#include "driveline/motion/cycle/sample_rings.hpp"
#include "driveline/rt/clock.hpp"

namespace driveline::canopen {

/// The master of a CANopen line, from the first frame until its nodes are back in Pre-operational. Call the steps in
/// this order, each at most once:
///
///   boot -> start_cycle -> go_operational -> (supervise, pass ...) -> shut_down
///
/// Everything here runs on one ordinary thread, the owner's; the CycleRunner determines where the cycle runs. While it
/// runs, the cycle alone uses the port, and the frames of this class go through its rings. The cycle sends SYNC, the
/// RPDOs and the heartbeat of the master, so drives that expect one of them stop when the cycle dies, and go on when
/// only the owner's thread stands still. Node guarding, in contrast, comes from the owner: a node that is guarded stops
/// when nobody calls supervise() or pass() for its life time.
class CanMaster {
 public:
  /// How the line is taken over, and how it is recovered.
  struct Settings {
    /// Time of listening for another master before anything is sent; 0: none.
    std::chrono::nanoseconds listen = std::chrono::milliseconds{250};
    bool force = false;                                                    ///< boots although there is another master
    bool recover = true;                                                   ///< nodes that are lost are booted again
    std::chrono::nanoseconds retry_pause = std::chrono::seconds{1};        ///< between two tries for the same node
    std::chrono::nanoseconds first_pdos = std::chrono::milliseconds{500};  ///< from Operational until all TPDOs come
  };
  /// Told when a node begins a step: its number in the plan, and the step.
  using Progress = std::function<void(std::size_t node, BootStep step)>;
  /// Creates the runner for the cycle.
  using MakeRunner = std::function<std::unique_ptr<motion::CycleRunner>(CanCycle& cycle)>;

  /// Port and clock, which must be that of the port, must outlive the master.
  CanMaster(CanPort& port, rt::Clock& clock, MasterPlan plan, const Settings& settings);
  /// With the default settings.
  CanMaster(CanPort& port, rt::Clock& clock, MasterPlan plan) : CanMaster(port, clock, std::move(plan), Settings{}) {}
  CanMaster(const CanMaster&) = delete;
  CanMaster& operator=(const CanMaster&) = delete;
  /// Ends the cycle. Nothing is sent: call shut_down() before.
  ~CanMaster();

  /// Listens for another master, then boots all nodes side by side: reset communication, comparison of the identity,
  /// configuration. Nodes are in Pre-operational after that. Waits on the port. Errors: kBadPlan before anything is
  /// sent, kOtherMaster, and those of all nodes that are not optional.
  [[nodiscard]] MasterResult<void> boot(const Progress& progress = {});
  /// What nodes refused without stopping the start, since the last call.
  [[nodiscard]] NodeErrors take_notes();
  /// The plan; complete after boot(): where the plan left a mapping to the node, it has the mapping of the node.
  [[nodiscard]] const MasterPlan& plan() const noexcept;
  /// After boot(): the places of the process data.
  [[nodiscard]] const PdoImage& image() const noexcept;

  /// Starts the cycle: SYNC and the exchange of process data, with nodes in Pre-operational. Call after boot().
  /// `motion` may be null. Error: that of CycleRunner::start().
  [[nodiscard]] tl::expected<void, rt::RealtimeError> start_cycle(motion::MotionControl* motion,
                                                                  motion::SampleRings rings,
                                                                  const CanCycle::Settings& settings,
                                                                  const MakeRunner& make_runner);
  /// Starts the nodes (NMT) while the cycle runs, waits until each is Operational, which its heartbeat, its answer to
  /// node guarding or its TPDOs show, and until its TPDOs come. Errors: kWrongState, kNoPdo, and kBusDown.
  [[nodiscard]] MasterResult<void> go_operational();

  /// Lets the cycle run for `duration` and supervises meanwhile, at least every 5 ms.
  void pass(std::chrono::nanoseconds duration);
  /// Takes what the cycle has received, judges the nodes, sends what is due, and recovers nodes step by step. Never
  /// waits. Call it, or pass(), every 20 ms or more often while the cycle runs: each call moves an SDO transfer of a
  /// recovery forward by one answer.
  void supervise();
  /// The next event since the start of the cycle; empty: no more.
  [[nodiscard]] std::optional<MasterEvent> take_event();

  /// What is known of a node. Precondition: `node` is a number of the plan.
  [[nodiscard]] const NodeView& node(std::size_t node) const noexcept;
  /// Whether every node is Operational; optional ones that have never been there do not count.
  [[nodiscard]] bool all_operational() const noexcept;
  /// Recoveries of nodes that succeeded.
  [[nodiscard]] std::uint64_t recoveries() const noexcept;
  /// Counters and state of the port, also while the cycle has it.
  [[nodiscard]] PortStatistics port_statistics() const noexcept;

  /// Reads an object of a node, and waits, with supervision going on. A node that is being booted gets its transfer
  /// in between. Before start_cycle() and after shut_down() it waits on the port. Errors: any of ClientErrorKind.
  [[nodiscard]] ClientResult<std::vector<std::byte>> upload(std::size_t node, SdoObject object);
  /// Writes an object of a node, as upload().
  [[nodiscard]] ClientResult<void> download(std::size_t node, SdoObject object, std::span<const std::byte> data);

  /// While the cycle runs, and after it: the cycle; null before start_cycle().
  [[nodiscard]] CanCycle* cycle() noexcept;
  /// The runner of the cycle; null before start_cycle().
  [[nodiscard]] motion::CycleRunner* runner() noexcept;
  /// Whether start_cycle() has been called and shut_down() has not.
  [[nodiscard]] bool cycling() const noexcept;

  /// Takes the nodes to Pre-operational, ends their watch over the master, so that they do not report its loss, and
  /// ends the cycle, and SYNC with it. The axes must be at rest and off. Continues without nodes that do not answer;
  /// returns their errors.
  MasterResult<void> shut_down();

 private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace driveline::canopen

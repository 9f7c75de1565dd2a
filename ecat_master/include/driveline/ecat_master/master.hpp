#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "driveline/ecat_master/bus/direct_exchange.hpp"
#include "driveline/ecat_master/coe/emergency_log.hpp"
#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/configuration/register_guard.hpp"
#include "driveline/ecat_master/cyclic/cycle_runner.hpp"
#include "driveline/ecat_master/cyclic/cyclic_exchange.hpp"
#include "driveline/ecat_master/dc/clock_watch.hpp"
#include "driveline/ecat_master/discovery/topology.hpp"
#include "driveline/ecat_master/eoe/eoe_ports.hpp"
#include "driveline/ecat_master/soe/soe_log.hpp"
#include "driveline/ecat_master/state_machine.hpp"

namespace driveline::ecat_master {

struct PlaceClaim;

/// The master of one line, from first frame to INIT again. The steps are called in this order, each at most once
/// unless it failed:
///
///   scan -> configure -> start_cycle -> go_operational -> (monitor ...) -> shut_down
///
/// Everything here runs on an ordinary thread; the cycle runs wherever the CycleRunner runs it. Port and clock must
/// outlive the master. One thread at a time.
class Master {
 public:
  /// Time-outs and layout.
  struct Settings {
    DirectExchange::Settings exchange;                    ///< time-out and retries of frames
    std::chrono::nanoseconds state_timeout = kOpTimeout;  ///< for SAFEOP and OP, unless the plan says less
    LayoutSettings layout{};                              ///< how the process data are laid out
    std::chrono::nanoseconds clock_timeout = std::chrono::seconds{10};  ///< until the clocks are together
    /// Accept slaves that frames enter at another port than IN. Such a slave has another position on the line than the
    /// cabling suggests, so by default it is refused.
    bool accept_swapped_ports = false;
    /// Device descriptions for slaves whose plan has none (SlavePlan::esi), called with the slave as found; null: the
    /// EEPROM is used.
    std::function<std::shared_ptr<const esi::DeviceDescription>(const SlaveInfo&)> describe{};
  };

  /// Port and clock must outlive the master.
  Master(port::Port& port, rt::Clock& clock, const Settings& settings);
  /// With the default settings.
  Master(port::Port& port, rt::Clock& clock) : Master(port, clock, Settings{}) {}
  ~Master();

  /// AL status of all slaves by their position, without changing anything about them. Needs no scan().
  [[nodiscard]] Result<std::vector<AlReport>> peek_states();
  /// Whether another master drives the line.
  struct Owner {
    std::optional<std::uint16_t> in_op;  ///< the first slave in OP; none: nobody drives the line
    bool heard = false;                  ///< frames of another master have come in
  };
  /// Before scan(), without changing anything: while a slave is in OP, listens up to `patience` for another master. A
  /// line whose master has died falls out of OP by its watchdogs meanwhile, or stays there in silence. Errors: those of
  /// the bus.
  [[nodiscard]] Result<Owner> find_owner(std::chrono::nanoseconds patience);
  /// Finds the slaves. Leaves them in INIT.
  [[nodiscard]] Result<void> scan();
  /// After scan(): connections of the slaves. Empty for a line whose ports fit no tree.
  [[nodiscard]] const Topology& topology() const noexcept { return topology_; }
  /// From the next configure() on the clocks of the line are brought up in PREOP, cycle and reference clock are kept
  /// together, and go_operational() waits until they are locked.
  void use_clocks(dc::ClockPlan plan) { clock_plan_ = std::move(plan); }
  /// Tells the master that its port is `ring`, possibly behind a capture: clocks are then kept together also while the
  /// ring is open. `ring` must outlive the master.
  void use_ring(port::RedundantPort& ring) noexcept { ring_ = &ring; }
  /// After enter_pre_op(): brings up the clocks as configure() does, without process data. start_cycle() follows.
  [[nodiscard]] Result<void> synchronise_clocks();
  /// After scan(): compares the found slaves with `plans`, as configure() does, for callers that need the comparison
  /// before it. Errors: the first difference.
  [[nodiscard]] Result<void> match(std::span<const SlavePlan> plans);
  /// After match() or configure(): how the line differs from the plans, and which plan belongs to which slave.
  [[nodiscard]] const LineComparison& comparison() const noexcept { return comparison_; }
  /// After match() or configure(): position of the slave of plan number `plan`.
  [[nodiscard]] std::optional<std::size_t> position_of(std::size_t plan) const noexcept;
  /// Explicit device identifications of all slaves, into slaves()[n].info; after scan().
  [[nodiscard]] Result<void> identify_devices();
  /// Compares the found slaves with `plans` (position, alias or device ID; empty: any slaves, each with the process
  /// data that it has assigned by itself), configures them and takes them to SAFEOP. Starts from INIT, so that it may
  /// be repeated after an error.
  [[nodiscard]] Result<void> configure(std::vector<SlavePlan> plans);
  /// Sync managers of the mailboxes and PREOP only: enough for SDO transfers. Alternative to configure().
  [[nodiscard]] Result<void> enter_pre_op();

  /// After scan(): by position.
  [[nodiscard]] std::span<const ConfiguredSlave> slaves() const noexcept { return slaves_; }
  /// After configure(): where the process data of each slave lie.
  [[nodiscard]] const ProcessImage& image() const noexcept { return image_; }

  /// Makes the runner for the cycle of `core`.
  using MakeRunner = std::function<std::unique_ptr<CycleRunner>(CyclicCore& core)>;

  /// Starts the cyclic exchange in SAFEOP. `motion` may be null. Error: that of CycleRunner::start().
  [[nodiscard]] tl::expected<void, rt::RealtimeError> start_cycle(MotionControl* motion, SampleRings rings,
                                                                  CyclicCore::Settings settings,
                                                                  const MakeRunner& make_runner);
  /// SAFEOP to OP while the cycle runs and provides valid outputs. Errors: NoExchange when within 100 cycles (and 100
  /// ms) none has its first frame back in time. With clocks, first waits up to
  /// Settings::clock_timeout for the lock; errors then: NotLocked or NotSynchronised.
  [[nodiscard]] Result<void> go_operational();

  /// AL status of every slave, through the cycle while it runs; empty for slaves that have never been on the line.
  [[nodiscard]] Result<std::vector<AlReport>> al_status();
  /// AL status of one slave. Errors: WorkingCounter when it does not answer, those of the bus.
  [[nodiscard]] Result<AlReport> al_status_of(std::size_t slave);
  /// A slave that was given its station address back.
  struct Readdressed {
    std::uint16_t slave = 0;  ///< by its number
    std::uint16_t found = 0;  ///< the address it had
  };
  /// While the cycle runs: gives their station addresses back to slaves that were switched off or plugged in again, or
  /// whose address was written over. A slave is identified by its place in the wiring or, where that is ambiguous, its
  /// serial number; one with SlavePlan::hot_connect by its alias or device ID, one with SlavePlan::behind by its place
  /// behind that. A slave that may be several of the missing ones gets no address, and recover() of these returns
  /// PlaceUnknown. Errors: those of the bus.
  [[nodiscard]] Result<std::vector<Readdressed>> readdress_newcomers();
  /// While the cycle runs: takes one slave from any state back to OP; checks that it is the device it was before and
  /// configures it anew when it has lost its configuration. The others are not touched. Errors: IdentityMismatch, and
  /// the slave loses its station address; WorkingCounter when it does not answer, PlaceUnknown when a slave has come
  /// back that may be this one; those of configure().
  [[nodiscard]] Result<void> recover(std::size_t slave, std::chrono::nanoseconds state_timeout);
  /// After configure(): registers of a slave that no longer read as they were set up. Errors: WorkingCounter when not
  /// exactly one slave answers to its station address, those of the bus.
  [[nodiscard]] Result<std::vector<RegisterChange>> changed_registers(std::size_t slave);
  /// Lets the cycle run for `duration` (sleeps, or runs it on virtual time).
  void pass(std::chrono::nanoseconds duration);
  /// After configure() with clocks, else null.
  [[nodiscard]] const dc::LineClocks* clocks() const noexcept { return clocks_ ? &*clocks_ : nullptr; }
  /// While the cycle runs with clocks, else null. To be polled every few milliseconds.
  [[nodiscard]] dc::ClockWatch* clock_watch() noexcept { return watch_.get(); }
  /// While the cycle runs with clocks: dc::ClockWatch::remeasure_delays() with the slaves in the order in which they
  /// are on the line now. Errors: its own, those of the bus.
  [[nodiscard]] Result<void> remeasure_delays();
  /// While the cycle runs with clocks, else null.
  [[nodiscard]] dc::ClockFollower* clock_follower() noexcept { return follower_.get(); }
  /// While the cycle runs, else null.
  [[nodiscard]] CyclicCore* core() noexcept { return core_.get(); }
  /// While the cycle runs, else null.
  [[nodiscard]] CycleRunner* runner() noexcept { return runner_.get(); }
  /// Between start_cycle() and shut_down().
  [[nodiscard]] bool cycling() const noexcept { return cycling_; }
  /// Access for SDO transfers: through the cycle while it runs, directly otherwise. Null: no mailbox.
  [[nodiscard]] MailboxClient* mailbox(std::size_t slave) noexcept { return slaves_[slave].mailbox.get(); }
  /// The mailboxes of all slaves; any ordinary thread.
  [[nodiscard]] MailboxEngine& mailboxes() noexcept { return engine_; }
  /// Emergencies that slaves have sent; any ordinary thread.
  [[nodiscard]] EmergencyLog& emergencies() noexcept { return emergencies_; }
  /// Notifications and emergencies of SoE, of all slaves.
  [[nodiscard]] SoeLog& soe_messages() noexcept { return soe_messages_; }
  /// Ports of the slaves that Ethernet frames go through, from open_eoe() on; any ordinary thread.
  [[nodiscard]] EoePorts& eoe() noexcept { return eoe_; }
  /// The slave knows EoE, by its ESI or EEPROM.
  [[nodiscard]] bool supports_eoe(std::size_t slave) const noexcept;
  /// Opens the EoE port of a slave, which stays the same over recoveries: frames pass while the slave's mailboxes are
  /// open. `receiver` must outlive the master. Errors: NoEoe.
  [[nodiscard]] Result<std::shared_ptr<EoePort>> open_eoe(std::size_t slave, EoeReceiver& receiver);
  /// Access to registers and EEPROMs, through the cycle while it runs.
  [[nodiscard]] Bus& bus() noexcept { return bus_; }
  /// Frames of acyclic work outside the cycle.
  [[nodiscard]] const ExchangeStatistics& exchange_statistics() const noexcept { return direct_.statistics(); }

  /// All slaves by way of SAFEOP and PREOP to INIT, whatever state they are in; ends the cycle. Goes on after an error,
  /// without the slaves that do not answer, and returns the first. The motion must have been stopped before.
  Result<void> shut_down();

 private:
  /// Sends requests directly or through the cycle, whichever is possible now. Serialises the threads that use it.
  class SwitchedExchange final : public DatagramExchange {
   public:
    explicit SwitchedExchange(DatagramExchange& direct) noexcept : target_(&direct) {}
    void use(DatagramExchange& target) {
      const std::scoped_lock lock(mutex_);
      target_ = &target;
    }
    [[nodiscard]] Result<void> exchange(std::span<Request> requests) override {
      const std::scoped_lock lock(mutex_);
      return target_->exchange(requests);
    }
    [[nodiscard]] bool relays() const noexcept override {
      const std::scoped_lock lock(mutex_);
      return target_->relays();
    }
    [[nodiscard]] Result<void> relay(const Relay& relay) override {
      const std::scoped_lock lock(mutex_);
      return target_->relay(relay);
    }
    void pause(std::chrono::nanoseconds duration) override { target_->pause(duration); }
    [[nodiscard]] std::chrono::nanoseconds now() const noexcept override { return target_->now(); }

   private:
    mutable std::mutex mutex_;
    DatagramExchange* target_;
  };

  void drop_absent();
  void add_absent(std::size_t number, SlavePlan plan);
  [[nodiscard]] std::vector<SlaveRef> reachable() const;
  [[nodiscard]] Result<void> welcome(std::size_t slave);
  [[nodiscard]] Result<std::vector<std::optional<std::uint16_t>>> identify_newcomers(
      std::span<const std::uint16_t> positions);
  /// Pairs of position and slave for newcomers that are identified by the wiring or their serial numbers.
  [[nodiscard]] Result<std::vector<std::pair<std::size_t, std::size_t>>> place_by_wiring(
      std::span<const std::optional<std::size_t>> known);
  [[nodiscard]] Result<void> settle_claims(std::span<const PlaceClaim> claims,
                                           std::vector<std::pair<std::size_t, std::size_t>>& placed);
  [[nodiscard]] Result<std::vector<SlaveRef>> host(std::span<const std::uint16_t> positions);
  [[nodiscard]] Result<std::vector<std::uint32_t>> serials_of_newcomers(std::span<const std::uint16_t> positions);
  [[nodiscard]] Result<void> refuse(std::size_t slave, const Error& error);
  [[nodiscard]] Result<void> learn_facts();
  [[nodiscard]] Result<void> restore_registers(std::size_t slave);
  [[nodiscard]] Result<void> reconfigure(std::size_t slave, std::chrono::nanoseconds state_timeout);
  [[nodiscard]] Result<void> raise_to(wire::AlState target);
  /// Mailbox status bytes in the process data.
  class CycleMailboxStatus final : public MailboxStatusSource {
   public:
    explicit CycleMailboxStatus(const Master& master) noexcept : master_(master) {}
    [[nodiscard]] std::optional<MailboxStatusSample> mailbox_status(std::uint16_t position) const noexcept override;

   private:
    const Master& master_;
  };

  void stop_cycle();
  [[nodiscard]] Result<void> await_exchange();
  [[nodiscard]] Result<void> await_clocks();
  [[nodiscard]] Result<void> tell_sync_type(std::size_t slave);
  [[nodiscard]] Result<void> restore_clock(std::size_t slave);
  [[nodiscard]] Result<std::vector<SlaveRef>> wire_order();

  port::Port& port_;
  rt::Clock& clock_;
  Settings settings_;
  DirectExchange direct_;
  SwitchedExchange exchange_;
  Bus bus_;
  EmergencyLog emergencies_;
  SoeLog soe_messages_;
  EoePorts eoe_{engine_};
  MailboxEngine engine_;
  CycleMailboxStatus mailbox_status_{*this};
  std::vector<ConfiguredSlave> slaves_;
  std::vector<SlaveRef> refs_;
  std::vector<std::optional<Error>> unplaced_;  ///< why a slave that may have come back has no address
  std::vector<bool> unproven_;                  ///< got its address by its place; identity not checked yet
  std::vector<ControllerFacts> facts_;          ///< by position
  Topology topology_;
  LineComparison comparison_;
  ProcessImage image_;
  std::optional<dc::ClockPlan> clock_plan_;
  std::optional<dc::LineClocks> clocks_;
  port::RedundantPort* ring_ = nullptr;
  std::unique_ptr<dc::ClockFollower> follower_;
  std::unique_ptr<dc::ClockWatch> watch_;
  std::unique_ptr<CyclicCore> core_;
  std::unique_ptr<CycleRunner> runner_;
  bool cycling_ = false;
  std::unique_ptr<CyclicExchange> cyclic_;
};

}  // namespace driveline::ecat_master

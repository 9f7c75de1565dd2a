#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "driveline/ecat_master/bus/direct_exchange.hpp"
#include "driveline/ecat_master/coe/emergency_log.hpp"
#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/configuration/register_guard.hpp"
#include "driveline/ecat_master/cyclic/cyclic_core.hpp"
#include "driveline/ecat_master/cyclic/cyclic_exchange.hpp"
#include "driveline/ecat_master/dc/clock_watch.hpp"
#include "driveline/ecat_master/discovery/topology.hpp"
#include "driveline/ecat_master/eoe/eoe_ports.hpp"
#include "driveline/ecat_master/soe/soe_log.hpp"
#include "driveline/ecat_master/state_machine.hpp"
#include "driveline/motion/cycle/cycle_runner.hpp"

namespace driveline::ecat_master {

class Newcomers;

/// The master of a line, from the first frame until the slaves are back in INIT. Call the steps in this order, each at
/// most once unless it failed:
///
///   scan -> configure -> start_cycle -> go_operational -> (monitor ...) -> shut_down
///
/// Everything here runs on an ordinary thread; CycleRunner determines where the cycle runs. Port and clock must outlive
/// the master. One thread at a time.
class Master {
 public:
  /// Time-outs and layout of the process data.
  struct Settings {
    DirectExchange::Settings exchange;  ///< time-out and retries of frames
    /// Longest time for SAFEOP and OP; empty: rise_timeout() of each slave. When the line is shut down, the time-out of
    /// each lower state; empty: kOpTimeout.
    std::optional<std::chrono::nanoseconds> state_timeout{};
    LayoutSettings layout{};                                            ///< layout of the process data
    std::chrono::nanoseconds clock_timeout = std::chrono::seconds{10};  ///< until the clocks are synchronised
    /// Accept slaves that frames enter at another port than IN. Such a slave has another position on the line than the
    /// cabling suggests, so it is refused by default.
    bool accept_swapped_ports = false;
    /// Provides device descriptions for slaves whose plan has none (SlavePlan::esi), called with the slave as found;
    /// null: the EEPROM is used.
    std::function<std::shared_ptr<const esi::DeviceDescription>(const SlaveInfo&)> describe{};
  };

  /// Port and clock must outlive the master.
  Master(port::Port& port, rt::Clock& clock, const Settings& settings);
  /// With the default settings.
  Master(port::Port& port, rt::Clock& clock) : Master(port, clock, Settings{}) {}
  ~Master();

  /// AL status of all slaves by position, without changing anything in them. Needs no scan().
  [[nodiscard]] Result<std::vector<AlReport>> peek_states();
  /// Whether another master drives the line.
  struct Owner {
    std::optional<std::uint16_t> in_op;  ///< the first slave in OP; empty: no master drives the line
    bool heard = false;                  ///< frames of another master were received
  };
  /// Before scan(), without changing anything: while a slave is in OP, listens up to `timeout` for another master. A
  /// line whose master has died leaves OP by its watchdogs in the meantime, or stays in OP without frames. Errors:
  /// those of the bus.
  [[nodiscard]] Result<Owner> find_owner(std::chrono::nanoseconds timeout);
  /// Finds the slaves and leaves them in INIT.
  [[nodiscard]] Result<void> scan();
  /// After scan(): connections of the slaves. Empty for a line whose ports fit no tree.
  [[nodiscard]] const Topology& topology() const noexcept { return topology_; }
  /// From the next configure() on, the clocks of the line are brought up in PREOP, the cycle is synchronised with the
  /// reference clock, and go_operational() waits until they are locked.
  void use_clocks(dc::ClockPlan plan) { clock_plan_ = std::move(plan); }
  /// Tells the master that its port is `ring`, possibly behind a capture port: the clocks then stay synchronised while
  /// the ring is open. `ring` must outlive the master.
  void use_ring(port::RedundantPort& ring) noexcept { ring_ = &ring; }
  /// After enter_pre_op(): brings up the clocks as configure() does, without process data. Next step: start_cycle().
  [[nodiscard]] Result<void> synchronise_clocks();
  /// After scan(): compares the found slaves with `plans`, as configure() does, for callers that need the comparison
  /// earlier. Errors: the first difference.
  [[nodiscard]] Result<void> match(std::span<const SlavePlan> plans);
  /// After match() or configure(): the differences between line and plans, and the assignment of plans to slaves.
  [[nodiscard]] const LineComparison& comparison() const noexcept { return comparison_; }
  /// After match() or configure(): position of the slave for plan number `plan`.
  [[nodiscard]] std::optional<std::size_t> position_of(std::size_t plan) const noexcept;
  /// Reads the explicit device identifications of all slaves into slaves()[n].info; after scan().
  [[nodiscard]] Result<void> identify_devices();
  /// Compares the found slaves with `plans` (position, alias or device ID; empty: any slaves, each with the process
  /// data that it has assigned itself), configures them and takes them to SAFEOP. Starts from INIT, so it may be
  /// repeated after an error.
  [[nodiscard]] Result<void> configure(std::vector<SlavePlan> plans);
  /// Since the start of the last configure(): what slaves refused or did not show without stopping the start, also of
  /// slaves that were recovered later. Each once, in the order in which they occurred.
  [[nodiscard]] const StartupNotes& startup_notes() const noexcept { return startup_notes_; }
  /// Sets up only the sync managers of the mailboxes and takes the slaves to PREOP: enough for SDO transfers.
  /// Alternative to configure().
  [[nodiscard]] Result<void> enter_pre_op();

  /// After scan(): the slaves by position.
  [[nodiscard]] std::span<const ConfiguredSlave> slaves() const noexcept { return slaves_; }
  /// After configure(): the process image with the position of each slave's process data.
  [[nodiscard]] const ProcessImage& image() const noexcept { return image_; }

  /// Creates the runner for the cycle of `core`.
  using MakeRunner = std::function<std::unique_ptr<motion::CycleRunner>(CyclicCore& core)>;

  /// Starts the cyclic exchange in SAFEOP. `motion` may be null. Error: that of CycleRunner::start().
  [[nodiscard]] tl::expected<void, rt::RealtimeError> start_cycle(motion::MotionControl* motion,
                                                                  motion::SampleRings rings,
                                                                  CyclicCore::Settings settings,
                                                                  const MakeRunner& make_runner);
  /// Takes the slaves from SAFEOP to OP while the cycle runs and provides valid outputs. Errors: NoExchange when no
  /// cycle has its first frame back in time within 100 cycles (and 100 ms). With clocks, first waits up to
  /// Settings::clock_timeout for the lock; errors then: NotLocked or NotSynchronised.
  [[nodiscard]] Result<void> go_operational();

  /// AL status of every slave, read through the cycle while it runs; empty for slaves that have never been on the line.
  [[nodiscard]] Result<std::vector<AlReport>> al_status();
  /// AL status of a slave. Errors: WorkingCounter when it does not answer, those of the bus.
  [[nodiscard]] Result<AlReport> al_status_of(std::size_t slave);
  /// A slave whose station address was restored.
  struct Readdressed {
    std::uint16_t slave = 0;  ///< number of the slave
    std::uint16_t found = 0;  ///< the address it had before
  };
  /// While the cycle runs: restores the station addresses of slaves that were switched off, plugged in again, or whose
  /// address was overwritten. A slave is identified by its position in the wiring or, where that is ambiguous, by its
  /// serial number; with SlavePlan::hot_connect by its alias or device ID; with SlavePlan::behind by its place behind
  /// the head of its group. A slave that may be several of the missing slaves gets no address, and recover() of these
  /// returns PlaceUnknown. Errors: those of the bus.
  [[nodiscard]] Result<std::vector<Readdressed>> readdress_newcomers();
  /// While the cycle runs: takes a slave from any state back to OP; checks that it is the same device as before and
  /// reconfigures it when it has lost its configuration. Does not affect the other slaves. Errors: IdentityMismatch
  /// (the slave then loses its station address); WorkingCounter when it does not answer, PlaceUnknown when a slave has
  /// returned that may be this one; those of configure().
  [[nodiscard]] Result<void> recover(std::size_t slave, std::chrono::nanoseconds state_timeout);
  /// After configure(): registers of a slave that no longer have their configured values. Errors: WorkingCounter when
  /// not exactly one slave answers to its station address, those of the bus.
  [[nodiscard]] Result<std::vector<RegisterChange>> changed_registers(std::size_t slave);
  /// Lets the cycle run for `duration` (sleeps, or runs it on virtual time).
  void pass(std::chrono::nanoseconds duration);
  /// After configure() with clocks: the clocks, else null.
  [[nodiscard]] const dc::LineClocks* clocks() const noexcept { return clocks_ ? &*clocks_ : nullptr; }
  /// While the cycle runs with clocks: their supervision, else null. Poll it every few milliseconds.
  [[nodiscard]] dc::ClockWatch* clock_watch() noexcept { return watch_.get(); }
  /// While the cycle runs with clocks: dc::ClockWatch::remeasure_delays() with the slaves in their current order on the
  /// line. Errors: those of that function, those of the bus.
  [[nodiscard]] Result<void> remeasure_delays();
  /// While the cycle runs with clocks: the synchronisation of the cycle, else null.
  [[nodiscard]] dc::ClockFollower* clock_follower() noexcept { return follower_.get(); }
  /// While the cycle runs: its core, else null.
  [[nodiscard]] CyclicCore* core() noexcept { return core_.get(); }
  /// While the cycle runs: its runner, else null.
  [[nodiscard]] motion::CycleRunner* runner() noexcept { return runner_.get(); }
  /// Whether start_cycle() has been called and shut_down() has not.
  [[nodiscard]] bool cycling() const noexcept { return cycling_; }
  /// Access to SDO transfers: through the cycle while it runs, directly otherwise. Null: no mailbox.
  [[nodiscard]] MailboxClient* mailbox(std::size_t slave) noexcept { return slaves_[slave].mailbox.get(); }
  /// The mailboxes of all slaves; any ordinary thread.
  [[nodiscard]] MailboxEngine& mailboxes() noexcept { return engine_; }
  /// Emergencies received from slaves; any ordinary thread.
  [[nodiscard]] EmergencyLog& emergencies() noexcept { return emergencies_; }
  /// SoE notifications and emergencies of all slaves.
  [[nodiscard]] SoeLog& soe_messages() noexcept { return soe_messages_; }
  /// EoE ports of the slaves, after open_eoe(); any ordinary thread.
  [[nodiscard]] EoePorts& eoe() noexcept { return eoe_; }
  /// Whether the slave supports EoE, according to its ESI or EEPROM.
  [[nodiscard]] bool supports_eoe(std::size_t slave) const noexcept;
  /// Opens the EoE port of a slave, which persists across recoveries: frames pass while the slave's mailboxes are open.
  /// `receiver` must outlive the master. Errors: NoEoe.
  [[nodiscard]] Result<std::shared_ptr<EoePort>> open_eoe(std::size_t slave, EoeReceiver& receiver);
  /// Access to registers and EEPROMs, through the cycle while it runs.
  [[nodiscard]] Bus& bus() noexcept { return bus_; }
  /// Frame counters of acyclic access outside the cycle.
  [[nodiscard]] const ExchangeStatistics& exchange_statistics() const noexcept { return direct_.statistics(); }

  /// Takes all slaves through SAFEOP and PREOP to INIT, whatever their states, and ends the cycle. After an error
  /// continues without the slaves that do not answer; returns the first error. The motion must be stopped before.
  Result<void> shut_down();

 private:
  /// Sends requests directly or through the cycle, whichever is currently possible. Serialises the threads that use it;
  /// pauses of several threads overlap. A target that was replaced must exist until its pauses have ended.
  class SwitchedExchange final : public DatagramExchange {
   public:
    explicit SwitchedExchange(DatagramExchange& direct) noexcept : target_(&direct) {}
    void use(DatagramExchange& target) {
      const std::scoped_lock lock(mutex_);
      target_.store(&target, std::memory_order_release);
    }
    [[nodiscard]] Result<void> exchange(std::span<Request> requests) override {
      const std::scoped_lock lock(mutex_);
      return target().exchange(requests);
    }
    [[nodiscard]] bool relays() const noexcept override {
      const std::scoped_lock lock(mutex_);
      return target().relays();
    }
    [[nodiscard]] Result<void> relay(const Relay& relay) override {
      const std::scoped_lock lock(mutex_);
      return target().relay(relay);
    }
    void pause(std::chrono::nanoseconds duration) override { target().pause(duration); }
    [[nodiscard]] std::chrono::nanoseconds now() const noexcept override { return target().now(); }

   private:
    [[nodiscard]] DatagramExchange& target() const noexcept { return *target_.load(std::memory_order_acquire); }

    mutable std::mutex mutex_;
    std::atomic<DatagramExchange*> target_;
  };

  void drop_absent();
  void add_absent(std::size_t number, SlavePlan plan);
  [[nodiscard]] std::vector<SlaveRef> reachable() const;
  [[nodiscard]] Result<void> check_joining_slave(std::size_t slave);
  [[nodiscard]] Result<void> refuse(std::size_t slave, const Error& error);
  [[nodiscard]] Result<void> learn_facts();
  [[nodiscard]] Result<void> restore_registers(std::size_t slave);
  [[nodiscard]] Result<void> reconfigure(std::size_t slave, std::chrono::nanoseconds state_timeout);
  [[nodiscard]] Result<void> raise_to(wire::AlState target);
  [[nodiscard]] Error explain(const Error& error);
  [[nodiscard]] std::chrono::nanoseconds recovery_timeout(std::size_t slave, wire::AlState target,
                                                          std::chrono::nanoseconds timeout) const noexcept;
  [[nodiscard]] Result<void> restore_pdos(std::size_t slave, StartupNotes& notes);
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
  std::unique_ptr<Newcomers> newcomers_;  ///< null: no cycle has been started
  std::vector<ControllerFacts> facts_;    ///< by position
  Topology topology_;
  LineComparison comparison_;
  StartupNotes startup_notes_;
  ProcessImage image_;
  std::optional<dc::ClockPlan> clock_plan_;
  std::optional<dc::LineClocks> clocks_;
  port::RedundantPort* ring_ = nullptr;
  std::unique_ptr<dc::ClockFollower> follower_;
  std::unique_ptr<dc::ClockWatch> watch_;
  std::unique_ptr<CyclicCore> core_;
  std::unique_ptr<motion::CycleRunner> runner_;
  bool cycling_ = false;
  std::unique_ptr<CyclicExchange> cyclic_;
};

}  // namespace driveline::ecat_master

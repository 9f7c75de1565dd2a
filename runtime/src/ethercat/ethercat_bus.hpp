#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/line_bus.hpp"
#include "driveline/ecat_master/diagnosis/diagnosis.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/record/exchange_group_watch.hpp"
#include "driveline/runtime/record/sync_margins.hpp"
#include "driveline/runtime/setup/session.hpp"
#include "ethercat/line_services.hpp"
#include "ethercat/line_watch.hpp"
#include "telemetry/slave_watch.hpp"

namespace driveline::runtime {

/// An EtherCAT line. Can be used for one run.
class EtherCatBus final : public LineBus {
 public:
  /// `session` must outlive it.
  explicit EtherCatBus(Session& session);

  void listen(Listener listener) override { listener_ = std::move(listener); }
  [[nodiscard]] LineConfig& config() noexcept override { return config_; }
  [[nodiscard]] rt::Clock& clock() noexcept override { return session_.clock(); }
  [[nodiscard]] bool virtual_time() const noexcept override { return session_.virtual_time(); }
  [[nodiscard]] const std::string& state() const noexcept override { return state_; }
  [[nodiscard]] bool in_operation() const noexcept override { return watch_ != nullptr && master_.cycling(); }

  [[nodiscard]] Result<void> prepare() override { return services_.prepare(session_); }
  [[nodiscard]] Result<void> bring_up(bool force) override;
  [[nodiscard]] const NamedProcessData& process_data() const noexcept override { return *process_data_; }
  [[nodiscard]] std::vector<motion::Axis> make_axes() const override;
  [[nodiscard]] std::chrono::nanoseconds input_age(std::size_t slave) const override;
  [[nodiscard]] Result<void> start(const CycleParts& parts) override;
  [[nodiscard]] Result<void> start_services() override;

  void pass(std::chrono::nanoseconds duration) override { master_.pass(duration); }
  void count(bool on) noexcept override { master_.core()->count(on); }
  void begin_operation(LineMotion* motion) override;
  [[nodiscard]] bool look() override;
  void read_figures() override { margins_ = read_sync_margins(master_); }
  void end_operation() override;
  [[nodiscard]] bool answers() noexcept override { return master_.core()->al_status().slaves != 0; }

  void stop_services() override;
  [[nodiscard]] bool take_down() override;
  [[nodiscard]] const snapshot::FeedCondition* slaves(const std::vector<std::string>& owners, bool now) override;
  void report(RunReport& report) override;

  /// Diagnoses the line while it is in operation. The frames are sent in the gaps of the cycle.
  [[nodiscard]] ecat_master::Result<ecat_master::LineDiagnosis> diagnose();
  /// Returns the master of the line.
  [[nodiscard]] ecat_master::Master& master() noexcept { return master_; }
  /// Returns EoE and mailbox gateway of the line.
  [[nodiscard]] const LineServices& services() const noexcept { return services_; }

 private:
  [[nodiscard]] Result<void> must_be_free(bool force);
  [[nodiscard]] Result<void> find_slaves();
  [[nodiscard]] Result<void> bring_up_clocks();
  [[nodiscard]] Result<void> configure();
  [[nodiscard]] Result<void> ask_drives();
  [[nodiscard]] Result<void> name_process_data();
  void tell_startup_notes();
  void tell_services();
  void tell_traffic();
  /// Returns the facts, with the fault of the link if they are about lost communication.
  [[nodiscard]] EventFacts with_link(const EventFacts& facts) const;
  void report_clocks(RunReport& report);
  void tell(EventFacts facts, Severity severity) { listener_.tell(std::move(facts), severity); }
  void progress(EventFacts facts) { tell(std::move(facts), Severity::kProgress); }

  Session& session_;
  LineConfig config_;
  Listener listener_;
  ecat_master::Master master_;
  LineServices services_;
  ExchangeGroupWatch group_watch_;
  std::optional<NamedProcessData> process_data_;  ///< none: not configured yet
  std::optional<SlaveWatch> slave_watch_;         ///< none: slaves() has not been called yet
  std::unique_ptr<LineWatch> watch_;              ///< null: operation has not begun
  std::vector<SlaveMargin> margins_;              ///< as of the end of operation
  std::size_t startup_notes_told_ = 0;            ///< number of Master::startup_notes() that were told
  bool configured_ = false;                       ///< the slaves are in SAFEOP, or were
  std::string state_ = "INIT";
};

}  // namespace driveline::runtime

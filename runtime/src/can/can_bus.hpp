#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/line_bus.hpp"
#include "can/can_watch.hpp"
#include "can/node_feed.hpp"
#include "driveline/canopen_master/can_master.hpp"
#include "driveline/runtime/can/can_session.hpp"

namespace driveline::runtime {

/// A CAN line with a CANopen master. Can be used for one run.
class CanBus final : public LineBus {
 public:
  /// `session` must outlive it.
  explicit CanBus(CanSession& session);

  void listen(Listener listener) override { listener_ = std::move(listener); }
  [[nodiscard]] LineConfig& config() noexcept override { return config_; }
  [[nodiscard]] rt::Clock& clock() noexcept override { return session_.clock(); }
  [[nodiscard]] bool virtual_time() const noexcept override { return session_.virtual_time(); }
  [[nodiscard]] const std::string& state() const noexcept override { return state_; }
  [[nodiscard]] bool in_operation() const noexcept override { return watch_ != nullptr && master_->cycling(); }

  [[nodiscard]] Result<void> prepare() override { return {}; }
  [[nodiscard]] Result<void> bring_up(bool force) override;
  [[nodiscard]] const NamedProcessData& process_data() const noexcept override { return *process_data_; }
  [[nodiscard]] std::vector<motion::Axis> make_axes() const override;
  /// TPDOs have the values of their SYNC, and are used one period later, before the next one.
  [[nodiscard]] std::chrono::nanoseconds input_age(std::size_t /*slave*/) const override { return config_.period; }
  [[nodiscard]] bool lacks_velocity(std::size_t axis) const override;
  [[nodiscard]] Result<void> start(const CycleParts& parts) override;
  [[nodiscard]] Result<void> start_services() override { return {}; }

  void pass(std::chrono::nanoseconds duration) override { master_->pass(duration); }
  void count(bool on) noexcept override { master_->cycle()->count(on); }
  void begin_operation(LineMotion* motion) override;
  [[nodiscard]] bool look() override;
  void read_figures() override {}
  void end_operation() override;
  [[nodiscard]] bool answers() noexcept override;

  void stop_services() override {}
  [[nodiscard]] bool take_down() override;
  [[nodiscard]] const snapshot::FeedCondition* slaves(const std::vector<std::string>& owners, bool now) override;
  void report(RunReport& report) override;

  /// Returns the master of the line. Precondition: bring_up() has begun.
  [[nodiscard]] canopen::CanMaster& master() noexcept { return *master_; }

 private:
  [[nodiscard]] Result<void> boot();
  [[nodiscard]] Result<void> check_bus() const;
  [[nodiscard]] Result<void> ask_drives();
  [[nodiscard]] Result<void> ask_drive(motion::AxisConfig& axis);
  [[nodiscard]] Result<void> name_process_data();
  [[nodiscard]] std::size_t nodes_there() const;
  [[nodiscard]] bool was_lost(std::size_t node) const;
  void tell_notes();
  /// Returns the errors of nodes as one error of the line.
  [[nodiscard]] tl::unexpected<Error> fail_nodes(const canopen::NodeErrors& errors) const;
  [[nodiscard]] std::string name_of(std::size_t node) const;
  void tell(EventFacts facts, Severity severity) { listener_.tell(std::move(facts), severity); }
  void progress(EventFacts facts) { tell(std::move(facts), Severity::kProgress); }

  CanSession& session_;
  LineConfig config_;
  Listener listener_;
  std::unique_ptr<canopen::CanMaster> master_;
  canopen::BusBudget budget_;
  std::optional<NamedProcessData> process_data_;  ///< none: not configured yet
  std::optional<NodeFeed> feed_;                  ///< none: slaves() has not been called yet
  std::unique_ptr<CanWatch> watch_;               ///< null: operation has not begun
  std::string state_ = "Initialising";
};

}  // namespace driveline::runtime

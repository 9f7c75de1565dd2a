#include "driveline/runtime/line.hpp"

#include <fmt/format.h>

#include "can/can_bus.hpp"
#include "driveline/runtime/can/can_session.hpp"
#include "driveline/runtime/config/axis_path.hpp"
#include "ethercat/ethercat_bus.hpp"
#include "operation/line_run.hpp"

namespace driveline::runtime {
namespace {

BusOptions bus_of(const Line::Options& options) {
  BusOptions bus;
  bus.interface = options.interface;
  bus.interface2 = options.second_interface;
  bus.virtual_time = options.virtual_time;
  bus.cycle = true;
  return bus;
}

Result<std::unique_ptr<LineSession>> open_can(LineConfig config, const BusOptions& bus,
                                              const LineSession::Adjust& adjust) {
  if (!bus.interface2.empty()) {
    return fail(ErrorKind::kSetting, "is the second interface of a ring, and a CAN bus is none", "interface2");
  }
  auto session = CanSession::open(std::move(config), {bus.interface, bus.virtual_time}, adjust);
  if (!session) return tl::unexpected(session.error());
  return std::move(*session);
}

Result<std::unique_ptr<LineSession>> open_ethercat(std::optional<LineConfig> config, const BusOptions& bus,
                                                   const LineSession::Adjust& adjust) {
  auto session = config ? Session::open(std::move(*config), bus, adjust) : Session::open(bus, adjust);
  if (!session) return tl::unexpected(session.error());
  return std::move(*session);
}

}  // namespace

Line::Line(std::unique_ptr<LineSession> session, std::optional<trajectory::Interpolator> path)
    : session_(std::move(session)),
      ethercat_(dynamic_cast<Session*>(session_.get())),
      can_(dynamic_cast<CanSession*>(session_.get())),
      path_(std::move(path)),
      tasks_(std::make_unique<LineTasks>()),
      axis_requests_(session_->config().axes, real_time_, [this] { request_stop(); }),
      groups_(session_->config().axis_groups, axis_requests_) {}

Line::~Line() = default;

Result<std::unique_ptr<Line>> Line::from_file(const std::filesystem::path& file, const Options& options) {
  auto config = load_line_config(file, options.devices, options.mode);
  if (!config) return tl::unexpected(config.error());
  return open(std::move(*config), bus_of(options), options.adjust);
}

Result<std::unique_ptr<Line>> Line::from_config(LineConfig config, const Options& options) {
  return open(std::move(config), bus_of(options), options.adjust);
}

Result<std::unique_ptr<Line>> Line::from_interface(const std::string& interface, const Options& options) {
  auto bus = bus_of(options);
  bus.interface = interface;
  return open(std::nullopt, bus, options.adjust);
}

Result<std::unique_ptr<Line>> Line::open(std::optional<LineConfig> config, const BusOptions& bus,
                                         const Session::Adjust& adjust) {
  std::optional<trajectory::Interpolator> path;
  const auto complete = [&adjust, &path](LineConfig& read) -> Result<void> {
    if (auto adjusted = adjust ? adjust(read) : Result<void>{}; !adjusted) return adjusted;
    if (read.axes.empty()) return {};
    auto loaded = load_axis_path(read);
    if (!loaded) return tl::unexpected(loaded.error());
    path = std::move(*loaded);
    return {};
  };
  auto session = config && config->can ? open_can(std::move(*config), bus, complete)
                                       : open_ethercat(std::move(config), bus, complete);
  if (!session) return tl::unexpected(session.error());
  return std::unique_ptr<Line>(new Line(std::move(*session), std::move(path)));
}

Result<void> Line::use(motion::SetpointSource& source) {
  if (run_) return fail(ErrorKind::kCall, "the line has run: choose the source of setpoints before the run");
  const auto axes = config().axes.size();
  if (source.axis_count() != axes) {
    return fail(ErrorKind::kCall,
                fmt::format("the source of setpoints moves {} axes, the line has {}", source.axis_count(), axes));
  }
  if (tasks_->drive()) return fail(ErrorKind::kCall, "a task drives the axes and is their source of setpoints");
  source_ = &source;
  return {};
}

Result<void> Line::add(Task& task, TaskPlan plan) {
  if (run_) return fail(ErrorKind::kCall, "the line runs or has run: add tasks before the run");
  if (!plan.drives.empty() && source_ != nullptr) {
    return fail(ErrorKind::kCall,
                fmt::format("task \"{}\": the axes have another source of setpoints already", plan.name));
  }
  return tasks_->add(task, std::move(plan), config());
}

Result<void> Line::claim(bool force) {
  return session_->claim(force, "interrupt its line");
}

std::unique_ptr<LineBus> Line::make_bus() {
  if (can_ != nullptr) {
    auto bus = std::make_unique<CanBus>(*can_);
    can_bus_ = bus.get();
    return bus;
  }
  auto bus = std::make_unique<EtherCatBus>(*ethercat_);
  ethercat_bus_ = bus.get();
  return bus;
}

Result<RunReport> Line::run(const RunSettings& settings) {
  if (run_) return fail(ErrorKind::kCall, "the line has run before; create a new line for each run");
  if (auto claimed = claim(settings.force); !claimed) return tl::unexpected(claimed.error());
  bus_ = make_bus();
  run_ = std::make_unique<LineRun>(
      *bus_, RunMotion::Settings{std::move(path_), source_, &axis_requests_, &groups_, settings.enable, tasks_.get()},
      LineRun::Settings{settings.duration_s, settings.force, settings.telemetry, settings.trace, consumers_, observer_,
                        &stop_});
  auto report = run_->execute();
  if (report) {
    finish_capture(*report);
    return report;
  }
  static_cast<void>(session_->close_capture());
  return report;
}

/// A capture that could not be written becomes a failure in the report, so that the report is not lost.
void Line::finish_capture(RunReport& report) {
  const auto capture = session_->close_capture();
  if (!capture) {
    observer_->event(report.note_failure(capture.error()));
    return;
  }
  if (capture->file) report.files["capture"] = *capture->file;
  if (capture->dropped > 0) {
    observer_->event({events::CaptureIncomplete{capture->dropped, *session_->config().output.capture}});
  }
}

std::optional<EoeReport> Line::eoe() const {
  return ethercat_bus_ != nullptr ? ethercat_bus_->services().eoe() : std::nullopt;
}

ecat_master::Master* Line::master() noexcept {
  return ethercat_bus_ != nullptr && bus_->in_operation() ? &ethercat_bus_->master() : nullptr;
}

canopen::CanMaster* Line::can_master() noexcept {
  return can_bus_ != nullptr && bus_->in_operation() ? &can_bus_->master() : nullptr;
}

Result<ecat_master::LineDiagnosis> Line::diagnose() {
  if (!bus_ || !bus_->in_operation()) return fail(ErrorKind::kCall, "the line is not in operation");
  if (ethercat_bus_ == nullptr) {
    return fail(ErrorKind::kCall, "this diagnosis is that of EtherCAT, and the line is a CAN line");
  }
  auto diagnosis = ethercat_bus_->diagnose();
  if (!diagnosis) return fail_line(diagnosis.error());
  diagnosis->statistics = run_->figures();
  return std::move(*diagnosis);
}

}  // namespace driveline::runtime

#include "support/telemetry_run.hpp"

#include <fmt/format.h>
#include <fmt/ostream.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>

#include "support/child_program.hpp"
#include "support/realtime.hpp"
#include "support/retry.hpp"

namespace driveline::bench {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPollInterval{50};  // interval of reading the processes
constexpr milliseconds kDiscovery{300};    // lead of a reader before the line
constexpr milliseconds kBeforeStall{800};  // from the first sight of the bridge
constexpr milliseconds kStall{2000};
constexpr double kNsPerUs = 1000.0;

/// Resource use of a process, by repeated readings.
class Watched {
 public:
  void look(pid_t process) {
    const auto use = process == 0 ? std::nullopt : use_of(process);
    if (!use) return;
    // A process that is about to end reports no memory.
    peak_mib_ = std::max(peak_mib_, use->peak_mib);
    readings_.push_back({std::chrono::steady_clock::now(), use->cpu_s});
  }
  /// Largest share of a processor in any interval of this length (with at least two readings): that is while the line
  /// runs, not while it is discovered, brought up and ended.
  [[nodiscard]] double cpu_share(milliseconds length) const {
    double most = 0.0;
    for (std::size_t first = 0, last = 0; last < readings_.size(); ++last) {
      while (first < last && readings_[last].at - readings_[first + 1].at >= length) ++first;
      const std::chrono::duration<double> passed = readings_[last].at - readings_[first].at;
      if (passed < length) continue;
      most = std::max(most, (readings_[last].cpu_s - readings_[first].cpu_s) / passed.count());
    }
    return most;
  }
  [[nodiscard]] double peak_mib() const { return peak_mib_; }

 private:
  struct Reading {
    std::chrono::steady_clock::time_point at;
    double cpu_s;
  };
  std::vector<Reading> readings_;
  double peak_mib_ = 0.0;
};

std::unique_ptr<ChildProgram> started(const std::vector<std::string>& words) {
  auto program = ChildProgram::start(words);
  if (!program) throw std::runtime_error(words.front() + " is not there: build all");
  return program;
}

/// Stops the bridge once, and lets it continue.
class Stall {
 public:
  void look(pid_t bridge) {
    const auto now = std::chrono::steady_clock::now();
    if (bridge == 0 || over_) return;
    if (!seen_) seen_ = now;
    if (!stopped_ && now - *seen_ >= kBeforeStall) {
      ::kill(bridge, SIGSTOP);
      stopped_ = now;
    }
    if (!stopped_ || now - *stopped_ < kStall) return;
    ::kill(bridge, SIGCONT);
    over_ = true;
  }

 private:
  std::optional<std::chrono::steady_clock::time_point> seen_;
  std::optional<std::chrono::steady_clock::time_point> stopped_;
  bool over_ = false;
};

ReceivedTelemetry received(const std::string& text) {
  const auto document = nlohmann::json::parse(text);
  ReceivedTelemetry read;
  read.cycles = document.at("cycles");
  read.lost_batches = document.at("lost_batches");
  read.latency_us = document.at("latency_us").get<std::vector<double>>();
  read.skipped_cycles = document.at("skipped_cycles");
  return read;
}

TelemetryFigures figures_of(const std::string& text) {
  const auto document = nlohmann::json::parse(text);
  TelemetryFigures figures;
  figures.cycle_cost_p50_us = document.at("cycle_cost_ns").at("p50").get<double>() / kNsPerUs;
  figures.cycle_cost_p999_us = document.at("cycle_cost_ns").at("p999").get<double>() / kNsPerUs;
  figures.wake_latency_p999_us = document.at("wake_latency_ns").at("p999").get<double>() / kNsPerUs;
  figures.missed_periods = document.at("missed_periods");
  if (const auto telemetry = document.find("telemetry"); telemetry != document.end() && telemetry->is_object()) {
    figures.published = telemetry->at("published");
    figures.dropped = telemetry->at("dropped");
  }
  return figures;
}

/// A path of 20 seconds at 100 Hz; a run uses as much as it needs.
void write_path(const std::filesystem::path& file, std::size_t axes) {
  constexpr int kPathPoints = 2000;
  constexpr double kStep = 0.01;
  std::ofstream path(file);
  path << "time[s]";
  for (std::size_t i = 0; i < axes; ++i) fmt::print(path, ",a{}[rad]", i);
  path << '\n';
  for (int point = 0; point <= kPathPoints; ++point) {
    const double time = point * kStep;
    fmt::print(path, "{}", time);
    for (std::size_t i = 0; i < axes; ++i)
      fmt::print(path, ",{}", 1.0 - std::cos(time * (1.0 + 0.1 * static_cast<double>(i % 8))));
    path << '\n';
  }
}

}  // namespace

TelemetryRuns::TelemetryRuns()
    : programs_(std::filesystem::read_symlink("/proc/self/exe").parent_path()),
      domain_(50U + static_cast<unsigned>(::getpid()) % 50U) {
  auto name = (std::filesystem::temp_directory_path() / "driveline-telemetry-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr)
    throw std::runtime_error("no folder can be made in the one for temporary files");
  folder_ = name;
}

TelemetryRuns::~TelemetryRuns() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

std::filesystem::path TelemetryRuns::describe(std::size_t axes) const {
  auto file = folder_ / fmt::format("line{}.toml", axes);
  if (std::filesystem::exists(file)) return file;
  const auto path = fmt::format("line{}.csv", axes);
  write_path(folder_ / path, axes);
  std::ofstream out(file);
  fmt::print(out,
             "[line]\nname = \"telemetry\"\ncycle_us = 125\n[bus]\nmax_lost_ms = 200\n"
             "[realtime]\npolicy = \"degrade\"\npriority = 80\ncpu = {}\nwake_ahead_us = {}\n"
             "[path]\nfile = \"{}\"\ninterpolation = \"clamped\"\n[telemetry]\ndomain = {}\n",
             last_cpu(), kWakeAhead.count(), path, domain_);
  for (std::size_t i = 0; i < axes; ++i) {
    fmt::print(out,
               "[[slave]]\nname = \"a{0}\"\nmodel = \"msd\"\n"
               "[[axis]]\nname = \"a{0}\"\nmax_velocity = 200.0\nmax_acceleration = 2500.0\n",
               i);
  }
  return file;
}

TelemetryFigures TelemetryRuns::measure(const TelemetryPlan& plan) {
  std::unique_ptr<ChildProgram> reader;
  if (plan.reader) {
    const auto* name = *plan.reader == TelemetryReader::kFastDds ? "fast_dds_reader" : "cyclone_reader";
    reader = started(std::vector<std::string>{programs_ / "telemetry_reader" / name, std::to_string(domain_)});
    std::this_thread::sleep_for(kDiscovery);
  }
  const auto run = started({programs_.parent_path() / "driveline", "run", "--config", describe(plan.axes), "--duration",
                            fmt::format("{:.3f}", std::chrono::duration<double>(plan.duration).count()), "--json",
                            plan.telemetry ? "--telemetry" : "--no-telemetry"});
  Watched line;
  Watched bridge;
  Watched receiver;
  Stall stall;
  for (pid_t publisher = 0; !run->has_ended(); std::this_thread::sleep_for(kPollInterval)) {
    if (publisher == 0) publisher = child_named(run->id(), "driveline-bridge");
    line.look(run->id());
    bridge.look(publisher);
    if (reader) receiver.look(reader->id());
    if (plan.stall) stall.look(publisher);
  }
  std::string report;
  try {
    report = run->finish();
  } catch (const std::runtime_error& reason) {
    throw Disturbed(reason.what());
  }
  auto figures = figures_of(report);
  figures.run_mib = line.peak_mib();
  figures.bridge_mib = bridge.peak_mib();
  // Most of the time in which the line ran, because the readings are not exactly on time.
  const auto most = plan.duration * 3 / 4;
  figures.bridge_cpu_share = bridge.cpu_share(most);
  if (reader) {
    reader->signal(SIGTERM);
    figures.received = received(reader->finish());
    figures.received->cpu_share = receiver.cpu_share(most);
  }
  return figures;
}

}  // namespace driveline::bench

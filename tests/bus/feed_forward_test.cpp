// Errors of an axis on its path with and without feed-forward and compensation of the dead time, and the load found by
// a test motion, on the simulated drive with friction and a weight.
#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "driveline/motion/path/path_source.hpp"
#include "driveline/runtime/identify/load_estimate.hpp"
#include "driveline/runtime/identify/test_motion.hpp"
#include "driveline/runtime/line.hpp"
#include "driveline/snapshot/sample_consumer.hpp"
#include "support/must.hpp"

namespace driveline::bus_test {
namespace {

/// The load on the simulated shaft.
constexpr double kInertia = 6e-4;
constexpr double kViscous = 2e-3;
constexpr double kCoulomb = 0.15;
constexpr double kGravity = 0.8;
/// Time before the path moves. Without a brake the weight has begun to fall when the drive gets power.
constexpr int kRestMs = 400;
constexpr std::size_t kCaughtMs = 300;

runtime::Line::Options on_virtual_time() {
  runtime::Line::Options options;
  options.virtual_time = true;
  return options;
}

/// Errors of the axis from the setpoint that its drive has followed, and from the path, after the weight has been
/// caught.
class PathErrors final : public snapshot::SampleConsumer {
 public:
  /// `lead`: lead of the setpoints over the path, in cycles.
  explicit PathErrors(std::size_t lead) : lead_(lead) {}
  void lines(std::span<const snapshot::LineSample>) override {}
  void axes(std::span<const snapshot::AxisSample> samples) override {
    for (const auto& sample : samples) {
      if (sample.state != snapshot::AxisState::kOperationEnabled) continue;
      targets_.push_back(sample.target_position);
      if (targets_.size() <= kCaughtMs) continue;
      ++count_;
      following_ += std::pow(sample.following_error, 2);
      path_ += std::pow(targets_[targets_.size() - 1 - lead_] - sample.actual_position, 2);
    }
  }
  /// RMS, rad
  [[nodiscard]] double following() const { return std::sqrt(following_ / count_); }
  [[nodiscard]] double path() const { return std::sqrt(path_ / count_); }

 private:
  std::size_t lead_;
  std::vector<double> targets_;
  double count_ = 0.0;
  double following_ = 0.0;
  double path_ = 0.0;
};

class FeedForwardLine : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_);
    std::ofstream path(folder_ / "path.csv");
    path << "time[s],x[rad]\n";
    // 1 kHz, from rest to rest, at most 24 rad/s and 395 rad/s^2. Before that the drive catches the weight.
    for (int i = -kRestMs; i <= 1000; ++i) {
      const double t = std::max(i, 0) / 1000.0;
      path << (i + kRestMs) / 1000.0 << ","
           << 2.5 * std::pow(std::sin(3.14159265358979 * t), 2) * (1.0 - std::cos(12.5663706143592 * t)) << "\n";
    }
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// A line with an MSD; `path` and `axis` are further keys of these tables, `sdos` further tables of the slave.
  [[nodiscard]] std::unique_ptr<runtime::Line> line(const std::string& path, const std::string& axis,
                                                    const std::string& sdos = {}) {
    const auto file = folder_ / "line.toml";
    std::ofstream(file)
        << "[line]\ncycle_us = 1000\n[telemetry]\nenabled = false\n[output]\nplots = false\ndirectory = \""
        << (folder_ / "out").string() << "\"\n[[slave]]\nname = \"x\"\n[slave.plant]\ninertia_kg_m2 = " << kInertia
        << "\nviscous_friction_nm_s = " << kViscous << "\ncoulomb_friction_nm = " << kCoulomb
        << "\n[slave.plant.load]\ngravity_nm = " << kGravity << "\n"
        << sdos << "[[axis]]\nname = \"x\"\nmax_velocity = 100\n"
        << axis << path;
    auto opened = runtime::Line::from_file(file, on_virtual_time());
    if (!opened) throw std::runtime_error(describe(opened.error()));
    return std::move(*opened);
  }

  struct Errors {
    double following = 0.0;  ///< RMS of the following error, rad
    double path = 0.0;       ///< RMS of the path error, rad
  };
  [[nodiscard]] Errors run(const std::string& dead_time, const std::string& axis, const std::string& sdos = {},
                           std::size_t dead_cycles = 3) {
    PathErrors errors(dead_time == "none" ? 0 : dead_cycles);
    const auto running = line("[path]\nfile = \"path.csv\"\ndead_time = \"" + dead_time + "\"\n", axis, sdos);
    running->add(errors);
    const auto report = running->run();
    if (!report) throw std::runtime_error(describe(report.error()));
    if (report->failure() != nullptr) throw std::runtime_error(describe(*report->failure(), false));
    return {errors.following(), errors.path()};
  }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("driveline_feed_forward_" + std::to_string(::getpid()));
};

constexpr auto kNoInertia = "[[slave.sdo]]\nindex = 0x25EC\ntype = \"float\"\nvalue = 0\n";
constexpr auto kLinearDrive = "[[slave.sdo]]\nindex = 0x2172\ntype = \"uint8\"\nvalue = 1\n";
constexpr auto kLoad = "inertia = 6e-4\nviscous_friction = 2e-3\ncoulomb_friction = 0.15\ngravity = 0.8\n";

TEST_F(FeedForwardLine, BringsAnAxisNearerToItsPath) {
  for (const bool linear : {false, true}) {
    const auto sdos = linear ? kLinearDrive : std::string{};
    const std::string delay = linear ? "setpoint_delay_cycles = 2\n" : "";
    const std::size_t dead = linear ? 2 : 3;
    const auto nothing = run("none", delay, sdos + kNoInertia);
    const auto fed = run("none", delay + kLoad, sdos);
    const auto compensated = run("compensated", delay, sdos + kNoInertia, dead);
    const auto both = run("compensated", delay + kLoad, sdos, dead);
    const auto all = [&](double Errors::*error) {
      return testing::PrintToString(std::array{nothing.*error, fed.*error, compensated.*error, both.*error});
    };
    SCOPED_TRACE((linear ? "linear, following " : "spline, following ") + all(&Errors::following) + ", path " +
                 all(&Errors::path));
    EXPECT_LT(fed.following, 0.5 * nothing.following);
    EXPECT_LT(both.following, 0.5 * compensated.following);
    EXPECT_LT(compensated.path, 0.05 * nothing.path);
    EXPECT_LT(both.path, 0.05 * fed.path);
    EXPECT_LT(both.path, 0.5 * compensated.path);
    EXPECT_NEAR(compensated.following, nothing.following, 0.05 * nothing.following)
        << "the drive follows its setpoints as it did";
    EXPECT_NEAR(compensated.path, compensated.following, 1e-9);
  }
}

/// In CSV the velocity, delayed by bus and drive, causes more error than friction does.
TEST_F(FeedForwardLine, HelpsWhereTheMasterClosesThePositionLoop) {
  for (const std::string mode : {"csv", "cst"}) {
    const auto axis = "mode = \"" + mode + "\"\nvelocity_gain = 0.1\nposition_tolerance = 1\n";
    const auto nothing = run("none", axis);
    const auto fed = run("none", axis + kLoad);
    SCOPED_TRACE(mode + ", following " + testing::PrintToString(std::array{nothing.following, fed.following}));
    EXPECT_LT(fed.following, (mode == "cst" ? 0.5 : 1.0) * nothing.following);
  }
}

/// These PDOs are fixed by the drive, which maps nothing in them: the master knows that only after reading them.
TEST_F(FeedForwardLine, ADriveWithoutTheObjectIsRefused) {
  const auto running = line("", "gravity = 0.8\n", "[[slave.pdo]]\nindex = 0x1600\n[[slave.pdo]]\nindex = 0x1A00\n");
  const auto report = running->run();
  ASSERT_FALSE(report);
  EXPECT_THAT(describe(report.error()),
              testing::StartsWith("axis x, slave 0 (x): csp with a feed-forward of friction or gravity needs "));
  EXPECT_THAT(describe(report.error()), testing::HasSubstr("60B2h (Torque offset, 16 bits) in an RxPDO"));
}

/// The largest distance between two axes at the same instant.
class Distance final : public snapshot::SampleConsumer {
 public:
  void lines(std::span<const snapshot::LineSample>) override {}
  void axes(std::span<const snapshot::AxisSample> samples) override {
    for (const auto& sample : samples) {
      if (sample.state != snapshot::AxisState::kOperationEnabled) continue;
      if (sample.axis == 0) first_ = sample;
      if (sample.axis == 1 && first_.cycle == sample.cycle)
        largest = std::max(largest, std::abs(sample.actual_position - first_.actual_position));
    }
  }
  double largest = 0.0;

 private:
  snapshot::AxisSample first_{};
};

TEST_F(FeedForwardLine, AxesOfDifferentDrivesAreAtTheSamePlaceAtTheSameInstant) {
  const auto distance = [this](const std::string& dead_time) {
    const auto file = folder_ / "line.toml";
    std::ofstream(folder_ / "both.csv") << [this] {
      std::ifstream one(folder_ / "path.csv");
      std::string both;
      for (std::string row; std::getline(one, row);) {
        const auto position = row.substr(row.find(','));
        both += row + (position == ",x[rad]" ? ",y[rad]" : position) + "\n";
      }
      return both;
    }();
    std::ofstream(file)
        << "[line]\ncycle_us = 1000\n[telemetry]\nenabled = false\n[output]\nplots = false\ndirectory = \""
        << (folder_ / "out").string() << "\"\n[path]\nfile = \"both.csv\"\ndead_time = \"" << dead_time
        << "\"\n[[slave]]\nname = \"x\"\n[[slave]]\nname = \"y\"\n"
        << kLinearDrive
        << "[[axis]]\nname = \"x\"\ninertia = 3e-4\n[[axis]]\nname = \"y\"\nsetpoint_delay_cycles = 2\n"
           "inertia = 3e-4\ncoulomb_friction = 0.03\n";
    auto opened = runtime::Line::from_file(file, on_virtual_time());
    if (!opened) throw std::runtime_error(describe(opened.error()));
    Distance between;
    (*opened)->add(between);
    const auto report = (*opened)->run();
    EXPECT_TRUE(report && report->failure() == nullptr);
    return between.largest;
  };
  // One drive is a cycle later than the other: a millisecond at 20 rad/s and more.
  EXPECT_GT(distance("none"), 0.015);
  EXPECT_LT(distance("compensated"), 0.004);
}

/// Records position and torque of the axis.
class Records final : public snapshot::SampleConsumer {
 public:
  void lines(std::span<const snapshot::LineSample>) override {}
  void axes(std::span<const snapshot::AxisSample> samples) override {
    for (const auto& sample : samples) {
      if (sample.state == snapshot::AxisState::kOperationEnabled)
        list.push_back({static_cast<double>(sample.time_ns) * 1e-9, sample.actual_position, sample.actual_torque});
    }
  }
  std::vector<runtime::LoadSample> list;
};

TEST_F(FeedForwardLine, ATestMotionFindsTheLoad) {
  const auto running = line("", "");
  const auto& axis = running->config().axes.front();
  auto path = must(runtime::make_test_path({12.0, 80.0, 1000.0}, axis));
  motion::PathSource source(std::move(*path), std::span(&axis.limits, 1), motion::LatePolicy::kStay);
  ASSERT_TRUE(running->use(source));
  Records records;
  running->add(records);
  ASSERT_EQ(failure_text(running->run()), "");
  const auto load = must(runtime::estimate_load(records.list, {}));
  EXPECT_NEAR(load->inertia.value, kInertia, 0.02 * kInertia);
  EXPECT_NEAR(load->viscous_friction.value, kViscous, 0.05 * kViscous);
  EXPECT_NEAR(load->coulomb_friction.value, kCoulomb, 0.03 * kCoulomb);
  EXPECT_NEAR(load->gravity.value, kGravity, 0.01 * kGravity);
  EXPECT_LT(load->inertia.interval, 0.02 * kInertia);
  EXPECT_LT(load->residual_rms, 0.02 * load->torque_rms);
}

}  // namespace
}  // namespace driveline::bus_test

// Two axes in one slave: their keys in a line description, their objects, and their motion on virtual time.
#include <gmock/gmock.h>

#include <cmath>

#include "driveline/runtime/setup/composition.hpp"
#include "failure_of.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"
#include "virtual_line.hpp"

namespace driveline::runtime {
namespace {

using testing::HasSubstr;

constexpr auto kSlave = "[[slave]]\nname = \"dual\"\nesi = \"" DRIVELINE_EXAMPLES_DIR "/dual_drive.xml\"\n";
constexpr auto kLeft =
    "[[axis]]\nname = \"left\"\nslave = \"dual\"\nunit = \"deg\"\nincrements_per_revolution = 65536\n"
    "max_velocity = 720\nmax_acceleration = 7200\n";
constexpr auto kRight =
    "[[axis]]\nname = \"right\"\nslave = \"dual\"\ndrive = 1\nunit = \"mm\"\nincrements_per_revolution = 20000\n"
    "feed_mm_per_revolution = 5\nmax_velocity = 250\nmax_acceleration = 2500\n";

/// The latest sample of each axis, and the largest following error.
class Samples final : public snapshot::SampleConsumer {
 public:
  void lines(std::span<const snapshot::LineSample>) override {}
  void axes(std::span<const snapshot::AxisSample> samples) override {
    for (const auto& sample : samples) {
      last.at(sample.axis) = sample;
      auto& most = error.at(sample.axis);
      if (sample.state == snapshot::AxisState::kOperationEnabled) {
        most = std::max(most, std::abs(sample.following_error));
        errors_seen += sample.error_code != 0 ? 1U : 0U;
      }
      if (sample.state == snapshot::AxisState::kFault) ++faults.at(sample.axis);
    }
  }
  void set_line_status(const snapshot::LineStatus&) override {}

  std::array<snapshot::AxisSample, 2> last{};
  std::array<double, 2> error{};
  std::array<int, 2> faults{};
  unsigned errors_seen = 0;
};

class DualDriveLine : public test::TemporaryDirectory {
 protected:
  std::string error(const std::string& text) const {
    const auto config = parse_line_config(text, "line.toml");
    return config ? "no error" : describe(config.error());
  }
  /// Runs a path of 2 s, by which `left` turns by 180 deg and `right` goes back by 30 mm, and takes the samples.
  RunReport run(const std::string& more) {
    write(directory / "path.csv", "time[s],left[deg],right[mm]\n0,0,0\n1,100,-20\n2,180,-30\n");
    auto line = must(virtual_line("[line]\ncycle_us = 1000\n" + std::string(kSlave) + kLeft + kRight +
                                      "[path]\nfile = \"path.csv\"\nrelative = true\n" + more,
                                  directory));
    (*line)->add(samples);
    return *must((*line)->run());
  }
  Samples samples;
};

TEST_F(DualDriveLine, EachAxisWritesTheStartUpObjectsOfItsDrive) {
  const auto config = must(parse_line_config(std::string(kSlave) + kLeft + kRight, "line.toml"));
  EXPECT_EQ(config->axes[0].drive, 0);
  EXPECT_EQ(config->axes[1].drive, 1);
  const auto plan = make_slave_plans(*config).at(0);
  EXPECT_TRUE(plan.own_pdos);
  std::vector<std::uint16_t> written;
  for (const auto& sdo : plan.startup_sdos) written.push_back(sdo.index);
  EXPECT_EQ(written, (std::vector<std::uint16_t>{0x60C2, 0x60C2, 0x6060, 0x68C2, 0x68C2, 0x6860}));
}

TEST_F(DualDriveLine, TheNeedOfTheInterpolationTimeHoldsForBoth) {
  const auto config = must(parse_line_config(
      std::string(kSlave) + "startup = { interpolation_time = \"omit\" }\n" + kLeft + kRight, "line.toml"));
  const auto plan = make_slave_plans(*config).at(0);
  std::vector<std::uint16_t> omitted;
  for (const auto& sdo : plan.startup_sdos) {
    if (sdo.need == motion::WriteNeed::kOmitted) omitted.push_back(sdo.index);
  }
  EXPECT_EQ(omitted, (std::vector<std::uint16_t>{0x60C2, 0x60C2, 0x68C2, 0x68C2}));
}

TEST_F(DualDriveLine, WrongNumbersOfDrives) {
  const auto dual = std::string(kSlave) + kLeft;
  EXPECT_EQ(error(dual + "drive = 2\n"), "line.toml:11: [axis 1] drive: \"dual\" has 2 drives, 0 to 1 is expected");
  EXPECT_EQ(error(dual + "drive = 8\n"), "line.toml:11: [axis 1] drive: is 8, 0 to 7 is expected");
  EXPECT_EQ(error(dual + kRight + "[[axis]]\nname = \"third\"\nslave = \"dual\"\ndrive = 1\n"),
            "line.toml:23: [axis 3] drive: drive 1 of \"dual\" already belongs to the axis \"right\"");
  EXPECT_EQ(error(dual + "[[axis]]\nname = \"third\"\nslave = \"dual\"\n"),
            "line.toml:13: [axis 2] slave: drive 0 of \"dual\" already belongs to the axis \"left\"");
  EXPECT_EQ(error("[[slave]]\nname = \"x\"\n[[axis]]\nname = \"x\"\ndrive = 1\n"),
            "line.toml:5: [axis 1] drive: \"x\" has one drive, 0 is expected");
}

TEST_F(DualDriveLine, ADriveOfAnUnknownDeviceNeedsItsObjects) {
  const auto foreign =
      "[[slave]]\nname = \"x\"\nvendor_id = 0x77\nproduct_code = 3\npdo = [\n"
      "  { index = 0x1600, entries = [\"0x6040:0:16\", \"0x607A:0:32\", \"0x6840:0:16\"] },\n"
      "  { index = 0x1A00, entries = [\"0x6041:0:16\", \"0x6064:0:32\", \"0x6841:0:16\", \"0x6864:0:32\"] } ]\n"
      "[[axis]]\nname = \"x\"\n";
  EXPECT_EQ(error(foreign), "no error");
  EXPECT_EQ(error(foreign + std::string("drive = 1\n")),
            "line.toml:8: [axis 1] slave: the [[slave.pdo]] of \"x\" are not enough: csp needs 687Ah (Target position, "
            "32 bits) in an RxPDO; the RxPDOs map 6040h, 607Ah, 6840h");
}

TEST_F(DualDriveLine, EachDriveReportsItsOwnModes) {
  auto file = read(std::filesystem::path(DRIVELINE_EXAMPLES_DIR) / "dual_drive.xml");
  const auto second = file.find("<DefaultData>80010000", file.find("#x6d02"));
  ASSERT_NE(second, std::string::npos);
  file.replace(second, 21, "<DefaultData>80000000");  // only csp
  write(directory / "dual.xml", file);
  const auto run = [&](const std::string& modes) {
    const auto line = must(
        virtual_line("[line]\ncycle_us = 1000\n[[slave]]\nname = \"dual\"\nesi = \"dual.xml\"\n" + modes, directory));
    const auto report = (*line)->run({.duration_s = 0.1, .force = false});
    return report ? "" : describe(report.error());
  };
  EXPECT_EQ(run(std::string(kLeft) + "mode = \"csv\"\n" + kRight), "");
  EXPECT_EQ(run(std::string(kLeft) + kRight + "mode = \"csv\"\n"),
            "axis right: its drive does not support mode csv; according to 6502h it supports csp");
}

TEST_F(DualDriveLine, TheOutputsOfBothBelongToTheirAxes) {
  const auto copy = [](const char* object) {
    return std::string("[[copy]]\nfrom = \"dual.6041h\"\nto = \"dual.") + object + "\"\n";
  };
  for (const auto& [object, axis] : {std::pair{"6040h", "left"}, {"6840h", "right"}}) {
    const auto line =
        virtual_line("[line]\ncycle_us = 1000\n" + std::string(kSlave) + kLeft + kRight + copy(object), directory);
    ASSERT_TRUE(line);
    const auto report = (*line)->run({.duration_s = 0.1, .force = false});
    ASSERT_FALSE(report) << object;
    EXPECT_THAT(describe(report.error()), HasSubstr(std::string("is written by the axis \"") + axis + "\""));
  }
}

TEST_F(DualDriveLine, BothFollowTheirPath) {
  const auto report = run("");
  EXPECT_EQ(failure_of(report), "");
  EXPECT_NEAR(samples.last[0].actual_position, 180.0 * std::acos(-1.0) / 180.0, 1e-4);
  EXPECT_NEAR(samples.last[1].actual_position, -0.030, 1e-6);
  EXPECT_LT(samples.error[0], 2e-4) << "an ideal drive has the following error of its resolution, 1e-4 rad";
  EXPECT_LT(samples.error[1], 1e-6);
}

TEST_F(DualDriveLine, BothComeBackAfterALossOfTheirSlave) {
  const auto report = run("[recovery]\naxes = \"hold\"\n[[fault]]\nat_ms = 1000\nfor_ms = 400\nkind = \"drop\"\n");
  EXPECT_EQ(failure_of(report), "");
  EXPECT_GT(report.duration_s, 2.4) << "the path waited";
  EXPECT_GT(samples.faults[0], 0);
  EXPECT_GT(samples.faults[1], 0);
  EXPECT_NEAR(samples.last[0].actual_position, std::acos(-1.0), 1e-4);
  EXPECT_NEAR(samples.last[1].actual_position, -0.030, 1e-6);
}

}  // namespace
}  // namespace driveline::runtime

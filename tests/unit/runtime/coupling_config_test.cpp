// [[encoder]], [[cam]] and [[coupling]] of a line description.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "driveline/runtime/config/line_config.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::runtime {
namespace {

using testing::HasSubstr;

const std::string kAxes =
    "[[slave]]\nname = \"x\"\n[[slave]]\nname = \"y\"\n[[axis]]\nname = \"x\"\n[[axis]]\nname = \"y\"\n"
    "[[virtual_axis]]\nname = \"v\"\nmax_velocity = 10\nmax_acceleration = 100\n";
const std::string kEncoder =
    "[[encoder]]\nname = \"e\"\nposition = \"y.6064h\"\nincrements_per_revolution = 4096\nmax_velocity = 20\n";
constexpr int kLines = 12;  // of kAxes

class CouplingConfigTest : public test::TemporaryDirectory {
 protected:
  void cam(const std::string& points) const {
    std::ofstream(directory / "cam.csv") << "master[rad],slave[rad]\n" << points;
  }
  [[nodiscard]] auto read(const std::string& text) const {
    return parse_line_config(kAxes + text, directory / "line.toml");
  }
  [[nodiscard]] std::string refusal(const std::string& text) const {
    const auto config = read(text);
    return config ? std::string{} : describe(config.error());
  }
  static std::string at(int line) { return "line.toml:" + std::to_string(kLines + line) + ": "; }
};

TEST_F(CouplingConfigTest, HasSlaveMasterAndLaw) {
  cam("0,0\n1,0.5\n2,0\n");
  const auto config =
      must(read(kEncoder +
                "filter_hz = 20\nnoise_increments = 2\nlatency_us = 30\npolarity = \"reversed\"\n"
                "[[cam]]\nname = \"lift\"\nfile = \"cam.csv\"\n"
                "[[coupling]]\nslave = \"x\"\nmaster = \"e\"\nratio = [-2, 3]\ncam = \"lift\"\non_loss = \"stop\"\n"
                "[[coupling]]\nslave = \"y\"\nmaster = \"x\"\nmaster_value = \"actual\"\n"));
  const auto& plan = config->couplings;
  ASSERT_EQ(plan.couplings.size(), 2U);
  EXPECT_EQ(plan.couplings[0].encoder, 0U);
  EXPECT_FALSE(plan.couplings[0].axis);
  EXPECT_EQ(plan.couplings[0].ratio.numerator(), -2);
  EXPECT_EQ(plan.couplings[0].cam, 0U);
  EXPECT_EQ(plan.couplings[0].on_loss, trajectory::OnLoss::kStop);
  EXPECT_TRUE(plan.couplings[1].actual);
  EXPECT_EQ(plan.of(1), &plan.couplings[1]);
  EXPECT_EQ(plan.of(2), nullptr);
  EXPECT_TRUE(plan.encoders[0].reversed);
  EXPECT_DOUBLE_EQ(plan.encoders[0].cutoff_hz, 20.0);
  EXPECT_EQ(plan.encoders[0].latency.count(), 30'000);
  EXPECT_EQ(plan.cams[0].cam->kind(), trajectory::CamKind::kPeriodic);
}

TEST_F(CouplingConfigTest, ARatioMayHaveUnits) {
  const std::string screw =
      "[[virtual_axis]]\nname = \"w\"\nunit = \"mm\"\nmax_velocity = 100\nmax_acceleration = 1000\n"
      "[[coupling]]\nslave = \"w\"\nmaster = \"x\"\nratio = ";
  const auto with_units = must(read(screw + "[\"10 mm\", \"360deg\"]\n"));
  EXPECT_DOUBLE_EQ(with_units->couplings.couplings[0].ratio.travel(4.0 * 6.283185307179586), 0.04);
  EXPECT_TRUE(with_units->couplings.couplings[0].ratio_given);
  EXPECT_TRUE(with_units->notes.empty());
  const auto without = must(read(screw + "[3, 2]\n"));
  EXPECT_DOUBLE_EQ(without->couplings.couplings[0].ratio.factor(), 1.5);
  EXPECT_THAT(without->notes, testing::ElementsAre(HasSubstr(
                                  "ratio: [3, 2] counts m of the slave per rad of its master; with units it is "
                                  "[\"10 mm\", \"360 deg\"]")));
  EXPECT_THAT(refusal(screw + "[\"360 deg\", \"10 mm\"]\n"),
              HasSubstr("ratio: \"360 deg\": the travel of the linear slave is expected, such as \"10 mm\""));
  for (const std::string ratio : {"[\"10 mm\"]", "[\"10\", \"360 deg\"]", "[\"0 mm\", \"360 deg\"]",
                                  "[\"mm\", \"1 rev\"]", "[\"10 mm\", 360]", "[\"nan mm\", \"1 rev\"]"})
    EXPECT_THAT(refusal(screw + ratio + "\n"), HasSubstr("[coupling 1] ratio")) << ratio;
}

TEST_F(CouplingConfigTest, RefusesWhatCannotBeWithFileAndLine) {
  const std::string x = "[[coupling]]\nslave = \"x\"\nmaster = ";
  EXPECT_THAT(refusal(x + "\"x\"\n"), HasSubstr(at(3) + "[coupling 1] master: \"x\" cannot be its own master"));
  EXPECT_THAT(refusal(x + "\"y\"\n[[coupling]]\nslave = \"y\"\nmaster = \"x\"\n"),
              HasSubstr(at(6) + "[coupling 2] master: is part of a coupling loop: y follows x follows y"));
  EXPECT_THAT(refusal(x + "\"y\"\n[[coupling]]\nslave = \"x\"\nmaster = \"v\"\n"), HasSubstr("already has a master"));
  EXPECT_THAT(refusal(x + "\"z\"\n"), HasSubstr(at(3)));
  EXPECT_THAT(refusal("[[coupling]]\nslave = \"z\"\nmaster = \"x\"\n"), HasSubstr(at(2)));
  for (const std::string ratio : {"[0, 1]", "[1, 0]", "[nan, 1]", "[1]", "[1.5, 2]", "[1e20, 1]", "1"})
    EXPECT_THAT(refusal(x + "\"y\"\nratio = " + ratio + "\n"), HasSubstr(at(4) + "[coupling 1] ratio")) << ratio;
  EXPECT_THAT(refusal(x + "\"v\"\nmaster_value = \"actual\"\n"), HasSubstr("is virtual"));
  EXPECT_THAT(refusal(kEncoder + x + "\"e\"\nmaster_value = \"actual\"\n"), HasSubstr("is for axes"));
  EXPECT_THAT(refusal(x + "\"y\"\ncam = \"c\"\n"),
              HasSubstr(at(4) + "[coupling 1] cam: there is no [[cam]] named \"c\""));
  EXPECT_THAT(refusal(x + "\"y\"\n[path]\nfile = \"p.csv\"\n"), HasSubstr("remove [path]"));
}

TEST_F(CouplingConfigTest, RefusesCamsThatDoNotCloseAndEncodersThatCannotBeFollowed) {
  cam("0,0\n1,0.5\n2,0.1\n");
  const std::string table = "[[cam]]\nname = \"lift\"\nfile = \"cam.csv\"\n";
  EXPECT_THAT(refusal(table), testing::AllOf(HasSubstr(at(3)), HasSubstr("cam.csv:4")));
  EXPECT_EQ(refusal(table + "kind = \"one_shot\"\n"), "");
  EXPECT_THAT(refusal("[[cam]]\nname = \"lift\"\nfile = \"none.csv\"\n"), HasSubstr(at(3)));
  EXPECT_THAT(refusal(kEncoder + "range_increments = 16\n"), HasSubstr("less than half of the range is expected"));
  EXPECT_THAT(refusal(kEncoder + "unit = \"mm\"\n"), HasSubstr("of an encoder without feed_mm_per_revolution"));
  EXPECT_THAT(refusal("[[encoder]]\nname = \"x\"\nposition = \"y.6064h\"\n"), HasSubstr(at(2)));
  EXPECT_THAT(refusal(kEncoder + "filter_hz = 0\n"), HasSubstr("filter_hz"));
}

}  // namespace
}  // namespace driveline::runtime

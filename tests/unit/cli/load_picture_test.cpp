#include <gmock/gmock.h>

#include "driveline/motion/axis/axis.hpp"
#include "support/temporary_directory.hpp"
#include "text/load_view.hpp"

namespace driveline::cli {
namespace {

class LoadPicture : public test::TemporaryDirectory {};

TEST_F(LoadPicture, ShowsTheMeasurementOverTheModelAndEachAxisByItsName) {
  std::string text = "time[s],position[rad],velocity[rad/s],acceleration[rad/s^2],torque[Nm],model[Nm]\n";
  for (int i = 0; i < 50; ++i) text += std::to_string(i) + ",0,0,0,1.5,1.498\n";
  write(directory / "load.csv", text);
  motion::AxisConfig axis;
  axis.name = "lift";
  const auto drawn = draw_load(directory, axis);
  ASSERT_TRUE(drawn) << drawn.error();
  EXPECT_TRUE(drawn->pictures.contains("load_plot"));
  const auto script = read(directory / "load.gp");
  const auto model = script.find("using 1:6 with points pt 7 ps 1.2");
  const auto measured = script.find("using 1:5 with points pt 7 ps 0.4");
  ASSERT_NE(measured, std::string::npos);
  EXPECT_LT(model, measured) << "the measurement is drawn last, and smaller";
  EXPECT_THAT(script, testing::HasSubstr("set ylabel 'torque in Nm'"));
  EXPECT_THAT(script, testing::HasSubstr("set ylabel 'difference in 1e-3 Nm'"));
}

}  // namespace
}  // namespace driveline::cli

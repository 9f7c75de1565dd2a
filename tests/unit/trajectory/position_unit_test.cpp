// The units in which positions are written.
#include "driveline/trajectory/position_unit.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace driveline::trajectory {
namespace {

TEST(PositionUnit, ConvertsThereAndBack) {
  EXPECT_DOUBLE_EQ(find_position_unit("rev")->to_si(2.0), 4.0 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(find_position_unit("deg")->to_si(180.0), std::numbers::pi);
  EXPECT_DOUBLE_EQ(find_position_unit("mm")->to_si(1.0), 0.001);
  EXPECT_DOUBLE_EQ(find_position_unit("um")->from_si(0.001), 1000.0);
  for (const auto& unit : position_units()) EXPECT_DOUBLE_EQ(unit.from_si(unit.to_si(0.3)), 0.3) << unit.name;
}

TEST(PositionUnit, SiUnitsLeaveValuesAsTheyAre) {
  for (const double value : {0.1, 1.0 / 3.0, 1e9, -5e-324}) {
    EXPECT_EQ(unit_or_si(nullptr, AxisKind::kRotary).from_si(value), value);
    EXPECT_EQ(unit_or_si(nullptr, AxisKind::kLinear).to_si(value), value);
  }
}

TEST(PositionUnit, IsFoundByItsNameAlone) {
  for (const auto& unit : position_units()) EXPECT_EQ(find_position_unit(unit.name), &unit);
  for (const auto* name : {"", "Rad", "s", "mm ", "inch"}) EXPECT_EQ(find_position_unit(name), nullptr) << name;
  EXPECT_EQ(&unit_or_si(find_position_unit("mm"), AxisKind::kLinear), find_position_unit("mm"));
}

}  // namespace
}  // namespace driveline::trajectory

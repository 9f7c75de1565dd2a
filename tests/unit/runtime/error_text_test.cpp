// One function makes the sentence of an error, whatever room it comes from.
#include <gtest/gtest.h>

#include <concepts>
#include <string>

#include "driveline/ecat_master/error.hpp"
#include "driveline/esi/esi_file.hpp"
#include "driveline/esi/sii.hpp"
#include "driveline/port/port_error.hpp"
#include "driveline/rt/realtime_report.hpp"
#include "driveline/rt/switch_log.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/trajectory/gear_ratio.hpp"
#include "driveline/trajectory/kinematic_kinds.hpp"
#include "driveline/trajectory/motion_limits.hpp"
#include "driveline/trajectory/path.hpp"
#include "driveline/trajectory/path_move.hpp"

namespace driveline::runtime {
namespace {

/// Also in a function that knows only the type of the error: found by the namespace of the argument.
template <typename Failure>
concept Described = requires(const Failure& failure) {
  { describe(failure) } -> std::same_as<std::string>;
};

static_assert(Described<Error> && Described<ecat_master::Error>);
static_assert(Described<port::PortError> && Described<rt::RealtimeError> && Described<rt::SwitchLogError>);
static_assert(Described<esi::SiiError> && Described<esi::EsiError>);
static_assert(Described<trajectory::PathError> && Described<trajectory::LimitViolation>);
static_assert(Described<trajectory::GearError> && Described<trajectory::PathMoveError>);
static_assert(Described<trajectory::KinematicError>);

TEST(ErrorText, IsTheSentenceOfTheError) {
  EXPECT_EQ(describe(port::PortError{port::PortErrorCode::kNoSuchInterface, 19, "eth9: no such interface"}),
            "eth9: no such interface");
  EXPECT_EQ(describe(trajectory::PathError{"path.csv", 3, 7, "a number is expected"}),
            "path.csv:3:7: a number is expected");
  EXPECT_EQ(describe(trajectory::PathMoveError{"the arc has no centre"}), "the arc has no centre");
  EXPECT_EQ(describe(trajectory::KinematicError{"rod is missing"}), "rod is missing");
  const trajectory::GearError gear{3, 0};
  EXPECT_EQ(describe(gear), gear.message());
  EXPECT_NE(describe(gear), "");
}

}  // namespace
}  // namespace driveline::runtime

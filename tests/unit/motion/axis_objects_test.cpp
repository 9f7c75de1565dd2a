#include "driveline/motion/drive/axis_objects.hpp"

#include <gmock/gmock.h>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/motion/path/motion.hpp"
#include "driveline/trajectory/path.hpp"

namespace driveline::motion {
namespace {

using cia402::Mode;
using testing::ElementsAre;
using testing::IsEmpty;

PdoConfiguration mapped(std::vector<MappedObject> outputs, std::vector<MappedObject> inputs) {
  return {{{0x1600, std::move(outputs)}}, {{0x1A00, std::move(inputs)}}};
}

constexpr MappedObject kControl{0x6040, 0, 16};
constexpr MappedObject kStatus{0x6041, 0, 16};
constexpr MappedObject kActual{0x6064, 0, 32};

TEST(AxisObjects, ThoseThatTheMasterMapsAreEnoughForEveryMode) {
  for (const auto mode : {Mode::kCyclicPosition, Mode::kCyclicVelocity, Mode::kCyclicTorque}) {
    EXPECT_THAT(missing_objects(mode, axis_pdo_configuration()), IsEmpty()) << to_text(mode);
  }
}

TEST(AxisObjects, EachModeNeedsItsTargetAndWhatItsLoopIsClosedWith) {
  const auto pdos = mapped({kControl}, {kStatus, kActual});
  EXPECT_THAT(missing_objects(Mode::kCyclicPosition, pdos), ElementsAre(MissingObject{0x607A, 32, true}));
  EXPECT_THAT(missing_objects(Mode::kCyclicVelocity, pdos), ElementsAre(MissingObject{0x60FF, 32, true}));
  EXPECT_THAT(missing_objects(Mode::kVelocity, pdos), ElementsAre(MissingObject{0x6042, 16, true}));
  EXPECT_THAT(missing_objects(Mode::kCyclicTorque, pdos),
              ElementsAre(MissingObject{0x6071, 16, true}, MissingObject{0x606C, 32, false}));
  EXPECT_THAT(missing_objects(Mode::kCyclicPosition, {}),
              ElementsAre(MissingObject{0x6040, 16, true}, MissingObject{0x607A, 32, true},
                          MissingObject{0x6041, 16, false}, MissingObject{0x6064, 32, false}));
}

TEST(AxisObjects, AFeedForwardOfFrictionNeedsTheTorqueOffset) {
  const auto pdos =
      mapped({kControl, {0x607A, 0, 32}, {0x60FF, 0, 32}, {0x6071, 0, 16}}, {kStatus, kActual, {0x606C, 0, 32}});
  const auto offset = ElementsAre(MissingObject{0x60B2, 16, true});
  EXPECT_THAT(missing_objects(Mode::kCyclicPosition, pdos, true), offset);
  EXPECT_THAT(missing_objects(Mode::kCyclicVelocity, pdos, true), offset);
  EXPECT_THAT(missing_objects(Mode::kCyclicTorque, pdos, true), IsEmpty()) << "it is part of the target";
  AxisConfig config;
  EXPECT_TRUE(Axis(config, {0, 0}, pdos).complete());
  config.feed_forward.gravity = 1.0;
  EXPECT_FALSE(Axis(config, {0, 0}, pdos).complete());
}

TEST(AxisObjects, AreEnoughWithoutTheModeOfOperation) {
  const auto pdos = mapped({kControl, {0x607A, 0, 32}}, {kStatus, kActual});
  EXPECT_THAT(missing_objects(Mode::kCyclicPosition, pdos), IsEmpty());
}

TEST(AxisObjects, InTheWrongDirectionWidthOrPlaceAreMissing) {
  auto pdos = mapped({kControl, {0x607A, 0, 16}, kStatus}, {{0x2000, 1, 4}, kActual});
  EXPECT_THAT(missing_objects(Mode::kCyclicPosition, pdos),
              ElementsAre(MissingObject{0x607A, 32, true, 16}, MissingObject{0x6041, 16, false},
                          MissingObject{0x6064, 32, false, 32}));
  pdos.outputs[0].objects[1] = {0x607A, 1, 32};
  EXPECT_THAT(missing_objects(Mode::kCyclicPosition, pdos), testing::Contains(MissingObject{0x607A, 32, true}))
      << "another sub-index is another value";
}

TEST(AxisObjects, ThatAreMissingMakeOneSentence) {
  const auto sentence = [](Mode mode, const PdoConfiguration& pdos) {
    return describe_missing(mode, missing_objects(mode, pdos), pdos);
  };
  EXPECT_EQ(sentence(Mode::kCyclicPosition, axis_pdo_configuration()), "");
  EXPECT_EQ(sentence(Mode::kCyclicPosition, mapped({kControl, {0x6060, 0, 8}}, {kStatus, kActual})),
            "csp needs 607Ah (Target position, 32 bits) in an RxPDO; the RxPDOs map 6040h, 6060h");
  EXPECT_EQ(
      sentence(Mode::kCyclicVelocity, mapped({kControl, {0x60FF, 0, 16}}, {{0, 0, 4}, kStatus, kActual})),
      "csv needs 60FFh (Target velocity, 32 bits) in an RxPDO instead of 16 bits, 6041h (Statusword, 16 bits) in a "
      "TxPDO and at the beginning of a byte, 6064h (Position actual value, 32 bits) in a TxPDO and at the "
      "beginning of a byte; the RxPDOs map 6040h, 60FFh; the TxPDOs map 6041h, 6064h");
  EXPECT_EQ(sentence(Mode::kCyclicPosition, mapped({kControl, {0x607A, 0, 32}}, {})),
            "csp needs 6041h (Statusword, 16 bits) in a TxPDO, 6064h (Position actual value, 32 bits) in a TxPDO; the "
            "TxPDOs map nothing");
}

TEST(AxisObjects, AMotionTakesNoAxisWithoutThem) {
  trajectory::PathBuilder builder;
  ASSERT_TRUE(builder.add_axis({"x", trajectory::AxisKind::kRotary}));
  ASSERT_TRUE(builder.add_point(0.0, std::vector{0.0}));
  ASSERT_TRUE(builder.add_point(1.0, std::vector{1.0}));
  auto path = builder.build();
  ASSERT_TRUE(path);
  const auto interpolator = trajectory::Interpolator::clamped_spline(*path);
  const auto motion = [&](const PdoConfiguration& pdos) {
    std::vector<Axis> axes;
    axes.emplace_back(AxisConfig{}, ImagePlace{0, 0}, pdos);
    return Motion(std::move(axes), interpolator, {});
  };
  EXPECT_NO_THROW(motion(mapped({kControl, {0x607A, 0, 32}}, {kStatus, kActual})));
  EXPECT_THROW(motion(mapped({kControl}, {kStatus, kActual})), std::invalid_argument);
  EXPECT_THROW(motion(mapped({kControl, {0x607A, 0, 32}}, {kStatus})), std::invalid_argument);
}

}  // namespace
}  // namespace driveline::motion

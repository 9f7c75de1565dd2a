// The objects of a device with several CiA 402 drives, as each of its drives sees them.
#include "driveline/motion/drive/drive_objects.hpp"

#include <gmock/gmock.h>

#include "driveline/bytes/endian.hpp"
#include "driveline/motion/axis/axis.hpp"
#include "driveline/motion/drive/axis_objects.hpp"

namespace driveline::motion {
namespace {

using cia402::Mode;
using testing::IsEmpty;

/// Objects of two drives in one PDO each way, the second drive first, and an object that both share.
PdoConfiguration of_two_drives() {
  return {{{0x1600, {{0x6840, 0, 16}, {0x687A, 0, 32}, {0x2001, 3, 8}, {0x6040, 0, 16}, {0x607A, 0, 32}}}},
          {{0x1A00, {{0x6841, 0, 16}, {0x6864, 0, 32}, {0x6041, 0, 16}, {0x6064, 0, 32}}}}};
}

TEST(DriveObjects, LieAt800hPerDrive) {
  EXPECT_EQ(object_of_drive(0x6040, 0), 0x6040);
  EXPECT_EQ(object_of_drive(0x607A, 1), 0x687A);
  EXPECT_EQ(object_of_drive(0x67FF, 7), 0x9FFF);
  for (const std::uint16_t shared : std::initializer_list<std::uint16_t>{0x1C32, 0x2001, 0x5FFF, 0x6800})
    EXPECT_EQ(object_of_drive(shared, 3), shared);
}

TEST(DriveObjects, HaveACounterpartInTheFirstDrive) {
  EXPECT_EQ(object_of_first_drive(0x60C2), 0x60C2);
  EXPECT_EQ(object_of_first_drive(0x68C2), 0x60C2);
  EXPECT_EQ(object_of_first_drive(0x9FFF), 0x67FF);
  EXPECT_EQ(object_of_first_drive(0xA000), 0xA000);
  EXPECT_EQ(object_of_first_drive(0x5FFF), 0x5FFF);
}

TEST(DriveObjects, OfOtherDrivesAreGaps) {
  EXPECT_EQ(pdos_of_drive(of_two_drives(), 1).outputs[0].objects,
            (std::vector<MappedObject>{{0x6040, 0, 16}, {0x607A, 0, 32}, {0x2001, 3, 8}, {0, 0, 16}, {0, 0, 32}}));
  EXPECT_EQ(pdos_of_drive(of_two_drives(), 0).inputs[0].objects,
            (std::vector<MappedObject>{{0, 0, 16}, {0, 0, 32}, {0x6041, 0, 16}, {0x6064, 0, 32}}));
  EXPECT_EQ(pdos_of_drive({{{0x1600, {{0xA000, 0, 16}}}}, {}}, 7).outputs[0].objects,
            (std::vector<MappedObject>{{0xA000, 0, 16}}))
      << "no object of a drive";
}

TEST(DriveObjects, AreMissingByTheirOwnIndex) {
  auto pdos = of_two_drives();
  for (const unsigned drive : {0U, 1U}) {
    EXPECT_THAT(missing_objects(Mode::kCyclicPosition, pdos_of_drive(pdos, drive)), IsEmpty()) << drive;
  }
  pdos.outputs[0].objects[1].index = 0x70FF;
  const auto missing = missing_objects(Mode::kCyclicPosition, pdos_of_drive(pdos, 1));
  EXPECT_EQ(describe_missing(Mode::kCyclicPosition, missing, pdos, 1),
            "csp needs 687Ah (Target position, 32 bits) in an RxPDO; the RxPDOs map 6840h, 70FFh, 2001h, 6040h, 607Ah");
}

TEST(DriveObjects, AnAxisExchangesThoseOfItsDrive) {
  AxisConfig config;
  config.increments_per_unit = 1000.0;
  for (const std::uint8_t drive : std::initializer_list<std::uint8_t>{0, 1}) {
    config.drive = drive;
    Axis axis(config, {3, 5}, of_two_drives());
    EXPECT_TRUE(axis.complete());
    std::vector<std::byte> inputs(5 + 12);
    bytes::store_le<std::int32_t>(std::span(inputs).subspan(5 + 2, 4), -7000);       // 6864h
    bytes::store_le<std::int32_t>(std::span(inputs).subspan(5 + 6 + 2, 4), 250000);  // 6064h
    axis.read_inputs(inputs, true);
    EXPECT_DOUBLE_EQ(axis.inputs().position, drive == 1 ? -7.0 : 250.0);
  }
}

}  // namespace
}  // namespace driveline::motion

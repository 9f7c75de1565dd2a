// The values of the profile SERCOS against the table of the ServoOne's IDNs.
#include <gmock/gmock.h>

#include <set>

#include "driveline/slaves/msd/sercos/servoone_idns.hpp"
#include "sercos_rig.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::uint16_t kFirstParameter = 0x2000;
constexpr std::uint16_t kFirstStandard = kFirstParameter + 10000;
constexpr std::uint16_t kProduct = 0x8000;

bool of_sercos(const EntryRow& row) {
  return !is_string(row.type) && row.slot >= kValue.end() && row.slot < kSercosValue.end();
}

wire::Idn idn_of(const EntryRow& row) {
  const bool standard = row.index >= kFirstStandard;
  return {static_cast<std::uint16_t>(standard ? row.index - kFirstStandard : row.index - kFirstParameter + kProduct)};
}

/// Whether an IDN with this attribute has the values of this row, or a list of them.
bool same_type(const EntryRow& row, const wire::SoeAttribute& attribute) {
  const auto is = [&](std::size_t size, bool with_sign, bool real) {
    return attribute.element_size() == size && (attribute.display == wire::SoeDisplay::kSigned) == with_sign &&
           (attribute.display == wire::SoeDisplay::kFloat) == real;
  };
  switch (row.type) {
    case esi::DataType::kInteger16:
      return is(2, true, false);
    case esi::DataType::kInteger32:
      return is(4, true, false);
    case esi::DataType::kUnsigned16:
      return is(2, false, false);
    case esi::DataType::kUnsigned32:
      return is(4, false, false);
    case esi::DataType::kReal32:
      return is(4, false, true);
    default:
      return false;
  }
}

TEST(SercosTable, EveryValueIsThatOfAnIdnOfItsType) {
  std::set<std::uint16_t> slots;
  for (const EntryRow& row : sercos_table().rows()) {
    if (!of_sercos(row)) continue;
    slots.insert(row.slot);
    const IdnRow* idn = sercos::servoone_idns().find(idn_of(row));
    ASSERT_NE(idn, nullptr) << std::hex << row.index << ' ' << row.name;
    EXPECT_TRUE(same_type(row, idn->attribute)) << std::hex << row.index << ' ' << row.name;
  }
  EXPECT_EQ(slots.size(), std::size_t{kSercosValue.end()} - kValue.end()) << "each slot has a row";
}

TEST(SercosTable, StandardParametersAreThoseOfTheDeviceFrom10000On) {
  const EntryRow* row = sercos_table().find(0x2000 + 10047, 0);
  ASSERT_NE(row, nullptr);
  EXPECT_EQ(row->slot, kSercosValue.position_command.number);
}

TEST(SercosTable, TheDriveIsControlledBySercosFromTheFactoryOn) {
  const ObjectDictionary dictionary(sercos_table());
  EXPECT_EQ(dictionary.get(kValue.control_location), 6);
  EXPECT_EQ(dictionary.get(kValue.reference_source), 8);
  EXPECT_EQ(dictionary.get(kValue.interpolation_type), 3);
  EXPECT_EQ(dictionary.get(kSercosValue.modes[0]), 0x000B);
}

}  // namespace
}  // namespace driveline::slaves::msd

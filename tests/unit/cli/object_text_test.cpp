// The columns in users' listings of the IgH tool:
//   SDO 0x1000, "Device type"
//     0x1000:00, r-r-r-, uint32, 32 bit, "Device type"
//     0x2004:00, rwrwrw, type 002f, 32 bit, "Calibration Options"
#include "text/object_text.hpp"

#include <gmock/gmock.h>

namespace driveline::cli {
namespace {

namespace access = wire::entry_access;
using testing::HasSubstr;

constexpr std::uint16_t kReadAlways = access::kReadPreOp | access::kReadSafeOp | access::kReadOp;
constexpr std::uint16_t kWriteAlways = access::kWritePreOp | access::kWriteSafeOp | access::kWriteOp;

DictionaryObject object(std::uint16_t index, std::uint16_t data_type, std::uint16_t bits, std::uint16_t rights,
                        std::string name) {
  DictionaryObject object;
  object.object.index = index;
  object.object.data_type = data_type;
  object.object.name = name;
  ecat_master::EntryDescription entry;
  entry.index = index;
  entry.data_type = data_type;
  entry.bit_length = bits;
  entry.access = rights;
  entry.name = std::move(name);
  object.entries.push_back(entry);
  return object;
}

TEST(ObjectText, OneLinePerObjectAndEntry) {
  const std::vector<DictionaryObject> objects = {
      object(0x1000, 0x0007, 32, kReadAlways, "Device type"),
      object(0x2000, 0x0007, 32, kReadAlways | access::kWritePreOp, "Positioner Type"),
      object(0x2004, 0x002F, 32, kReadAlways | kWriteAlways, "Calibration Options"),
      object(0x1008, 0x0009, 104, kReadAlways, "Device name"), object(0x6502, 0x0001, 1, kReadAlways, "Flag")};
  EXPECT_EQ(to_text(objects, false),
            "SDO 0x1000, \"Device type\"\n"
            "  0x1000:00, r-r-r-, uint32, 32 bit, \"Device type\"\n"
            "SDO 0x2000, \"Positioner Type\"\n"
            "  0x2000:00, rwr-r-, uint32, 32 bit, \"Positioner Type\"\n"
            "SDO 0x2004, \"Calibration Options\"\n"
            "  0x2004:00, rwrwrw, type 002f, 32 bit, \"Calibration Options\"\n"
            "SDO 0x1008, \"Device name\"\n"
            "  0x1008:00, r-r-r-, string, 104 bit, \"Device name\"\n"
            "SDO 0x6502, \"Flag\"\n"
            "  0x6502:00, r-r-r-, bool, 1 bit, \"Flag\"\n");
}

TEST(ObjectText, VerboseTellsWhatTheSlaveTells) {
  auto described = object(0x6060, 0x0002, 8, kReadAlways | access::kRxMappable, "Modes of operation");
  auto& entry = described.entries[0];
  entry.default_value = std::vector{std::byte{8}};
  entry.minimum = std::vector{std::byte{0x80}};
  entry.unit = 0xFD010000;
  const std::vector<DictionaryObject> objects = {described};
  EXPECT_THAT(to_text(objects, true), HasSubstr("\"Modes of operation\", default 0x08 8, minimum 0x80 -128, unit "
                                                "0xfd010000, RxPDO\n"));
  // A value with another size than its type is shown as raw bytes.
  entry.default_value = std::vector{std::byte{1}, std::byte{2}};
  const std::vector<DictionaryObject> odd = {described};
  EXPECT_THAT(to_text(odd, true), HasSubstr("default 0x01 0x02"));
}

TEST(ObjectText, ProgramsGetTypedValues) {
  auto described = object(0x6060, 0x0002, 8, kReadAlways, "Modes of operation");
  described.entries[0].minimum = std::vector{std::byte{0x80}};
  const std::vector<DictionaryObject> objects = {described};
  const auto rows = to_json(objects);
  EXPECT_EQ(rows[0]["index"], 0x6060);
  EXPECT_EQ(rows[0]["entries"][0]["minimum"], -128);
  EXPECT_TRUE(rows[0]["entries"][0]["maximum"].is_null());
  EXPECT_EQ(rows[0]["entries"][0]["type"], "int8");
}

}  // namespace
}  // namespace driveline::cli

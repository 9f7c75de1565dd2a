#include "text/register_name.hpp"

#include <gmock/gmock.h>

namespace driveline::cli {
namespace {

using testing::HasSubstr;

TEST(RegisterName, AddressesInEveryNotation) {
  for (const auto* text : {"0x0130", "0130h", "304"}) {
    const auto found = find_register(text);
    ASSERT_TRUE(found) << text;
    EXPECT_EQ(found->address, 0x0130);
    EXPECT_EQ(found->bytes, 2);
    ASSERT_NE(found->row, nullptr);
    EXPECT_EQ(found->row->name, "AL status");
  }
}

TEST(RegisterName, NamesWithoutBlanksCaseAndPunctuation) {
  for (const auto* text : {"AL status", "al_status", "al-status", "ALSTATUS"}) {
    EXPECT_EQ(find_register(text).value().address, 0x0130) << text;
  }
  // A complete name has priority over longer names that contain it.
  EXPECT_EQ(find_register("revision").value().address, 0x0001);
  EXPECT_EQ(find_register("build").value().address, 0x0002);
}

TEST(RegisterName, EveryNameOfTheTableLeadsToItsRegister) {
  for (const auto& row : wire::kRegisters) {
    const auto found = find_register(row.name);
    ASSERT_TRUE(found) << row.name;
    EXPECT_EQ(found->address, row.address) << row.name;
    EXPECT_EQ(find_register(std::to_string(row.address)).value().row, &row);
  }
}

TEST(RegisterName, ElementsOfArrays) {
  EXPECT_EQ(find_register("fmmu[0]").value().address, 0x0600);
  EXPECT_EQ(find_register("fmmu[1]").value().address, 0x0610);
  EXPECT_EQ(find_register("fmmu[1]").value().bytes, 16);
  EXPECT_EQ(find_register("sync manager[3]").value().address, 0x0818);
  EXPECT_EQ(find_register("sync manager[3]").value().bytes, 8);
  EXPECT_EQ(find_register("lost_link_counter[2]").value().address, 0x0312);
  EXPECT_EQ(find_register("lost_link_counter[2]").value().bytes, 1);
  EXPECT_EQ(find_register("0x0304").value().row->name, find_register("0x0300").value().row->name);
}

TEST(RegisterName, WhatIsNoRegisterHasNoSize) {
  const auto ram = find_register("0x1000");
  ASSERT_TRUE(ram);
  EXPECT_EQ(ram->bytes, 0);
  EXPECT_EQ(ram->row, nullptr);
  EXPECT_EQ(find_register("0x0131").value().row, nullptr) << "the second byte of a register is no register";
}

TEST(RegisterName, WrongOnesAreExplained) {
  EXPECT_THAT(find_register("watchdog").error().text, HasSubstr("0x0420 watchdog time process data"));
  EXPECT_THAT(find_register("colour").error().text, HasSubstr("reg list"));
  EXPECT_THAT(find_register("").error().text, HasSubstr("reg list"));
  EXPECT_THAT(find_register("fmmu[16]").error().text, HasSubstr("16 elements"));
  EXPECT_THAT(find_register("al_status[1]").error().text, HasSubstr("1 element,"));
  EXPECT_THAT(find_register("fmmu[x]").error().text, HasSubstr("element"));
  EXPECT_EQ(find_register("colour").error().status, 2);
}

TEST(RegisterName, ListHasARowForEachRegister) {
  const auto table = register_table();
  EXPECT_EQ(static_cast<std::size_t>(std::count(table.begin(), table.end(), '\n')), wire::kRegisters.size() + 1);
  EXPECT_THAT(table, HasSubstr("0x0130       2         1  r-      AL status\n"));
}

}  // namespace
}  // namespace driveline::cli

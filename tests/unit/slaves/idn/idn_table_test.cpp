#include "driveline/slaves/idn/idn_table.hpp"

#include <gmock/gmock.h>

#include <array>

namespace driveline::slaves {
namespace {

using wire::SoeDisplay;

constexpr wire::SoeAttribute kReadOnlyList{.list = true,
                                           .display = SoeDisplay::kIdn,
                                           .pre_op_protected = true,
                                           .safe_op_protected = true,
                                           .op_protected = true};
constexpr std::array<std::uint16_t, 3> kThree = {7, 8, 9};

TEST(IdnTable, SortsRowsAndMakesTheListsThatFollowFromThem) {
  const std::array rows = {IdnRow{.idn = {0x8005}, .uses = idn_use::kMdt},
                           IdnRow{.idn = {25}, .attribute = kReadOnlyList, .selection = IdnSelection::kCommands},
                           IdnRow{.idn = {99}, .attribute = {.command = true}},
                           IdnRow{.idn = {17}, .attribute = kReadOnlyList, .selection = IdnSelection::kAll},
                           IdnRow{.idn = {40}, .uses = idn_use::kAt | idn_use::kSaved}};
  const IdnTable table({std::span(rows).first(2), std::span(rows).subspan(2)}, 0);
  const auto list = [&table](IdnSelection selection) {
    std::vector<unsigned> bytes;
    for (const auto byte : table.selected(selection)) bytes.push_back(std::to_integer<unsigned>(byte));
    return bytes;
  };
  using testing::ElementsAre;
  EXPECT_THAT(list(IdnSelection::kAll), ElementsAre(17, 0, 25, 0, 40, 0, 99, 0, 5, 0x80));
  EXPECT_THAT(list(IdnSelection::kCommands), ElementsAre(99, 0));
  EXPECT_THAT(list(IdnSelection::kAt), ElementsAre(40, 0));
  EXPECT_THAT(list(IdnSelection::kMdt), ElementsAre(5, 0x80));
  EXPECT_THAT(list(IdnSelection::kSaved), ElementsAre(40, 0));
  EXPECT_EQ(table.find({17})->capacity, 10);
  EXPECT_EQ(table.list_bytes(), 0U) << "such lists take no memory of a drive";
}

TEST(IdnTable, RefusesRowsThatContradict) {
  const IdnRow number{.idn = {40}};
  const auto with = [](auto change) {
    IdnRow row{.idn = {41}};
    change(row);
    return row;
  };
  const std::pair<const char*, IdnRow> cases[] = {
      {"twice", with([](auto& row) { row.idn = {40}; })},
      {"parameter set 1", with([](auto& row) { row.idn = {0x1029}; })},
      {"eight bytes", with([](auto& row) { row.attribute.length_code = 3; })},
      {"below its minimum", with([](auto& row) { row.minimum = 3; })},
      {"above its maximum", with([](auto& row) { row.maximum = -3; })},
      {"command of four bytes", with([](auto& row) { row.attribute = {.length_code = 2, .command = true}; })},
      {"slot out of range", with([](auto& row) { row.slot = 2; })},
      {"more elements than its list has room", with([](auto& row) {
         row.attribute.list = true;
         row.capacity = 4;
         row.elements = kThree;
       })},
      {"longer text than its list has room", with([](auto& row) {
         row.attribute = {.length_code = 0, .list = true, .display = SoeDisplay::kText};
         row.capacity = 4;
         row.text = "ready";
       })},
      {"a writable list of the table", with([](auto& row) {
         row.attribute.list = true;
         row.selection = IdnSelection::kAll;
       })}};
  for (const auto& [what, row] : cases) {
    EXPECT_THROW(IdnTable({std::array{number, row}}, 2), std::logic_error) << what;
  }
  EXPECT_EQ(IdnTable({std::array{number, with([](auto&) {})}}, 2).slot_count(), 4);
}

TEST(IdnTable, RefusesAliasesThatDisagree) {
  const IdnRow first{.idn = {40}, .initial = 3, .slot = 0};
  auto second = first;
  second.idn = {0x8029};
  EXPECT_EQ(IdnTable({std::array{first, second}}, 1).slot_count(), 1);
  auto other = second;
  other.initial = 4;
  EXPECT_THROW(IdnTable({std::array{first, other}}, 1), std::logic_error) << "initial value";
  other = second;
  other.attribute.length_code = 2;
  EXPECT_THROW(IdnTable({std::array{first, other}}, 1), std::logic_error) << "length";
  other = second;
  other.attribute.display = SoeDisplay::kSigned;
  EXPECT_THROW(IdnTable({std::array{first, other}}, 1), std::logic_error) << "sign";
}

TEST(IdnTable, ANamedSlotHasTheTypeOfItsRow) {
  const IdnRow word{.idn = {40}};
  EXPECT_EQ(in_slot(Slot<std::uint16_t>{5}, word).slot, 5);
  EXPECT_THROW(static_cast<void>(in_slot(Slot<std::int16_t>{5}, word)), std::logic_error);
  EXPECT_THROW(static_cast<void>(in_slot(Slot<std::uint32_t>{5}, word)), std::logic_error);
  EXPECT_THROW(static_cast<void>(in_slot(Slot<IdnList>{5}, word)), std::logic_error);
  EXPECT_THROW(static_cast<void>(in_slot(Slot<IdnCommand>{5}, word)), std::logic_error);
  const IdnRow real{.idn = {41}, .attribute = {.length_code = 2, .display = SoeDisplay::kFloat}};
  EXPECT_EQ(in_slot(Slot<float>{6}, real).slot, 6);
  EXPECT_THROW(static_cast<void>(in_slot(Slot<std::uint32_t>{6}, real)), std::logic_error);
}

}  // namespace
}  // namespace driveline::slaves

#include "driveline/wire/registers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>
#include <string>

namespace driveline::wire {
namespace {

/// Address and size of every register (arrays: of all elements), typed from the register overview of the ESC data
/// sheet, section II, independently of the table under test.
struct Place {
  unsigned address;
  unsigned bytes;
};
const std::vector<Place> kOverview{
    {0x0000, 1}, {0x0001, 1}, {0x0002, 2},   {0x0004, 1},   {0x0005, 1},  {0x0006, 1}, {0x0007, 1}, {0x0008, 2},
    {0x0010, 2}, {0x0012, 2}, {0x0020, 1},   {0x0021, 1},   {0x0030, 1},  {0x0031, 1}, {0x0040, 1}, {0x0041, 1},
    {0x0100, 4}, {0x0108, 2}, {0x0110, 2},   {0x0120, 2},   {0x0130, 2},  {0x0134, 2}, {0x0138, 1}, {0x0139, 1},
    {0x0140, 1}, {0x0141, 1}, {0x014E, 2},   {0x0150, 1},   {0x0151, 1},  {0x0152, 2}, {0x0200, 2}, {0x0204, 4},
    {0x0210, 2}, {0x0220, 4}, {0x0300, 8},   {0x0308, 4},   {0x030C, 1},  {0x030D, 1}, {0x030E, 2}, {0x0310, 4},
    {0x0400, 2}, {0x0410, 2}, {0x0420, 2},   {0x0440, 2},   {0x0442, 1},  {0x0443, 1}, {0x0500, 1}, {0x0501, 1},
    {0x0502, 2}, {0x0504, 4}, {0x0508, 8},   {0x0510, 2},   {0x0512, 1},  {0x0513, 1}, {0x0514, 2}, {0x0516, 1},
    {0x0517, 1}, {0x0518, 4}, {0x0600, 256}, {0x0800, 128}, {0x0900, 16}, {0x0910, 8}, {0x0918, 8}, {0x0920, 8},
    {0x0928, 4}, {0x092C, 4}, {0x0930, 2},   {0x0932, 2},   {0x0934, 1},  {0x0935, 1}, {0x0980, 1}, {0x0981, 1},
    {0x0982, 2}, {0x0984, 1}, {0x098E, 1},   {0x098F, 1},   {0x0990, 8},  {0x0998, 8}, {0x09A0, 4}, {0x09A4, 4},
    {0x09A8, 1}, {0x09A9, 1}, {0x09AE, 1},   {0x09AF, 1},   {0x09B0, 8},  {0x09B8, 8}, {0x09C0, 8}, {0x09C8, 8},
    {0x09F0, 4}, {0x09F8, 4}, {0x09FC, 4},   {0x0E00, 2},   {0x0F00, 4},  {0x0F10, 8}, {0x0F18, 8}, {0x0F80, 128},
};

TEST(Registers, LieWhereTheDataSheetHasThem) {
  ASSERT_EQ(kRegisters.size(), kOverview.size());
  for (std::size_t i = 0; i < kRegisters.size(); ++i) {
    EXPECT_EQ(kRegisters[i].address, kOverview[i].address) << kRegisters[i].name;
    EXPECT_EQ(kRegisters[i].end() - kRegisters[i].address, kOverview[i].bytes) << kRegisters[i].name;
  }
}

TEST(Registers, ResetValues) {
  // ESC data sheet, section II, "reset value" columns.
  EXPECT_EQ(reg::kDlControl.reset, 0x00070001U);  // forwarding rule, RX FIFO 7
  EXPECT_EQ(reg::kAlControl.reset, 1);
  EXPECT_EQ(reg::kAlStatus.reset, 1);
  EXPECT_EQ(reg::kAlStatusCode.reset, 0);
  EXPECT_EQ(reg::kStationAddress.reset, 0);
  EXPECT_EQ(reg::kAlEventMask.reset, 0x00FFFF0FU);
  EXPECT_EQ(reg::kEcatEventMask.reset, 0);
  EXPECT_EQ(reg::kWatchdogDivider.reset, 2498);  // (2498 + 2) times 40 ns: 100 us
  EXPECT_EQ(reg::kWatchdogTimePdi.reset, 1000);
  EXPECT_EQ(reg::kWatchdogTimeProcessData.reset, 1000);
  EXPECT_EQ(reg::kSpeedCounterStart.reset, 0x1000);
  EXPECT_EQ(reg::kSystemTimeFilterDepth.reset, 4);
  EXPECT_EQ(reg::kSpeedFilterDepth.reset, 12);
}

TEST(Registers, ArraysHaveTheDistancesOfTheDataSheet) {
  EXPECT_EQ(reg::kFmmu.at(0), 0x0600);
  EXPECT_EQ(reg::kFmmu.at(15), 0x06F0);
  EXPECT_EQ(reg::kSyncManager.at(1), 0x0808);
  EXPECT_EQ(reg::kSyncManager.at(15), 0x0878);
  EXPECT_EQ(reg::kReceiveTimePort.at(3), 0x090C);
  EXPECT_EQ(reg::kRxErrorCounter.at(3), 0x0306);
  EXPECT_EQ(reg::kForwardedErrorCounter.at(3), 0x030B);
  EXPECT_EQ(reg::kLostLinkCounter.at(3), 0x0313);
}

TEST(Registers, WhoMayWrite) {
  using A = RegisterAccess;
  const auto row = [](unsigned address) {
    return *std::find_if(kRegisters.begin(), kRegisters.end(), [&](const auto& r) { return r.address == address; });
  };
  EXPECT_EQ(row(0x0000).ecat, A::kRead);
  EXPECT_EQ(row(0x0010).ecat, A::kReadWrite);
  EXPECT_EQ(row(0x0012).pdi, A::kReadWrite);
  EXPECT_EQ(row(0x0120).ecat, A::kReadWrite);
  EXPECT_EQ(row(0x0120).pdi, A::kRead);
  EXPECT_EQ(row(0x0130).ecat, A::kRead);
  EXPECT_EQ(row(0x0130).pdi, A::kReadWrite);
  EXPECT_EQ(row(0x0134).pdi, A::kReadWrite);
  EXPECT_EQ(row(0x0300).ecat, A::kReadClearOnWrite);
  EXPECT_EQ(row(0x0440).ecat, A::kRead);
  EXPECT_EQ(row(0x0600).ecat, A::kReadWrite);
  EXPECT_EQ(row(0x0920).ecat, A::kReadWrite);
  EXPECT_EQ(row(0x092C).ecat, A::kRead);
}

TEST(Registers, EveryRowSaysWhatItIsAndWhereItIsFrom) {
  std::set<std::string_view> names;
  for (const auto& row : kRegisters) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name << " twice";
    EXPECT_FALSE(row.name.empty());
    EXPECT_FALSE(row.source.empty()) << row.name;
    EXPECT_TRUE(row.size == 1 || row.size == 2 || row.size == 4 || row.size == 8) << row.name;
    EXPECT_TRUE(row.size == 8 || row.reset >> (8 * row.size) == 0) << row.name;
  }
}

TEST(Registers, DoNotOverlap) {
  for (std::size_t i = 1; i < kRegisters.size(); ++i) {
    EXPECT_LE(kRegisters[i - 1].end(), kRegisters[i].address) << kRegisters[i].name;
  }
  EXPECT_LE(kRegisters.back().end(), kProcessRamStart);
  EXPECT_EQ(kProcessRamStart, 0x1000);
}

}  // namespace
}  // namespace driveline::wire

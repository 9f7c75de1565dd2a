#include "driveline/slaves/coe/coe_access.hpp"

#include <gtest/gtest.h>

#include "driveline/wire/coe.hpp"

namespace driveline::slaves {
namespace {

using wire::AlState;

/// The mailbox does not work in INIT, and in BOOT for firmware only.
TEST(CoeAccess, ADictionaryIsOpenInTheStatesThatHaveAMailboxForIt) {
  EXPECT_EQ(access_phase(AlState::kInit), AccessPhase::kClosed);
  EXPECT_EQ(access_phase(AlState::kBootstrap), AccessPhase::kClosed);
  EXPECT_EQ(access_phase(AlState::kPreOp), AccessPhase::kConfiguring);
  EXPECT_EQ(access_phase(AlState::kSafeOp), AccessPhase::kReady);
  EXPECT_EQ(access_phase(AlState::kOp), AccessPhase::kOperating);
}

/// Numbers of ETG.1000.6 Table 54.
TEST(CoeAccess, RightsAreToldAsTheStandardHasThem) {
  EXPECT_EQ(coe_access({.access = access::kRead}), 0x0007);
  EXPECT_EQ(coe_access({.access = access::kReadWrite}), 0x003F);
  EXPECT_EQ(coe_access({.access = access::kReadWriteConfiguring}), 0x000F);
  EXPECT_EQ(coe_access({.access = access::kWriteReady | access::kRxMappable}), 0x0050);
  EXPECT_EQ(coe_access({.access = access::kReadOperating | access::kTxMappable | access::kBackup}), 0x0184);
}

}  // namespace
}  // namespace driveline::slaves

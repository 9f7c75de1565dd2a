// The object dictionary of a device known only by its ESI file, read through its mailbox.
#include "device_bench.hpp"

namespace driveline::slaves::generic {
namespace {

using testing::ElementsAre;
using Answer = std::vector<unsigned>;

Answer aborted(unsigned index, unsigned sub, std::uint32_t code) {
  return {0x80, index & 0xFF, index >> 8, sub, code & 0xFF, code >> 8 & 0xFF, code >> 16 & 0xFF, code >> 24};
}

class GenericCoe : public testing::Test {
 protected:
  GenericCoe() { bench.enter_pre_op(); }
  std::uint32_t upload(unsigned index, unsigned sub) {
    const auto answer = bench.sdo({0x40, index & 0xFF, index >> 8, sub, 0, 0, 0, 0});
    EXPECT_EQ(answer.size(), 8U);
    EXPECT_EQ(answer[0] & 0xE2U, 0x42U) << std::hex << index << ":" << sub;  // expedited
    return answer[4] | answer[5] << 8 | answer[6] << 16 | answer[7] << 24;
  }
  DeviceBench bench{example("MX4"), [] {
                      GenericOptions options;
                      options.serial_number = 77;
                      return options;
                    }()};
};

TEST_F(GenericCoe, IdentityIsThatOfTheEeprom) {
  EXPECT_EQ(upload(0x1018, 0), 4U);
  EXPECT_EQ(upload(0x1018, 1), 0xE0000DD1U);
  EXPECT_EQ(upload(0x1018, 2), 0x440U);
  EXPECT_EQ(upload(0x1018, 3), 1U);
  EXPECT_EQ(upload(0x1018, 4), 77U);
  EXPECT_EQ(upload(0x1000, 0), 0x1389U);  // the dictionary of the file has it
  const auto name = bench.sdo({0x40, 0x08, 0x10, 0, 0, 0, 0, 0});
  EXPECT_EQ(std::string(name.begin() + 8, name.end()), "MX4 mixed device, two sync managers each way");
  for (const unsigned index : {0x09U, 0x0AU}) {
    const auto version = bench.sdo({0x40, index, 0x10, 0, 0, 0, 0, 0});
    EXPECT_EQ(std::string(version.begin() + 8, version.end()), "simulation");
  }
}

TEST_F(GenericCoe, SyncManagersAndTheirPdos) {
  EXPECT_EQ(upload(0x1C00, 0), 6U);
  constexpr std::array<unsigned, 6> kUses = {1, 2, 3, 4, 3, 4};
  for (unsigned n = 1; n <= 6; ++n) EXPECT_EQ(upload(0x1C00, n), kUses.at(n - 1));
  EXPECT_EQ(upload(0x1C12, 0), 1U);
  EXPECT_EQ(upload(0x1C12, 1), 0x1600U);
  EXPECT_EQ(upload(0x1C14, 1), 0x1610U);
  EXPECT_EQ(upload(0x1C13, 1), 0x1A00U);
  EXPECT_EQ(upload(0x1C15, 1), 0x1A10U);
  EXPECT_EQ(upload(0x1600, 0), 5U);
  EXPECT_EQ(upload(0x1600, 3), 0x70000310U);
  EXPECT_EQ(upload(0x1600, 4), 0x00000004U);
  for (const unsigned index : {0x1C32U, 0x1C33U, 0x1C34U, 0x1C35U}) {
    EXPECT_EQ(upload(index, 0), 6U);
    EXPECT_EQ(upload(index, 1), 0U);
    EXPECT_EQ(upload(index, 4), 3U);  // free run and synchronous with the frame; no DC modes
    EXPECT_EQ(upload(index, 5), 125000U);
  }
}

TEST_F(GenericCoe, InputsMayFollowTheEventOfTheOutputs) {
  const auto write = [](DeviceBench& to, unsigned index, unsigned type) {
    return to.sdo({0x2B, index & 0xFF, index >> 8, 1, type, 0, 0, 0});
  };
  EXPECT_EQ(write(bench, 0x1C33, 0x22).at(0), 0x60U);
  EXPECT_EQ(write(bench, 0x1C35, 0x22).at(0), 0x60U);
  EXPECT_EQ(write(bench, 0x1C33, 0x21), aborted(0x1C33, 1, 0x06090030));
  EXPECT_EQ(write(bench, 0x1C32, 0x22), aborted(0x1C32, 1, 0x06090031)) << "outputs";
  EXPECT_EQ(upload(0x1C33, 1), 0x22U);
  DeviceBench inputs_only(example("AI2"));
  inputs_only.enter_pre_op();
  EXPECT_EQ(write(inputs_only, 0x1C33, 0x22), aborted(0x1C33, 1, 0x06090031));
}

TEST_F(GenericCoe, ShowsTheCycleOfSync0ThatRuns) {
  bench.device().sync_started(0ns);
  EXPECT_EQ(upload(0x1C32, 2), 125'000U) << "no SYNC0";
  bench.device().sync_started(1750us);
  for (const unsigned index : {0x1C32U, 0x1C33U, 0x1C34U, 0x1C35U}) EXPECT_EQ(upload(index, 2), 1'750'000U);
}

TEST_F(GenericCoe, DefaultsOfEveryKind) {
  EXPECT_EQ(upload(0x8000, 1), 1U);
  EXPECT_EQ(upload(0x8000, 2), 5U);
  EXPECT_EQ(upload(0x8000, 3), 100U);
  EXPECT_THAT(bench.sdo({0x40, 0x00, 0x80, 4, 0, 0, 0, 0}),
              ElementsAre(0x41, 0x00, 0x80, 4, 8, 0, 0, 0, 0x10, 0x32, 0x54, 0x76, 0x98, 0xBA, 0xDC, 0xFE));
  EXPECT_THAT(bench.sdo({0x40, 0x10, 0x80, 1, 0, 0, 0, 0}),
              ElementsAre(0x41, 0x10, 0x80, 1, 12, 0, 0, 0, 'l', 'e', 'f', 't', 0, 0, 0, 0, 0, 0, 0, 0));
}

TEST_F(GenericCoe, RangesAndAccessOfTheFile) {
  EXPECT_EQ(bench.sdo({0x2B, 0x00, 0x80, 3, 9, 0, 0, 0}), aborted(0x8000, 3, 0x06090032));
  EXPECT_EQ(bench.sdo({0x2B, 0x00, 0x80, 3, 0xE9, 3, 0, 0}), aborted(0x8000, 3, 0x06090031));
  EXPECT_EQ(bench.sdo({0x2F, 0x00, 0x80, 2, 8, 0, 0, 0}), aborted(0x8000, 2, 0x06090031));  // three bits
  EXPECT_EQ(bench.sdo({0x2F, 0x00, 0x80, 0, 1, 0, 0, 0}), aborted(0x8000, 0, 0x06010002));
  EXPECT_EQ(bench.sdo({0x2B, 0x00, 0x80, 3, 0xE8, 3, 0, 0})[0], 0x60U);
  EXPECT_EQ(upload(0x8000, 3), 1000U);
}

TEST_F(GenericCoe, CompleteAccessWithThePlacesOfTheFile) {
  EXPECT_THAT(bench.sdo({0x50, 0x00, 0x80, 0, 0, 0, 0, 0}),
              ElementsAre(0x51, 0x00, 0x80, 0, 14, 0, 0, 0, 4, 0, 0x0B, 0, 100, 0, 0x10, 0x32, 0x54, 0x76, 0x98, 0xBA,
                          0xDC, 0xFE));
}

TEST_F(GenericCoe, SdoInformationInBits) {
  const auto entry = bench.coe({0x00, 0x80, 5, 0, 0, 0, 0x00, 0x80, 2, 0x10});
  // value info 10h, type BIT3 (32h), 3 bits, read and write, default 5
  EXPECT_EQ(Answer(entry.begin() + 6, entry.begin() + 17),
            (Answer{0x00, 0x80, 2, 0x10, 0x32, 0x00, 3, 0, 0x3F, 0x00, 5}));
  EXPECT_EQ(std::string(entry.begin() + 17, entry.end()), "Filter kind");
}

TEST_F(GenericCoe, RemapsAndReassignsWhatTheDeviceLetsIt) {
  // 1600h: only the set-point; assignment of sync manager 2 and 4 swapped off and on
  EXPECT_EQ(bench.sdo({0x2F, 0x00, 0x16, 0, 0, 0, 0, 0})[0], 0x60U);
  EXPECT_EQ(bench.sdo({0x23, 0x00, 0x16, 1, 0x10, 0x03, 0x00, 0x70})[0], 0x60U);
  EXPECT_EQ(bench.sdo({0x2F, 0x00, 0x16, 0, 1, 0, 0, 0})[0], 0x60U);
  EXPECT_EQ(bench.device().process_data_size(2), 2U);
  EXPECT_EQ(bench.sdo({0x2F, 0x10, 0x16, 0, 0, 0, 0, 0}), aborted(0x1610, 0, 0x06010002));  // fixed content
  // 1C14h takes both, with complete access; the mapping of SM2 stays
  EXPECT_EQ(bench.sdo({0x31, 0x14, 0x1C, 0, 6, 0, 0, 0, 2, 0, 0x10, 0x16, 0x00, 0x16})[0], 0x60U);
  EXPECT_EQ(bench.device().process_data_size(4), 5U);
  EXPECT_EQ(bench.sdo({0x3B, 0x12, 0x1C, 0, 0, 0, 0, 0})[0], 0x60U);
  EXPECT_EQ(bench.device().process_data_size(2), 0U);
  bench.map_process_data();
  bench.request(AlState::kSafeOp);
  EXPECT_TRUE(bench.is_in(AlState::kSafeOp));
  EXPECT_EQ(bench.sdo({0x2F, 0x12, 0x1C, 0, 0, 0, 0, 0}), aborted(0x1C12, 0, 0x08000022));  // not any more
}

TEST_F(GenericCoe, AFailedCompleteAssignmentLeavesTheProcessDataAlone) {
  EXPECT_EQ(bench.sdo({0x31, 0x12, 0x1C, 0, 4, 0, 0, 0, 1, 0, 0x00, 0x1A}), aborted(0x1C12, 0, 0x06020000));
  EXPECT_EQ(upload(0x1C12, 1), 0x1600U);
  EXPECT_EQ(bench.device().process_data_size(2), 6U);
}

TEST_F(GenericCoe, SdoSeesTheProcessData) {
  bench.map_process_data();
  bench.request(AlState::kSafeOp);
  bench.exchange({}, 3);
  bench.request(AlState::kOp);
  const auto outputs = bytes({0x3B, 0x12, 0x08, 'a', 'b', 'c', 0x42, 0xEF, 0xBE});
  for (int i = 0; i < 3; ++i) bench.exchange(outputs, 3);
  ASSERT_TRUE(bench.is_in(AlState::kOp));
  EXPECT_EQ(upload(0x6000, 2), 0x8123U);
  EXPECT_EQ(upload(0x7010, 2), 0xBEEFU);
}

TEST(GenericExclusion, PdosThatExcludeEachOtherAreRefusedInSafeOp) {
  DeviceBench bench(example("AI2"));
  bench.enter_pre_op();
  EXPECT_EQ(bench.sdo({0x31, 0x13, 0x1C, 0, 6, 0, 0, 0, 2, 0, 0x00, 0x1A, 0x01, 0x1A})[0], 0x60U);
  bench.map_process_data();
  bench.request(AlState::kSafeOp);
  EXPECT_EQ(bench.code(), AlStatusCode::kInvalidInputMapping);
}

TEST(GenericWithoutSdoInformation, OrCompleteAccessSaysSo) {
  auto description = example("MX4");
  description.mailbox.coe_sdo_info = description.mailbox.coe_complete_access = false;
  description.mailbox.coe_pdo_assign = description.mailbox.coe_pdo_config = false;
  DeviceBench bench(description);
  bench.enter_pre_op();
  EXPECT_THAT(bench.coe({0x00, 0x80, 1, 0, 0, 0, 1, 0}), ElementsAre(1, 0, 4, 0));  // mailbox error
  EXPECT_EQ(bench.sdo({0x50, 0x18, 0x10, 0, 0, 0, 0, 0}), aborted(0x1018, 0, 0x06010004));
  EXPECT_EQ(bench.sdo({0x2F, 0x12, 0x1C, 0, 0, 0, 0, 0}), aborted(0x1C12, 0, 0x06010002));
  EXPECT_EQ(bench.sdo({0x2F, 0x00, 0x16, 0, 0, 0, 0, 0}), aborted(0x1600, 0, 0x06010002));
}

}  // namespace
}  // namespace driveline::slaves::generic

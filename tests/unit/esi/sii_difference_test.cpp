#include "driveline/esi/sii_difference.hpp"

#include <gmock/gmock.h>

#include "sample_device.hpp"

namespace driveline::esi {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

SiiImage sample() {
  return make_sii(test::sample_device());
}

template <typename T>
T& content(SiiImage& image, SiiCategoryType type) {
  for (auto& category : image.categories) {
    if (category.type == type) return std::get<T>(category.content);
  }
  throw std::logic_error("the sample has no such category");
}

TEST(SiiDifferences, NoneBetweenEqualImages) {
  EXPECT_THAT(compare_sii(sample(), sample()), IsEmpty());
}

TEST(SiiDifferences, WhatBelongsToTheSingleDeviceIsPassedOver) {
  auto found = sample();
  found.serial_number += 1;
  found.config.station_alias = 4711;
  found.checksum = sii_checksum(found.config.bytes());
  EXPECT_THAT(compare_sii(found, sample()), IsEmpty());
}

TEST(SiiDifferences, TextNumbersDoNotMatterButTextsDo) {
  auto found = sample();
  auto& strings = content<SiiStrings>(found, SiiCategoryType::kStrings);
  auto& general = content<SiiGeneral>(found, SiiCategoryType::kGeneral);
  strings.texts.push_back(std::string(found.text(general.name_text)));
  general.name_text = static_cast<std::uint8_t>(strings.texts.size());
  EXPECT_THAT(compare_sii(found, sample()), IsEmpty());
  strings.texts.back() = "another";
  const auto name = std::string(sample().text(sample().find<SiiGeneral>(SiiCategoryType::kGeneral)->name_text));
  EXPECT_THAT(compare_sii(found, sample()), ElementsAre(SiiDifference{"name", "\"another\"", "\"" + name + "\""}));
}

TEST(SiiDifferences, HeaderFieldsAreNamed) {
  auto found = sample();
  found.revision ^= 1;
  const auto planned = sample();
  const auto differences = compare_sii(found, planned);
  ASSERT_EQ(differences.size(), 1U);
  EXPECT_EQ(differences[0].what, "revision");
  EXPECT_NE(differences[0].found, differences[0].planned);
}

TEST(SiiDifferences, InvalidChecksumIsOne) {
  auto found = sample();
  found.checksum ^= 0x01;
  const auto differences = compare_sii(found, sample());
  ASSERT_EQ(differences.size(), 1U);
  EXPECT_EQ(differences[0].what, "checksum");
}

TEST(SiiDifferences, EveryPartIsLookedAt) {
  const auto changed_by = [](auto change) {
    auto found = sample();
    change(found);
    std::vector<std::string> what;
    for (const auto& difference : compare_sii(found, sample())) what.push_back(difference.what);
    return what;
  };
  using Channels = std::vector<SiiSyncManager>;
  using Pdos = std::vector<SiiPdo>;
  using Modes = std::vector<SiiDcMode>;
  EXPECT_THAT(changed_by([](SiiImage& i) { i.standard_mailbox.send_size += 2; }), ElementsAre("standard mailboxes"));
  EXPECT_THAT(changed_by([](SiiImage& i) { i.mailbox_protocols ^= 1; }), ElementsAre("mailbox protocols"));
  EXPECT_THAT(changed_by([](SiiImage& i) { content<SiiFmmus>(i, SiiCategoryType::kFmmu).uses[0] ^= 3; }),
              ElementsAre("FMMUs"));
  EXPECT_THAT(changed_by([](SiiImage& i) { content<Channels>(i, SiiCategoryType::kSyncManager)[1].length += 1; }),
              ElementsAre("sync manager 1"));
  EXPECT_THAT(changed_by([](SiiImage& i) { content<Channels>(i, SiiCategoryType::kSyncManager).pop_back(); }),
              ElementsAre("sync managers"));
  EXPECT_THAT(changed_by([](SiiImage& i) { content<Pdos>(i, SiiCategoryType::kRxPdo)[0].entries[0].bit_length += 1; }),
              ElementsAre(testing::MatchesRegex("RxPDO 0x[0-9A-F]+, entry 1")));
  EXPECT_THAT(changed_by([](SiiImage& i) { content<Pdos>(i, SiiCategoryType::kTxPdo)[0].index ^= 0x80; }),
              ElementsAre(testing::StartsWith("TxPDO"), testing::StartsWith("TxPDO")));
  EXPECT_THAT(
      changed_by([](SiiImage& i) { content<Modes>(i, SiiCategoryType::kDistributedClock)[0].assign_activate++; }),
      ElementsAre("DC modes"));
}

}  // namespace
}  // namespace driveline::esi

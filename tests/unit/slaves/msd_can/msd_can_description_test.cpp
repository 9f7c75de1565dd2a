// The EDS of the drives on a CAN bus, read back (MSD manual 8.1.2).
#include "can_drive_rig.hpp"
#include "driveline/esi/eds_file.hpp"
#include "support/must.hpp"

namespace driveline::slaves::msd {
namespace {

class MsdCanDescription : public ::testing::TestWithParam<Variant> {
 protected:
  [[nodiscard]] esi::EdsFile file() const {
    return *must(esi::read_eds(esi::write_eds(can_description(GetParam()), "drive.eds"), "drive.eds"));
  }
};

/// The entry of an object; a test fails without it.
const esi::ObjectEntry* entry_of(const esi::EdsFile& file, std::uint16_t index, std::uint8_t subindex) {
  for (const auto& object : file.device.objects) {
    if (object.index != index) continue;
    for (const auto& entry : object.entries) {
      if (entry.subindex == subindex) return &entry;
    }
  }
  return nullptr;
}

TEST_P(MsdCanDescription, HasEveryRowOfTheTable) {
  const auto eds = file();
  EXPECT_TRUE(eds.notes.empty());
  EXPECT_EQ(eds.device.product_code, facts(GetParam()).product_code);
  std::size_t entries = 0;
  for (const auto& object : eds.device.objects) entries += object.entries.size();
  const auto rows = can_dictionary_table(GetParam()).rows();
  EXPECT_EQ(entries, rows.size());
  for (const EntryRow& row : rows) {
    const auto* entry = entry_of(eds, row.index, row.subindex);
    ASSERT_NE(entry, nullptr) << std::hex << row.index;
    EXPECT_EQ(entry->type, row.type) << std::hex << row.index;
    EXPECT_EQ(entry->writable, (row.access & access::kWrite) != 0) << std::hex << row.index;
    const bool mappable = (row.access & (access::kRxMappable | access::kTxMappable)) != 0;
    EXPECT_EQ(entry->rx_mappable || entry->tx_mappable, mappable) << std::hex << row.index;
  }
}

TEST_P(MsdCanDescription, CobIdsCountFromTheNodeId) {
  const auto eds = file();
  EXPECT_EQ(eds.node_id_defaults.size(), 9U);
  for (std::uint16_t i = 0; i < 4; ++i) {
    const auto hex_of = [&](std::uint16_t first, std::uint8_t node) {
      return eds.default_hex({static_cast<std::uint16_t>(first + i), 1}, node);
    };
    EXPECT_EQ(hex_of(0x1400, 12), "0C0" + std::to_string(2 + i) + "0000");
    EXPECT_EQ(hex_of(0x1800, 33), "A10" + std::to_string(1 + i) + "0000");
  }
  EXPECT_EQ(eds.default_hex({0x1014, 0}, 12), "8C000000");
  EXPECT_EQ(eds.default_hex({0x1005, 0}, 12), "80000000") << "SYNC has the same identifier everywhere";
  EXPECT_NE(esi::write_eds(can_description(GetParam()), "drive.eds").find("DefaultValue=$NODEID+0x00000180"),
            std::string::npos);
}

TEST_P(MsdCanDescription, HasTheBitRatesAndFourEmptyPdosPerDirection) {
  const auto eds = file();
  EXPECT_THAT(eds.bit_rates, ElementsAre(20, 50, 125, 250, 500, 1000));
  ASSERT_EQ(eds.device.rx_pdos.size(), 4U);
  ASSERT_EQ(eds.device.tx_pdos.size(), 4U);
  for (const auto& pdo : eds.device.tx_pdos) EXPECT_TRUE(pdo.entries.empty());
  EXPECT_EQ(entry_of(eds, 0x27D5, 0)->maximum_hex, "7F");
  EXPECT_EQ(entry_of(eds, 0x27D6, 0)->minimum_hex, "1400");
  EXPECT_EQ(entry_of(eds, 0x1016, 1) != nullptr, GetParam() == Variant::kMsd);
  EXPECT_EQ(entry_of(eds, 0x1C12, 0), nullptr);
}

INSTANTIATE_TEST_SUITE_P(Variants, MsdCanDescription,
                         ::testing::Values(Variant::kMsd, Variant::kServoOne, Variant::kServoOneJunior));

}  // namespace
}  // namespace driveline::slaves::msd

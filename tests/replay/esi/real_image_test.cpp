#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ostream>
#include <random>

#include "driveline/esi/esi_file.hpp"
#include "driveline/esi/sii.hpp"
#include "pcapng_reader.hpp"
#include "support/must.hpp"

/// SII images read out of the EEPROMs of real devices.
namespace driveline::esi {
namespace {

using Bytes = std::vector<std::byte>;

struct RealImage {
  const char* file;
  const char* type;
  const char* name;
  std::uint32_t vendor_id;
  std::uint32_t product_code;
  std::uint32_t revision;
  std::uint32_t serial_number;
  const char* physics;
  std::size_t sync_managers;
  std::size_t rx_pdos;
  std::size_t tx_pdos;
  std::size_t dc_modes;
};

std::ostream& operator<<(std::ostream& out, const RealImage& image) {
  return out << image.file;
}

/// Facts read by hand from a hex dump of the files.
const RealImage kImages[] = {
    {"akd.hex", "AKD", "AKD EtherCAT Drive (CoE)", 0x6A, 0x00414B44, 2, 0x99830093, "YY", 4, 12, 12, 2},
    {"ek1100.hex", "EK1100", "EK1100 EtherCAT-Koppler (2A E-Bus)", 2, 0x044C2C52, 0x00120000, 0, "YKY", 0, 0, 0, 0},
    {"el2004-eeprom-dump.bin", "EL2004", "EL2004 4K. Dig. Ausgang 24V, 0.5A", 2, 0x07D43052, 0x00100000, 0, "KK", 1, 4,
     0, 0},
};

class RealSii : public ::testing::TestWithParam<RealImage> {
 protected:
  void SetUp() override {
    const auto file = replay::find_capture(GetParam().file);
    if (!file) GTEST_SKIP() << replay::missing_capture_text(GetParam().file);
    bytes_ = replay::read_file(*file).value();
    ASSERT_EQ(bytes_.size(), 2048U);
  }
  const Bytes& bytes() const { return bytes_; }

 private:
  Bytes bytes_;
};

INSTANTIATE_TEST_SUITE_P(Captures, RealSii, ::testing::ValuesIn(kImages),
                         [](const auto& image) { return std::string(image.param.type); });

void expect_sane(const Bytes& bytes) {
  const auto image = decode_sii(bytes);
  if (!image) {
    ASSERT_LE(image.error().word_offset, bytes.size() / 2);
    return;
  }
  ASSERT_EQ(encode_sii(*image), bytes);
  ASSERT_TRUE(decode_sii(encode_sii(make_sii(description_from_sii(*image)))));
}

TEST_P(RealSii, DecodesToTheDeviceItCameFrom) {
  const auto image = must(decode_sii(bytes()));
  EXPECT_TRUE(image->checksum_valid());
  EXPECT_EQ(image->eeprom_bytes(), 2048U);
  EXPECT_EQ(image->version, 1);
  EXPECT_TRUE(image->tail.empty());
  const auto device = description_from_sii(*image);
  const RealImage& expected = GetParam();
  EXPECT_EQ(device.type, expected.type);
  EXPECT_EQ(device.name, expected.name);
  EXPECT_EQ(device.vendor_id, expected.vendor_id);
  EXPECT_EQ(device.product_code, expected.product_code);
  EXPECT_EQ(device.revision, expected.revision);
  EXPECT_EQ(device.serial_number, expected.serial_number);
  EXPECT_EQ(device.physics, expected.physics);
  EXPECT_EQ(device.sync_managers.size(), expected.sync_managers);
  EXPECT_EQ(device.rx_pdos.size(), expected.rx_pdos);
  EXPECT_EQ(device.tx_pdos.size(), expected.tx_pdos);
  EXPECT_EQ(device.dc_modes.size(), expected.dc_modes);
}

TEST_P(RealSii, EncodesToTheSameBytes) {
  const auto image = must(decode_sii(bytes()));
  EXPECT_EQ(encode_sii(*image), bytes());
}

TEST_P(RealSii, DescriptionSurvivesOurOwnImageAndEsiFile) {
  auto device = description_from_sii(decode_sii(bytes()).value());
  EXPECT_EQ(description_from_sii(decode_sii(encode_sii(make_sii(device))).value()), device);
  device.vendor_name = "vendor";
  const auto file = must(read_esi(write_esi({device}), "real.xml"));
  ASSERT_EQ(file->devices.size(), 1U);
  EXPECT_EQ(file->devices[0], device);
}

TEST_P(RealSii, EveryByteFlipped) {
  for (std::size_t i = 0; i < bytes().size(); ++i) {
    SCOPED_TRACE(i);
    Bytes damaged = bytes();
    damaged[i] ^= std::byte{0xFF};
    expect_sane(damaged);
  }
}

TEST_P(RealSii, EveryTruncation) {
  for (std::size_t size = 0; size < bytes().size(); ++size) {
    SCOPED_TRACE(size);
    expect_sane(Bytes(bytes().begin(), bytes().begin() + static_cast<std::ptrdiff_t>(size)));
  }
}

TEST_P(RealSii, RandomDamage) {
  for (unsigned seed = 1; seed <= 1000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Bytes damaged = bytes();
    for (unsigned i = 0; i <= seed % 16; ++i) damaged[128 + random() % 1500] = static_cast<std::byte>(random());
    expect_sane(damaged);
  }
}

TEST(RealAkd, DetailsOfAServoDrive) {
  const auto path = replay::find_capture("akd.hex");
  if (!path) GTEST_SKIP() << replay::missing_capture_text("akd.hex");
  const auto device = description_from_sii(decode_sii(replay::read_file(*path).value()).value());
  EXPECT_TRUE(device.mailbox.coe && device.mailbox.eoe && device.mailbox.foe);
  EXPECT_FALSE(device.mailbox.aoe || device.mailbox.soe || device.mailbox.voe);
  EXPECT_TRUE(device.mailbox.coe_pdo_assign && device.mailbox.coe_pdo_config);
  EXPECT_FALSE(device.mailbox.coe_sdo_info);
  EXPECT_THAT(device.fmmus, ::testing::ElementsAre(FmmuUse::kOutputs, FmmuUse::kInputs, FmmuUse::kMailboxState));
  EXPECT_EQ(device.sync_managers.at(0), (SyncManager{SyncManager::Use::kMailboxOut, 0x1800, 1024, 0, 0, 0x26, true}));
  EXPECT_EQ(device.sync_managers.at(3), (SyncManager{SyncManager::Use::kInputs, 0x1140, 0, 0, 0, 0x20, true}));
  EXPECT_EQ(device.rx_pdos.at(4).index, 0x1701);
  EXPECT_EQ(device.rx_pdos.at(4).entries.at(0), (PdoEntry{0x60C1, 1, 32, "1st set-point", DataType::kInteger32}));
  EXPECT_EQ(device.dc_modes.at(0).name, "DcSync");
  EXPECT_EQ(device.dc_modes.at(0).assign_activate, 0x0300);
  EXPECT_EQ(device.dc_modes.at(1).name, "DcOff");
  EXPECT_EQ(device.bootstrap_rx_offset, 0x1800);
  EXPECT_EQ(device.bootstrap_tx_size, 0x0400);
}

}  // namespace
}  // namespace driveline::esi

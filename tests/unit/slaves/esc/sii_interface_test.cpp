// The EEPROM interface 0x0500-0x050F (ETG.1000.4 6.4).
#include "bench_slave.hpp"
#include "driveline/wire/sii_access.hpp"

namespace driveline::slaves::test {
namespace {

namespace sii = wire::sii_access;

class SiiInterfaceTest : public BenchSlave {
 protected:
  /// Command and address in one datagram, as masters send it.
  std::uint16_t command(std::uint16_t control, std::uint32_t word_address) {
    std::vector<std::byte> data(6);
    bytes::store_le(std::span(data), control);
    bytes::store_le(std::span(data).subspan(2), word_address);
    return write(0x0502, data);
  }
  std::uint16_t status() { return get(reg::kSiiControl); }
};

TEST_F(SiiInterfaceTest, ReadsFourWordsPerCommand) {
  EXPECT_EQ(status(), sii::kReads8Bytes);
  EXPECT_EQ(command(sii::kCommandRead, 8), 1);
  EXPECT_EQ(status(), sii::kReads8Bytes);
  EXPECT_EQ(read(0x0508, 8).data, bytes({0x08, 0x40, 0x09, 0x40, 0x0A, 0x40, 0x0B, 0x40}));
}

TEST_F(SiiInterfaceTest, ReadsTwoWordsWhenBuiltSo) {
  SlaveOptions options;
  options.sii.reads_8_bytes = false;
  rebuild(options);
  EXPECT_EQ(status(), 0);
  command(sii::kCommandRead, 8);
  EXPECT_EQ(read(0x0508, 8).data, bytes({0x08, 0x40, 0x09, 0x40, 0, 0, 0, 0}));
}

TEST_F(SiiInterfaceTest, BeyondTheImageReadsAllOnes) {
  command(sii::kCommandRead, 63);
  EXPECT_EQ(read(0x0508, 8).data, bytes({0x3F, 0x40, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}));
  command(sii::kCommandRead, 0xFFFFFFFF);
  EXPECT_EQ(read(0x0508, 8).data, std::vector<std::byte>(8, std::byte{0xFF}));
}

TEST_F(SiiInterfaceTest, StaysBusyForItsTime) {
  SlaveOptions options;
  options.sii.busy_time = 200us;
  rebuild(options);
  command(sii::kCommandRead, 8);
  EXPECT_EQ(status(), sii::kReads8Bytes | sii::kBusy | sii::kCommandRead);
  EXPECT_EQ(read(0x0508, 2).data, bytes({0, 0}));
  EXPECT_EQ(command(sii::kCommandRead, 20), 0) << "locked while busy";
  EXPECT_EQ(write(0x0508, bytes({1})), 0);
  pass(199us);
  EXPECT_EQ(status() & sii::kBusy, sii::kBusy);
  pass(1us);
  EXPECT_EQ(status(), sii::kReads8Bytes);
  EXPECT_EQ(read(0x0508, 2).data, bytes({0x08, 0x40})) << "of the first command";
}

TEST_F(SiiInterfaceTest, WritesOneWord) {
  write(0x0508, bytes({0x34, 0x12}));
  EXPECT_EQ(command(sii::kCommandWrite | sii::kWriteEnable, 20), 1);
  EXPECT_EQ(status(), sii::kReads8Bytes);
  EXPECT_TRUE(esc().sii().modified());
  EXPECT_EQ(esc().sii().image()[40], std::byte{0x34});
  EXPECT_EQ(esc().sii().image()[41], std::byte{0x12});
  command(sii::kCommandRead, 19);
  EXPECT_EQ(read(0x0508, 6).data, bytes({0x13, 0x40, 0x34, 0x12, 0x15, 0x40}));
}

TEST_F(SiiInterfaceTest, WriteBeyondTheImageChangesNothing) {
  const std::vector<std::byte> before(esc().sii().image().begin(), esc().sii().image().end());
  write(0x0508, bytes({0x34, 0x12}));
  command(sii::kCommandWrite | sii::kWriteEnable, 64);
  command(sii::kCommandWrite | sii::kWriteEnable, 0x80000000);
  EXPECT_EQ(before, std::vector<std::byte>(esc().sii().image().begin(), esc().sii().image().end()));
  EXPECT_FALSE(esc().sii().modified());
}

TEST_F(SiiInterfaceTest, WriteNeedsTheEnableBitInTheSameAccess) {
  write(0x0508, bytes({0x34, 0x12}));
  write(0x0502, bytes({0x01}));
  command(sii::kCommandWrite, 20);
  EXPECT_EQ(status(), sii::kReads8Bytes | sii::kErrorWriteEnable);
  EXPECT_FALSE(esc().sii().modified());
  command(0, 0);
  EXPECT_EQ(status(), sii::kReads8Bytes) << "command 0 clears the error";
}

TEST_F(SiiInterfaceTest, UnknownCommandIsAnError) {
  for (const unsigned raw : {0x0300U, 0x0500U, 0x0600U, 0x0700U}) {
    command(static_cast<std::uint16_t>(raw), 8);
    EXPECT_EQ(status(), sii::kReads8Bytes | sii::kErrorAcknowledge) << raw;
    command(sii::kCommandRead, 8);
    EXPECT_EQ(status(), sii::kReads8Bytes) << "a valid command clears it";
  }
}

TEST_F(SiiInterfaceTest, OwnershipMovesToThePdiAndBack) {
  EXPECT_EQ(write(reg::kSiiConfiguration, sii::kConfigPdiOwns), 1);
  EXPECT_EQ(command(sii::kCommandRead, 8), 0) << "offered: no longer ours";
  const auto pdi = [this](std::uint16_t address, const std::vector<std::byte>& data) {
    return esc().pdi_write(address, data, now());
  };
  EXPECT_FALSE(pdi(0x0502, bytes({0x00, 0x01, 8, 0, 0, 0}))) << "not taken yet";
  EXPECT_TRUE(pdi(0x0501, bytes({1})));
  EXPECT_TRUE(pdi(0x0502, bytes({0x00, 0x01, 8, 0, 0, 0})));
  EXPECT_EQ(read(0x0508, 2).data, bytes({0x08, 0x40}));

  EXPECT_EQ(write(reg::kSiiConfiguration, 0), 1);
  EXPECT_EQ(command(sii::kCommandRead, 9), 0) << "the PDI has not let go";
  EXPECT_EQ(write(reg::kSiiConfiguration, sii::kConfigForceEcat), 1);
  EXPECT_EQ(get(reg::kSiiPdiAccess), 0);
  EXPECT_FALSE(pdi(0x0502, bytes({0x00, 0x01, 8, 0, 0, 0})));
  EXPECT_TRUE(pdi(0x0501, bytes({1})));
  EXPECT_EQ(get(reg::kSiiPdiAccess), 0) << "not while access is forced";
  EXPECT_EQ(write(reg::kSiiConfiguration, 0), 1);
  EXPECT_EQ(command(sii::kCommandRead, 9), 1);
  EXPECT_EQ(read(0x0508, 2).data, bytes({0x09, 0x40}));
}

TEST_F(SiiInterfaceTest, ConfigurationAreaIsLoadedAtPowerOn) {
  auto image = test_image(0x0C08, 0x0042);
  bytes::store_le<std::uint16_t>(std::span(image).subspan(2), 0x6677);
  bytes::store_le<std::uint16_t>(std::span(image).subspan(4), 0x01F4);
  image[14] = static_cast<std::byte>(esi::sii_checksum(std::span(image).first<14>()));
  auto own = std::make_unique<TestDevice>();
  own->own_profile.sii_image = image;
  rebuild({}, std::move(own));
  EXPECT_EQ(read(0x0140, 2).data, bytes({0x08, 0x0C}));
  EXPECT_EQ(read(0x0150, 2).data, bytes({0x77, 0x66}));
  EXPECT_EQ(get(reg::kSyncPulseLength), 0x01F4);
  EXPECT_EQ(get(reg::kStationAlias), 0x0042);
}

TEST_F(SiiInterfaceTest, NewAliasWorksAfterPowerOnNotAfterReload) {
  auto image = test_image(0x0E05, 0x0042);
  for (const unsigned word : {4U, 7U}) {
    write(0x0508, {image[2 * word], image[2 * word + 1]});
    command(sii::kCommandWrite | sii::kWriteEnable, word);
  }
  command(sii::kCommandReload, 0);
  EXPECT_EQ(status(), sii::kReads8Bytes);
  EXPECT_EQ(get(reg::kStationAlias), 0);
  slave().set_power(false, now());
  slave().set_power(true, now());
  EXPECT_EQ(get(reg::kStationAlias), 0x0042);
}

TEST_F(SiiInterfaceTest, BadChecksumKeepsTheApplicationDown) {
  auto own = std::make_unique<TestDevice>();
  own->own_profile.sii_image[0] = std::byte{0x55};
  rebuild({}, std::move(own));
  EXPECT_EQ(status(), sii::kReads8Bytes | sii::kErrorChecksum | sii::kErrorNotLoaded);
  EXPECT_EQ(get(reg::kDlStatus) & 1U, 0U) << "PDI not operational";
  EXPECT_EQ(write(reg::kAlControl, 0x0002), 1);
  pass(1s);
  expect_status(AlState::kInit);
  EXPECT_TRUE(device().transitions.empty());

  // The EEPROM can still be repaired.
  write(0x0508, bytes({0x05, 0x0E}));
  command(sii::kCommandWrite | sii::kWriteEnable, 0);
  command(sii::kCommandReload, 0);
  EXPECT_EQ(status(), sii::kReads8Bytes);
  EXPECT_EQ(get(reg::kDlStatus) & 1U, 1U);
  configure_mailboxes();
  pass(1s);
  expect_status(AlState::kPreOp);
}

TEST_F(SiiInterfaceTest, EmptyAndOddImagesAreReadable) {
  auto own = std::make_unique<TestDevice>();
  own->own_profile.sii_image = bytes({1, 2, 3});
  rebuild({}, std::move(own));
  command(sii::kCommandRead, 0);
  EXPECT_EQ(read(0x0508, 6).data, bytes({1, 2, 3, 0xFF, 0xFF, 0xFF}));
  EXPECT_NE(status() & sii::kErrorChecksum, 0);
}

TEST_F(SiiInterfaceTest, LargeEepromsHaveTwoAddressBytes) {
  auto own = std::make_unique<TestDevice>();
  own->own_profile.sii_image.resize(4096, std::byte{0xFF});
  rebuild({}, std::move(own));
  EXPECT_EQ(status(), sii::kReads8Bytes | sii::kTwoByteAddress);
}

}  // namespace
}  // namespace driveline::slaves::test

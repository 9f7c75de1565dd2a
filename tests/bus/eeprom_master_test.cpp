// Masters that get no description file set up a slave by its EEPROM alone: sync managers, FMMUs and process data are
// those of categories 40, 41, 50 and 51 (ETG.1000.6 5.4). EepromMaster does so; it shares no code with our master.
#include "eeprom_master.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "driveline/esi/sii.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "driveline/slaves/line/simulated_line.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::bus_test {
namespace {

using slaves::msd::MsdDrive;
using slaves::msd::Variant;
using std::chrono::milliseconds;
using testing::ElementsAre;

/// A simulated line, and the master that reads its EEPROMs.
struct EepromLine {
  explicit EepromLine(const std::filesystem::path& description)
      : config(*must(runtime::load_line_config(description))),
        line(runtime::make_simulated_line(config, clock)),
        master(*line, clock) {
    master.scan();
  }
  /// Takes all slaves to a state; the states before it are passed.
  void to(std::uint16_t last) {
    for (const auto state : {EepromMaster::kInit, EepromMaster::kPreOp, EepromMaster::kSafeOp, EepromMaster::kOp}) {
      if (state > last) break;
      ASSERT_EQ(master.request_all(state), "") << "state " << state;
    }
  }

  runtime::LineConfig config;
  rt::VirtualClock clock{milliseconds{1}};
  std::unique_ptr<slaves::SimulatedLine> line;
  EepromMaster master;
};

/// The line of examples/mixed.toml, by position.
enum Mixed : std::size_t { kCoupler, kInputs, kOutputs, kAnalogue, kMixed, kX, kY, kMixedSlaves };
constexpr const char* kMixedLine = "examples/mixed.toml";  // tests run in the top folder of the project

TEST(EepromMaster, TakesTheMixedLineOfTheExamplesToOp) {
  EepromLine mixed(kMixedLine);
  auto& master = mixed.master;
  ASSERT_EQ(master.slaves().size(), kMixedSlaves);
  EXPECT_EQ(master.slaves()[kAnalogue].product_code, 0x302U);
  EXPECT_EQ(master.slaves()[kX].product_code, MsdDrive::description().product_code);
  ASSERT_NO_FATAL_FAILURE(mixed.to(EepromMaster::kSafeOp));
  // A slave counts 3 if it is written and read, 2 if it is only written, 1 if it is only read (ETG.1000.4 Table
  // 17). Drives have no PDOs as delivered: only the state of their mailboxes is read.
  std::vector<unsigned> counts;
  for (const auto& slave : master.slaves()) counts.push_back(slave.working_counter);
  EXPECT_THAT(counts, ElementsAre(0, 1, 2, 1, 3, 1, 1));
  EXPECT_EQ(master.exchange(), 9);
  ASSERT_NO_FATAL_FAILURE(mixed.to(EepromMaster::kOp));

  master.set(kMixed, 0x7000, 2, 5);
  master.set(kMixed, 0x7000, 3, 0x8123);
  master.set(kMixed, 0x7010, 2, 0xBEEF);
  master.set(kOutputs, 0x7020, 1, 1);
  std::set<std::uint64_t> toggles;
  EXPECT_EQ(master.run(1000, [&] { toggles.insert(master.get(kInputs, 0x6000, 1)); }), 0U);
  EXPECT_THAT(toggles, ElementsAre(0, 1));
  EXPECT_EQ(master.get(kAnalogue, 0x6010, 0x11), 1234U);
  EXPECT_EQ(master.get(kMixed, 0x6000, 1), 5U);
  EXPECT_EQ(master.get(kMixed, 0x6000, 2), 0x8123U);
  EXPECT_EQ(master.get(kMixed, 0x6010, 2), 0xBEEFU);
  const auto& digital = mixed.line->slave(kOutputs).esc();
  EXPECT_EQ(digital.memory().get(wire::reg::kDigitalOutput) & 0xFU, 4U) << "channel 3 of 4";
  for (std::size_t i = 0; i < kMixedSlaves; ++i) EXPECT_EQ(mixed.line->slave(i).state(), wire::AlState::kOp) << i;
}

TEST(EepromMaster, TakesADeviceWithTwoSyncManagersInEachDirection) {
  test::TemporaryFolder folder;
  std::filesystem::copy("examples/terminals.xml", folder.path);
  std::ofstream(folder.path / "line.toml") << "[line]\nname = \"two\"\ncycle_us = 1000\n"
                                              "[[slave]]\nname = \"four\"\nesi = \"terminals.xml\"\ndevice = \"MX4\"\n";
  EepromLine two(folder.path / "line.toml");
  ASSERT_NO_FATAL_FAILURE(two.to(EepromMaster::kOp));
  two.master.set(0, 0x7000, 3, 0x1234);
  two.master.set(0, 0x7010, 2, 0xA55A);
  EXPECT_EQ(two.master.run(10), 0U);
  EXPECT_EQ(two.master.get(0, 0x6000, 2), 0x1234U);
  EXPECT_EQ(two.master.get(0, 0x6010, 2), 0xA55AU);
}

/// Drives of all variants that were commissioned before: their first PDOs are mapped and stored, and their EEPROMs
/// describe them.
class CommissionedDrives : public testing::Test {
 protected:
  static constexpr std::array kVariants = {Variant::kMsd, Variant::kServoOne, Variant::kServoOneJunior};

  void SetUp() override {
    std::ofstream description(folder_.path / "line.toml");
    description << "[line]\nname = \"drives\"\ncycle_us = 1000\n";
    for (std::size_t i = 0; i < kVariants.size(); ++i) {
      static constexpr std::array kModels = {"msd", "servoone", "servoone_junior"};
      const std::string name = "d" + std::to_string(i);
      description << "[[slave]]\nname = \"" << name << "\"\nmodel = \"" << kModels[i] << "\"\nsii_file = \"" << name
                  << ".bin\"\nparameter_file = \"" << name << ".txt\"\n";
      store_mapping(folder_.path / (name + ".txt"));
      store_eeprom(folder_.path / (name + ".bin"), kVariants[i]);
    }
    description.close();
    drives_ = std::make_unique<EepromLine>(folder_.path / "line.toml");
  }

  /// 6040h, 6060h, P 2055 as a filler and 607Ah; 6041h, 6061h, the filler and 6064h.
  static void store_mapping(const std::filesystem::path& file) {
    std::ofstream out(file);
    const auto map = [&](const char* pdo, const std::array<std::uint32_t, 4>& entries) {
      for (std::size_t i = 0; i < entries.size(); ++i) out << pdo << ":0" << i + 1 << " = " << entries[i] << '\n';
      out << pdo << ":00 = " << entries.size() << '\n';
    };
    map("1600", {0x60400010, 0x60600008, 0x28070008, 0x607A0020});
    map("1A00", {0x60410010, 0x60610008, 0x28070008, 0x60640020});
  }
  static void store_eeprom(const std::filesystem::path& file, Variant variant) {
    auto device = MsdDrive::description(variant);
    device.rx_pdos[0].entries = {{0x6040, 0, 16, {}}, {0x6060, 0, 8, {}}, {0x2807, 0, 8, {}}, {0x607A, 0, 32, {}}};
    device.tx_pdos[0].entries = {{0x6041, 0, 16, {}}, {0x6061, 0, 8, {}}, {0x2807, 0, 8, {}}, {0x6064, 0, 32, {}}};
    const auto image = esi::encode_sii(esi::make_sii(device));
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(image.data()), static_cast<std::streamsize>(image.size()));
  }
  [[nodiscard]] EepromMaster& master() { return drives_->master; }

  test::TemporaryFolder folder_;
  std::unique_ptr<EepromLine> drives_;
};

TEST_F(CommissionedDrives, SendTheirStatusWordsAndTakeControlWords) {
  ASSERT_NO_FATAL_FAILURE(drives_->to(EepromMaster::kSafeOp));
  EXPECT_EQ(master().expected_working_counter(), 9);
  ASSERT_NO_FATAL_FAILURE(drives_->to(EepromMaster::kOp));
  EXPECT_EQ(master().run(100), 0U);
  for (std::size_t i = 0; i < kVariants.size(); ++i) EXPECT_NE(master().get(i, 0x6041, 0), 0U) << i;
  // Shutdown, switch on, enable operation, at the present position (CiA 402, Table 25).
  for (const unsigned control : {0x06U, 0x07U, 0x0FU}) {
    for (std::size_t i = 0; i < kVariants.size(); ++i) {
      master().set(i, 0x6060, 0, 8);
      master().set(i, 0x607A, 0, master().get(i, 0x6064, 0));
      master().set(i, 0x6040, 0, control);
    }
    EXPECT_EQ(master().run(300), 0U);
  }
  for (std::size_t i = 0; i < kVariants.size(); ++i) {
    EXPECT_EQ(master().get(i, 0x6041, 0) & 0x6FU, 0x27U) << "drive " << i << " is not in Operation enabled";
    EXPECT_EQ(master().get(i, 0x6061, 0), 8U) << i;
  }
}

TEST_F(CommissionedDrives, RefuseSyncManagersOfAnotherLengthUntilItIsRight) {
  struct Case {
    std::size_t slave;
    std::size_t sync_manager;
    int more;
    std::uint16_t code;
  };
  constexpr std::uint16_t kOutputsRefused = 0x001D;
  constexpr std::uint16_t kInputsRefused = 0x001E;
  ASSERT_NO_FATAL_FAILURE(drives_->to(EepromMaster::kPreOp));
  for (const auto& c : {Case{0, 2, 1, kOutputsRefused}, Case{1, 2, -2, kOutputsRefused}, Case{2, 3, 2, kInputsRefused},
                        Case{0, 3, -8, kInputsRefused}}) {
    auto& length = master().slaves()[c.slave].sync_managers[c.sync_manager].length;
    const auto right = length;
    length = static_cast<std::uint16_t>(length + c.more);
    const auto refused = master().request(c.slave, EepromMaster::kSafeOp);
    EXPECT_EQ(refused.status, EepromMaster::kPreOp | EepromMaster::kError) << "drive " << c.slave;
    EXPECT_EQ(refused.code, c.code) << "drive " << c.slave;
    length = right;
    const auto taken = master().request(c.slave, EepromMaster::kSafeOp, true);
    EXPECT_EQ(taken.status, EepromMaster::kSafeOp) << "drive " << c.slave << ", AL status code " << taken.code;
    EXPECT_EQ(master().request(c.slave, EepromMaster::kPreOp).status, EepromMaster::kPreOp);
  }
}

TEST(EepromMaster, HearsFromDevicesOfADescriptionFileWhichLengthIsWrong) {
  EepromLine mixed(kMixedLine);
  auto& master = mixed.master;
  ASSERT_NO_FATAL_FAILURE(mixed.to(EepromMaster::kPreOp));
  auto& outputs = master.slaves()[kMixed].sync_managers[2].length;
  ASSERT_EQ(outputs, 9);
  outputs = 10;
  EXPECT_EQ(master.request(kMixed, EepromMaster::kSafeOp).code, 0x001D);
  outputs = 9;
  auto& inputs = master.slaves()[kMixed].sync_managers[3].length;
  ASSERT_EQ(inputs, 9);
  inputs = 8;
  EXPECT_EQ(master.request(kMixed, EepromMaster::kSafeOp, true).code, 0x001E);
  inputs = 9;
  EXPECT_EQ(master.request(kMixed, EepromMaster::kSafeOp, true).status, EepromMaster::kSafeOp);
}

}  // namespace
}  // namespace driveline::bus_test

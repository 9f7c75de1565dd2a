#include <gmock/gmock.h>

#include <random>

#include "drive_line.hpp"
#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/foe/foe_client.hpp"
#include "driveline/slaves/mailbox/foe_server.hpp"
#include "driveline/slaves/msd/core/firmware_image.hpp"
#include "driveline/slaves/msd/device_layout.hpp"
#include "fault_ports.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
using ecat_master::FileName;
using ecat_master::FileTransfer;
using ecat_master::FoeClient;
using ecat_master::Master;
using slaves::msd::DriveFiles;
using slaves::msd::FirmwareVersion;
using slaves::msd::MsdParameters;
using slaves::msd::Variant;
using wire::AlState;
using Bytes = std::vector<std::byte>;

constexpr std::uint32_t kPassword = 0x89ABCDEF;
constexpr FirmwareVersion kNewVersion{124, 31, 7};
FileName parameters() {
  return {std::string(DriveFiles::kParameterSet), kPassword};
}

template <typename T>
std::string sentence(const ecat_master::FileResult<T>& result) {
  return result ? std::string{} : describe(result.error());
}
using bus_test::sentence;

Bytes bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

std::string text_of(const Bytes& bytes) {
  std::string text;
  for (const auto byte : bytes) text += static_cast<char>(byte);
  return text;
}

Bytes firmware(std::size_t program_bytes, Variant variant = Variant::kMsd) {
  std::mt19937 random(7);
  Bytes program(program_bytes);
  for (auto& byte : program) byte = static_cast<std::byte>(random());
  return make_firmware(variant, kNewVersion, program);
}

/// Two drives whose files require a password.
struct FileLine {
  FileLine() : line(make()), master(*line, clock) {}

  std::unique_ptr<slaves::SimulatedLine> make() {
    std::vector<std::unique_ptr<slaves::Slave>> made;
    for (std::uint32_t i = 0; i < 2; ++i) {
      MsdParameters parameters;
      parameters.serial_number = 1000 + i;
      parameters.file_password = kPassword;
      auto drive = std::make_unique<slaves::msd::MsdDrive>(parameters);
      drives.push_back(&drive->core());
      made.push_back(std::make_unique<slaves::Slave>(std::move(drive), slaves::SlaveOptions{}));
    }
    return std::make_unique<slaves::SimulatedLine>(clock, std::move(made), slaves::LineOptions{}, std::nullopt);
  }
  void to_pre_op() {
    ASSERT_EQ(sentence(master.scan()), "");
    ASSERT_EQ(sentence(master.enter_pre_op()), "");
  }
  void to_boot() {
    ASSERT_EQ(sentence(master.scan()), "");
    boot = std::move(*enter_bootstrap(master.mailboxes(), master.slaves()[0].info));
    ASSERT_EQ(line->slave(0).state(), AlState::kBootstrap);
  }
  void to_init() {
    const std::array refs{master.slaves()[0].info.ref};
    ASSERT_EQ(sentence(change_state(master.bus(), refs, AlState::kInit, std::chrono::seconds{1})), "");
  }
  FoeClient foe() { return FoeClient(master.mailboxes(), 0); }
  /// 100Ah, read by the master.
  std::string version() {
    to_pre_op();
    return text_of(CoeClient(master.mailboxes(), 0).upload(0x100A, 0).value());
  }
  std::vector<slaves::msd::DriveCore*> drives;
  rt::VirtualClock clock{milliseconds{1}};
  std::unique_ptr<slaves::SimulatedLine> line;
  Master master;
  std::unique_ptr<ecat_master::MailboxClient> boot;
};

TEST(FoeFirmware, IsTakenInBootAndSeenIn100AAfterTheRestart) {
  FileLine line;
  line.to_boot();
  EXPECT_EQ(line.drives[0]->firmware().text(), "124.30-00");
  const auto file = firmware(20'000);
  const auto transfer = line.foe().start_write({"msd.efw", kPassword}, file);
  line.master.mailboxes().wait(*transfer);
  ASSERT_EQ(sentence(transfer->result()), "");
  EXPECT_EQ(transfer->transferred(), file.size());
  EXPECT_EQ(line.drives[0]->firmware().text(), "124.30-00") << "until the restart";
  line.to_init();
  EXPECT_EQ(line.version(), "124.31-07");
}

TEST(FoeFirmware, WrongFilesAreRefusedByTheirCodesAndNothingIsLost) {
  FileLine line;
  line.to_boot();
  auto damaged = firmware(2000);
  damaged.back() ^= std::byte{1};
  auto longer = firmware(2000);
  longer.push_back(std::byte{0});
  const struct {
    const char* name;
    Bytes content;
    const char* sentence;
  } cases[] = {
      {"a.efw", bytes_of("this is a text"), "0x8010 (the file has no header): this is not a firmware file"},
      {"a.efw", {}, "0x8010 (the file has no header): this is not a firmware file"},
      {"a.efw", firmware(2000, Variant::kServoOne),
       "0x800D (firmware does not fit the hardware): the firmware is for another drive"},
      {"a.efw", damaged, "0x800C (checksum wrong): the firmware is damaged"},
      {"a.efw", longer, "0x8004 (illegal): the firmware is not as long as its header says"},
      {"a.efw", make_firmware(Variant::kMsd, {123, 0, 0}, {}),
       "0x8012 (file incompatible): the firmware is older than this drive"},
      {"a.bin", firmware(2000), "0x8001 (not found): the drive has parameters.txt and accepts *.efw"},
      {"parameters.txt", firmware(2000), "0x8009 (not in bootstrap): only firmware is accepted in BOOT"},
      {"a.efw", Bytes(DriveFiles::kMaxFirmware + 1), "0x8003 (disk full): at most 8388608 bytes"},
  };
  for (const auto& c : cases) {
    EXPECT_EQ(sentence(line.foe().write({c.name, kPassword}, c.content)),
              std::string("slave 0: refused the file with FoE error ") + c.sentence);
  }
  EXPECT_EQ(sentence(line.foe().read({"a.efw", kPassword})),
            "slave 0: refused the file with FoE error 0x8002 (access denied): firmware cannot be read back");
  line.to_init();
  EXPECT_EQ(line.version(), "124.30-00");
}

TEST(FoeFirmware, ThatBreaksOffLeavesTheOldOne) {
  FileLine line;
  line.to_boot();
  const auto file = firmware(20'000);
  const auto transfer = line.foe().start_write({"msd.efw", kPassword}, file);
  while (transfer->transferred() < file.size() / 2) line.master.mailboxes().drive();
  line.to_init();
  line.master.mailboxes().close(0);
  EXPECT_TRUE(transfer->done());
  EXPECT_EQ(line.version(), "124.30-00");
}

TEST(FoeFirmware, IsNotTakenOutsideBoot) {
  FileLine line;
  line.to_pre_op();
  EXPECT_EQ(sentence(line.foe().write({"msd.efw", kPassword}, firmware(10))),
            "slave 0: refused the file with FoE error 0x8008 (in bootstrap only): firmware is accepted in BOOT only");
}

TEST(FoeParameters, GoThereAndBack) {
  FileLine line;
  line.to_pre_op();
  const auto set = line.foe().read(parameters());
  ASSERT_EQ(sentence(set), "");
  EXPECT_GT(set->size(), 5000U);
  CoeClient coe(line.master.mailboxes(), 0);
  const auto before = coe.upload_as<std::uint32_t>(0x6065, 0).value();
  ASSERT_EQ(sentence(coe.download_as<std::uint32_t>(0x6065, 0, 4711)), "");
  const auto changed = line.foe().read(parameters());
  EXPECT_THAT(text_of(changed.value()), testing::HasSubstr("6065:00 = 4711"));
  ASSERT_EQ(sentence(line.foe().write(parameters(), *set)), "");
  EXPECT_EQ(coe.upload_as<std::uint32_t>(0x6065, 0).value(), before);
  EXPECT_EQ(line.foe().read(parameters()).value(), *set);
  line.line->set_power(0, false);
  line.line->set_power(0, true);
  line.to_pre_op();
  EXPECT_EQ(line.foe().read(parameters()).value(), *set) << "stored";
}

TEST(FoeParameters, WithAnythingWrongChangeNothing) {
  FileLine line;
  line.to_pre_op();
  const auto set = line.foe().read(parameters()).value();
  const std::pair<const char*, const char*> cases[] = {
      {"6065:00 = 1\n7777:00 = 1\n", "0x8004 (illegal): line 2: there is no such object"},
      {"6065:00 = 1\nnonsense\n", "0x8004 (illegal): line 2: `index:sub-index = value` is expected"},
      {"6065:00 = 1\n607D:01 = 100\n607D:02 = -100\n", "0x8004 (illegal): the values contradict each other"},
  };
  for (const auto& [text, answer] : cases) {
    EXPECT_EQ(sentence(line.foe().write(parameters(), bytes_of(text))),
              std::string("slave 0: refused the file with FoE error ") + answer);
    EXPECT_EQ(line.foe().read(parameters()).value(), set);
  }
}

TEST(FoeParameters, AreReadInOperationAndWrittenInPreOpOnly) {
  DriveLine drives(2);
  FollowingOperation operation(drives, RunOptions{.repeat = true});
  FoeClient foe(operation.master().mailboxes(), 0);
  const auto set = foe.read({"parameters.txt", 0});
  ASSERT_EQ(sentence(set), "");
  EXPECT_EQ(text_of(*set), drives.drive(0).parameter_set());
  EXPECT_EQ(sentence(foe.write({"parameters.txt", 0}, *set)),
            "slave 0: refused the file with FoE error 0x8002 (access denied): the power stage is on");
  EXPECT_EQ(operation.statistics().wkc_errors, 0U);
  EXPECT_EQ(operation.motion().failure().cause, motion::MotionFailure::Cause::kNone);
}

TEST(FoePassword, AllThirtyTwoBitsOfItCount) {
  FileLine line;
  line.to_pre_op();
  for (const auto wrong : {0U, kPassword ^ 1U, kPassword ^ 0x80000000U, kPassword & 0xFFFFU}) {
    EXPECT_EQ(sentence(line.foe().read({"parameters.txt", wrong})),
              "slave 0: refused the file with FoE error 0x800A (no rights): wrong password");
  }
  EXPECT_EQ(sentence(line.foe().read({"parameters.txt", kPassword})), "");
}

TEST(FoeMailbox, AnSdoWaitsForTheFileAndBothAreRight) {
  FileLine line;
  line.to_pre_op();
  CoeClient coe(line.master.mailboxes(), 0);
  const auto file = line.foe().start_read(parameters());
  const auto product = coe.start_upload({0x1018, 2}, {}, 3);
  const auto other = CoeClient(line.master.mailboxes(), 1).start_upload({0x1018, 4});
  EXPECT_EQ(sentence(other.get()), "");
  EXPECT_FALSE(file->done()) << "another drive is not held up";
  EXPECT_EQ(sentence(product.get()), "");
  EXPECT_EQ(sentence(file->result()), "");
}

/// Counts the cycles of a packet, so that the file can be short.
TEST(FoeSpeed, FourMebibytesTakeLessThanFiveSecondsAt125Microseconds) {
  DriveLine drives(1);
  IdleOperation operation(drives);
  const auto before = operation.master().core()->cycles();
  const auto file = FoeClient(operation.master().mailboxes(), 0).read({"parameters.txt", 0});
  ASSERT_EQ(sentence(file), "");
  const auto cycles = static_cast<double>(operation.master().core()->cycles() - before);
  constexpr std::size_t kData = slaves::msd::kMailboxSize - 12;
  const auto packet_count = file->size() / kData + 1;
  const auto packets = static_cast<double>(packet_count);
  constexpr auto kPacketsOfFourMebibytes = (4U << 20U) / kData + 1;
  constexpr auto kOfFourMebibytes = static_cast<double>(kPacketsOfFourMebibytes);
  EXPECT_GT(packets, 8.0);
  EXPECT_LT(cycles / packets * kOfFourMebibytes * 125e-6, 5.0) << cycles << " cycles for " << packets << " packets";
}

TEST(FoeLostFrames, OneInAHundredCostsNothingButTime) {
  for (const auto way : {LossyPort::Direction::kOut, LossyPort::Direction::kBack}) {
    DriveLine drives(1);
    std::mt19937 random(11);
    LossyPort port(drives.line(), way, [&](auto, auto) { return random() % 100 == 0; });
    ScannedMaster master(port, drives.clock);
    const auto boot = enter_bootstrap(master.mailboxes(), master.slaves()[0].info);
    ASSERT_EQ(sentence(boot), "");
    const auto file = firmware(200'000);
    ASSERT_EQ(sentence(FoeClient(master.mailboxes(), 0).write({"msd.efw", 0}, file)), "");
    ASSERT_EQ(sentence(master.enter_pre_op()), "");
    EXPECT_EQ(drives.drive(0).firmware(), kNewVersion);
    const auto set = FoeClient(master.mailboxes(), 0).read({"parameters.txt", 0});
    ASSERT_EQ(sentence(set), "");
    EXPECT_EQ(text_of(*set), drives.drive(0).parameter_set());
    EXPECT_GT(port.lost(), 10U);
  }
}

/// A store with one file; server and transfer communicate without a line.
class OneFile final : public slaves::FileStore {
 public:
  slaves::FileAnswer<Bytes> read_file(const slaves::FileRequest&) override { return content; }
  slaves::FileAnswer<std::size_t> open_file(const slaves::FileRequest&) override { return std::size_t{1} << 22; }
  slaves::FileAnswer<void> write_file(const slaves::FileRequest&, std::span<const std::byte> bytes) override {
    content.assign(bytes.begin(), bytes.end());
    return {};
  }
  Bytes content;
};

/// Number of messages to the slave until the transfer is over.
std::size_t carry(FileTransfer& transfer, slaves::FoeServer& server, std::size_t room) {
  Bytes answer(room);
  std::size_t mails = 0;
  transfer.begin(0, {room, room});
  for (bool open = true; open;) {
    ++mails;
    const Bytes request(transfer.outgoing().begin(), transfer.outgoing().end());
    EXPECT_LE(request.size(), room);
    const auto length = server.request({request, room, AlState::kPreOp}, answer);
    if (!transfer.awaits_answer()) break;
    if (!length || *length == 0) return 0;
    open = transfer.receive(std::span(answer).first(*length)) == ecat_master::MailboxDialogue::Reaction::kSend;
  }
  return mails;
}

TEST(FoeSizes, AnExactMultipleEndsWithAnEmptyPacket) {
  constexpr std::size_t kData = 100;
  for (const std::size_t packets : {0U, 1U, 2U, 7U}) {
    for (const int more : {-1, 0, 1}) {
      if (packets == 0 && more < 0) continue;
      const Bytes content(packets * kData + static_cast<std::size_t>(more), std::byte{0x5A});
      const auto expected = content.size() / kData + 1;
      OneFile store;
      slaves::FoeServer server(store);
      FileTransfer write({"file"}, content);
      EXPECT_EQ(carry(write, server, kData + 6), 1 + expected) << content.size();
      EXPECT_EQ(store.content, content);
      FileTransfer read({"file"});
      EXPECT_EQ(carry(read, server, kData + 6), 1 + expected) << content.size();
      EXPECT_EQ(read.result().value(), content);
    }
  }
}

TEST(FoeSizes, PacketNumbersHaveThirtyTwoBits) {
  constexpr std::size_t kPackets = 70'000;
  constexpr std::size_t kData = 4;
  OneFile store;
  slaves::FoeServer server(store);
  Bytes content(kPackets * kData);
  std::mt19937 random(3);
  for (auto& byte : content) byte = static_cast<std::byte>(random());
  FileTransfer write({"file"}, content);
  EXPECT_EQ(carry(write, server, kData + 6), kPackets + 2);
  EXPECT_EQ(store.content, content);
  FileTransfer read({"file"});
  EXPECT_EQ(carry(read, server, kData + 6), kPackets + 2);
  EXPECT_EQ(read.result().value(), content);
}

TEST(FoeSizes, AreRightThroughTheMailboxesOfTheDrive) {
  constexpr std::size_t kData = slaves::msd::kMailboxSize - 12;
  const std::size_t header = firmware(0).size();
  for (const std::size_t size : {kData - 1, kData, kData + 1, 20 * kData - 1, 20 * kData, 20 * kData + 1}) {
    FileLine line;
    line.to_boot();
    ASSERT_EQ(sentence(line.foe().write({"msd.efw", kPassword}, firmware(size - header))), "") << size;
    line.to_init();
    EXPECT_EQ(line.drives[0]->firmware(), kNewVersion) << size;
  }
}

}  // namespace
}  // namespace driveline::bus_test

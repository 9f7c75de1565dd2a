// Registers of a slave in OP that another master, or a damaged frame, has written: detected, reported, repaired.
#include <gmock/gmock.h>

#include "drive_line.hpp"
#include "driveline/ecat_master/diagnosis/diagnosis.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::LineSupervisor;
using wire::AlState;

class RegisterGuard : public testing::Test {
 protected:
  void start(std::size_t count, const RunOptions& options = {}) {
    drives = std::make_unique<DriveLine>(count);
    operation = std::make_unique<LineOperation>(*drives, options);
    ASSERT_EQ(sentence(operation->to_op()), "");
    operation->run(milliseconds{2});
    supervise({});
    before = registers();
  }
  void supervise(LineSupervisor::Settings settings) {
    settings.state_timeout = std::chrono::seconds{1};
    supervisor = std::make_unique<LineSupervisor>(operation->master(), nullptr, settings);
  }
  void live(milliseconds duration) {
    const auto end = drives->clock.now() + duration;
    while (drives->clock.now() < end) {
      operation->run(milliseconds{1});
      supervisor->poll();
    }
  }
  /// Writes a register like another sender on the wire.
  template <typename T>
  void overwrite(std::size_t slave, std::uint16_t address, T value) {
    const auto bytes = bytes::to_le_bytes(value);
    const auto ref = operation->master().slaves()[slave].info.ref;
    ASSERT_EQ(sentence(operation->master().bus().write(ref, address, bytes)), "");
    changed = drives->slave(slave).esc().memory().at(address, sizeof(T))[0];
  }
  [[nodiscard]] std::string told() const {
    std::string all;
    for (const auto& event : supervisor->history()) all += what_happened(event) + "\n";
    return all;
  }
  /// FMMUs, sync managers without the parts that slave and mailbox change, watchdogs, DL control, address, protection.
  [[nodiscard]] std::vector<std::byte> registers() const {
    std::vector<std::byte> all;
    for (std::size_t i = 0; i < drives->size(); ++i) {
      const auto& memory = drives->slave(i).esc().memory();
      const auto take = [&](std::size_t address, std::size_t bytes) {
        const auto part = memory.at(address, bytes);
        all.insert(all.end(), part.begin(), part.end());
      };
      take(0x0010, 2);
      take(0x0021, 1);
      take(0x0031, 1);
      take(0x0100, 4);
      take(0x0400, 2);
      take(0x0410, 2);
      take(0x0420, 2);
      take(0x0600, 8 * 16);
      for (std::size_t n = 0; n < 8; ++n) {
        take(0x0800 + 8 * n, 5);
        all.push_back(memory.at(0x0806 + 8 * n, 1)[0] & std::byte{0xC1});
      }
    }
    return all;
  }
  void expect_whole() {
    EXPECT_EQ(registers(), before);
    EXPECT_TRUE(drives->all_in(AlState::kOp));
    EXPECT_TRUE(supervisor->all_operational());
    for (std::size_t i = 0; i < drives->size(); ++i) {
      EXPECT_TRUE(operation->master().core()->slave_report(i).operational) << i;
    }
    EXPECT_EQ(operation->master().core()->bad_cycles(), 0U);
    const auto events = supervisor->events();
    live(milliseconds{50});
    EXPECT_EQ(supervisor->events(), events) << told();
  }

  std::unique_ptr<DriveLine> drives;
  std::unique_ptr<LineOperation> operation;
  std::unique_ptr<LineSupervisor> supervisor;
  std::vector<std::byte> before;
  std::byte changed{};
};

TEST_F(RegisterGuard, ALineThatIsAsItWasConfiguredIsLeftAlone) {
  start(4);
  live(milliseconds{100});
  EXPECT_EQ(told(), "");
  EXPECT_GE(supervisor->guard().rounds, 20U);
  EXPECT_EQ(supervisor->guard().changes, 0U);
  EXPECT_LE(supervisor->guard().last_round, milliseconds{6});
  expect_whole();
}

/// A register, its change, and the reported sentence.
struct Overwritten {
  const char* name;
  std::uint16_t address;
  std::vector<unsigned> bytes;
  const char* sentence;
  bool leaves_op;
};

class OverwrittenRegister : public RegisterGuard, public testing::WithParamInterface<Overwritten> {};

TEST_P(OverwrittenRegister, IsNamedAndPutRight) {
  const auto& param = GetParam();
  start(4);
  live(milliseconds{20});
  ASSERT_EQ(told(), "");
  std::vector<std::byte> bytes;
  for (const auto byte : param.bytes) bytes.push_back(static_cast<std::byte>(byte));
  const auto ref = operation->master().slaves()[2].info.ref;
  ASSERT_EQ(sentence(operation->master().bus().write(ref, param.address, bytes)), "");
  ASSERT_NE(registers(), before);
  operation->run(milliseconds{1});
  // One check of each of the four.
  for (int i = 0; i < 4; ++i) supervisor->poll();
  live(std::chrono::seconds{1});
  std::string expected = "slave 2: " + std::string(param.sentence);
  expected += param.leaves_op ? "; it must be configured again\nslave 2: back in OP\n" : "; written again\n";
  EXPECT_EQ(told(), expected);
  EXPECT_EQ(supervisor->recoveries(), param.leaves_op ? 1U : 0U);
  expect_whole();
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, OverwrittenRegister,
    testing::Values(
        Overwritten{"FmmuLogicalStart",
                    0x0600,
                    {0x00, 0x10, 0x01, 0x00},
                    "FMMU 0 (0x0600): logical start address is 0x00011000, 0x0001002A was configured",
                    true},
        Overwritten{"FmmuLength", 0x0604, {1, 0}, "FMMU 0 (0x0600): length is 0x0001, 0x0013 was configured", true},
        Overwritten{"FmmuOff", 0x060C, {0}, "FMMU 0 (0x0600): activation is 0x00, 0x01 was configured", true},
        Overwritten{"FmmuType", 0x061B, {2}, "FMMU 1 (0x0610): type is 0x02, 0x01 was configured", true},
        Overwritten{"FmmuPhysicalStart",
                    0x0618,
                    {0x34, 0x12},
                    "FMMU 1 (0x0610): physical start address is 0x1234, 0x1A00 was configured",
                    true},
        Overwritten{"FmmuUnused", 0x067C, {1}, "FMMU 7 (0x0670): activation is 0x01, 0x00 was configured", true},
        Overwritten{"SyncManagerUnused",
                    0x0838,
                    {0x00, 0x2F, 4, 0},
                    "sync manager 7 (0x0838): start address is 0x2F00, 0x0000 was configured (and 1 more)",
                    true},
        Overwritten{"WatchdogDivider",
                    0x0400,
                    {0x00, 0x10},
                    "watchdog divider (0x0400) is 0x1000, 0x09C2 was configured",
                    false},
        Overwritten{"WatchdogProcessData",
                    0x0420,
                    {0, 0},
                    "watchdog time process data (0x0420) is 0x0000, 0x03E8 was configured",
                    false},
        Overwritten{
            "WatchdogPdi", 0x0410, {0xFF, 0xFF}, "watchdog time PDI (0x0410) is 0xFFFF, 0x03E8 was configured", false},
        Overwritten{"DlControl", 0x0102, {0x00}, "DL control (0x0100) is 0x00000001, 0x00070001 was configured", false},
        Overwritten{
            "ClosedPort", 0x0101, {0xC0}, "DL control (0x0100) is 0x0007C001, 0x00070001 was configured", false},
        Overwritten{"RegisterWriteProtection",
                    0x0021,
                    {1},
                    "register write protection (0x0021) is 0x01, 0x00 was configured",
                    false},
        Overwritten{
            "EscWriteProtection", 0x0031, {1}, "ESC write protection (0x0031) is 0x01, 0x00 was configured", false},
        Overwritten{"StationAddress",
                    0x0010,
                    {0x34, 0x12},
                    "configured station address (0x0010) is 0x1234, 0x1003 was configured",
                    false}),
    [](const auto& test) { return std::string(test.param.name); });

/// The application checks the activation of its sync managers on its own and leaves OP.
TEST_F(RegisterGuard, ASyncManagerThatIsSwitchedOff) {
  start(3);
  overwrite<std::uint8_t>(1, 0x0806 + 8 * 3, 0);
  operation->run(milliseconds{1});
  live(std::chrono::seconds{1});
  EXPECT_THAT(told(), testing::StartsWith("slave 1: "));
  EXPECT_THAT(told(), testing::EndsWith("slave 1: back in OP\n"));
  expect_whole();
}

TEST_F(RegisterGuard, AnAddressThatIsAnothers) {
  start(4);
  overwrite<std::uint16_t>(1, 0x0010, operation->master().slaves()[3].info.ref.station);
  live(milliseconds{50});
  EXPECT_EQ(told(), "slave 1: configured station address (0x0010) is 0x1004, 0x1002 was configured; written again\n");
  expect_whole();
}

/// The worst case of a damaged broadcast: no slave has an address or accepts a write.
TEST_F(RegisterGuard, AllAddressesLostAndBothLocksClosed) {
  for (const std::size_t budget : {60U, 300U}) {
    RunOptions options;
    options.acyclic_bytes = budget;
    start(3, options);
    // 0x0010 to 0x0031; the enable registers in between open both locks for the frame that closes them.
    std::array<std::byte, 0x22> bytes{};
    bytes[0x11] = bytes[0x21] = std::byte{1};
    ASSERT_TRUE(operation->master().bus().broadcast_write(0x0010, bytes));
    ASSERT_EQ(drives->slave(2).esc().memory().get(wire::reg::kRegisterWriteProtection), 1);
    ASSERT_EQ(drives->slave(2).esc().memory().get(wire::reg::kEscWriteProtection), 1);
    live(std::chrono::seconds{2});
    expect_whole();
  }
}

TEST_F(RegisterGuard, AllAddressesAtOnce) {
  start(4);
  const std::array<std::byte, 2> same{std::byte{0x34}, std::byte{0x12}};
  ASSERT_TRUE(operation->master().bus().broadcast_write(0x0010, same));
  live(milliseconds{50});
  EXPECT_THAT(told(), testing::HasSubstr("configured station address (0x0010) is 0x1234, "));
  expect_whole();
}

/// Registers written before a slave is reconfigured are overwritten.
TEST_F(RegisterGuard, AWatchdogThatIsOffIsOnAgainWithTheSlaveThatFell) {
  start(3);
  overwrite<std::uint16_t>(1, 0x0420, 0);
  overwrite<std::uint8_t>(1, 0x060C, 0);
  operation->run(milliseconds{1});
  live(std::chrono::seconds{1});
  EXPECT_EQ(told(),
            "slave 1: FMMU 0 (0x0600): activation is 0x00, 0x01 was configured (and 1 more); it must be configured "
            "again\nslave 1: back in OP\n");
  expect_whole();
}

/// A slave that fell to SAFEOP with a wrong register is reconfigured.
TEST_F(RegisterGuard, ASlaveInSafeOpWithAWrongFmmuIsConfiguredAnew) {
  start(3);
  const auto ref = operation->master().slaves()[1].info.ref;
  const auto value = wire::AlControl{AlState::kSafeOp, false, false}.raw();
  ASSERT_TRUE(operation->master().bus().write(ref, wire::reg::kAlControl, value));
  overwrite<std::uint16_t>(1, 0x0604, 3);
  live(std::chrono::seconds{1});
  expect_whole();
}

TEST_F(RegisterGuard, TheOthersLoseNoCycle) {
  struct Watch final : motion::CycleTask {
    void update(const motion::TaskCycle& now) noexcept override {
      const auto valid = now.valid;
      for (const std::size_t i : {0U, 1U, 3U}) invalid += valid[i] ? 0 : 1;
    }
    std::uint64_t invalid = 0;
  } watch;
  RunOptions options;
  options.task = &watch;
  start(4, options);
  watch.invalid = 0;
  // A watchdog and an unused sync manager: the process data show neither.
  overwrite<std::uint16_t>(2, 0x0420, 7);
  live(milliseconds{20});
  overwrite<std::uint8_t>(2, 0x083E, 1);
  live(std::chrono::seconds{1});
  EXPECT_EQ(watch.invalid, 0U) << told();
  expect_whole();
}

TEST_F(RegisterGuard, WithoutRecoveryItIsNamedAndTheSlaveLeftAlone) {
  start(2);
  LineSupervisor::Settings settings;
  settings.recover = false;
  supervise(settings);
  overwrite<std::uint8_t>(1, 0x0606, 1);
  live(milliseconds{50});
  EXPECT_EQ(told(),
            "slave 1: FMMU 0 (0x0600): logical start bit is 0x01, 0x00 was configured; it must be configured again\n");
  EXPECT_EQ(drives->state(1), AlState::kOp);
}

/// The supervision needs only the acyclic byte budget of the cycle.
TEST_F(RegisterGuard, ASmallBudgetIsEnough) {
  RunOptions options;
  options.acyclic_bytes = 100;
  start(3, options);
  overwrite<std::uint16_t>(2, 0x0420, 7);
  live(milliseconds{50});
  EXPECT_EQ(told(), "slave 2: watchdog time process data (0x0420) is 0x0007, 0x03E8 was configured; written again\n");
  overwrite<std::uint8_t>(2, 0x0021, 1);
  live(milliseconds{50});
  EXPECT_THAT(told(),
              testing::EndsWith("register write protection (0x0021) is 0x01, 0x00 was configured; written again\n"));
  expect_whole();
}

TEST_F(RegisterGuard, ADamagedAnswerAccusesNobody) {
  start(3);
  for (unsigned seed = 1; seed <= 200; ++seed) {
    drives->line().inject({.kind = slaves::FaultKind::kCorrupt,
                           .direction = slaves::FaultDirection::kBack,
                           .count = 3,
                           .seed = seed,
                           .bits = 4});
    live(milliseconds{4});
  }
  EXPECT_EQ(told(), "");
  EXPECT_EQ(registers(), before);
}

TEST_F(RegisterGuard, IsPartOfTheDiagnosis) {
  start(3);
  overwrite<std::uint16_t>(2, 0x0420, 7);
  live(milliseconds{50});
  const auto diagnosis = diagnose(operation->master(), supervisor.get(), nullptr);
  ASSERT_TRUE(diagnosis);
  EXPECT_THAT(
      to_text(*diagnosis),
      testing::ContainsRegex(
          "registers: read back [0-9]+ times, the last read-back of all slaves took [0-9.]+ ms; 1 had changed\n"));
  EXPECT_THAT(to_text(*diagnosis), testing::HasSubstr("watchdog time process data (0x0420) is 0x0007"));
}

}  // namespace
}  // namespace driveline::bus_test

#include "driveline/ecat_master/error.hpp"

#include <gtest/gtest.h>

#include <set>

namespace driveline::ecat_master {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using wire::AlState;
using wire::AlStatusCode;

static_assert(sizeof(Error) <= 40);
static_assert(std::is_trivially_copyable_v<Error>);

struct Case {
  Error error;
  const char* sentence;
};

const Case kOfTheLine[] = {
    {{facts::NoAnswer{.tries = 5}}, "the line: no answer to a frame after 5 tries"},
    {{facts::NoAnswer{.tries = 5}, 7}, "slave 7: no answer to a frame after 5 tries"},
    {{facts::LinkDown{}}, "the port has no link"},
    {{facts::WorkingCounter{.address = 0x0130, .expected = 1, .received = 0}, 4},
     "slave 4: working counter 0 instead of 1 at address 0x0130"},
    {{facts::NoExchange{.window = nanoseconds{93'750}, .cycles = 100, .late = 98}},
     "no cyclic frame returned within the 93 us of waiting per cycle, in 100 cycles; 98 frames came later"},
    {{facts::Cancelled{}}, "stopped on request"},
    {{facts::ExchangeFull{}}, "the queue to the cycle is full of abandoned frames; the cycle may have stopped"},
    {{facts::NoSlaves{}}, "no slave answers on the line"},
    {{facts::TooManySlaves{.found = 5000, .limit = 4096}}, "5000 slaves answer, the limit is 4096"},
    {{facts::TooManySlaves{.found = 1, .limit = 0}}, "1 slave answers, the limit is 0"},
    {{facts::PortsFitNoTree{.open_ports = 3}, 2},
     "slave 2: its 3 open ports do not match any tree of the slaves that answer"},
    {{facts::IdentityMismatch{.number = IdentityNumber::kVendor, .expected = 0x28, .found = 0x9A}, 5},
     "slave 5: vendor id is 0x0000009A but 0x00000028 is planned"},
    {{facts::IdentityMismatch{.number = IdentityNumber::kProduct, .expected = 1, .found = 2}, 5},
     "slave 5: product code is 0x00000002 but 0x00000001 is planned"},
    {{facts::IdentityMismatch{.number = IdentityNumber::kRevision, .expected = 1, .found = 2}, 5},
     "slave 5: revision is 0x00000002 but 0x00000001 is planned"},
    {{facts::IdentityMismatch{.number = IdentityNumber::kRevision, .at_least = true, .expected = 5, .found = 4}, 5},
     "slave 5: revision is 0x00000004 but >= 0x00000005 is planned"},
    {{facts::IdentityMismatch{.number = IdentityNumber::kSerial, .expected = 1, .found = 2}, 5},
     "slave 5: serial number is 0x00000002 but 0x00000001 is planned"},
    {{facts::IdentityMismatch{.number = IdentityNumber::kAlias, .expected = 1, .found = 2}, 5},
     "slave 5: alias is 0x00000002 but 0x00000001 is planned"},
    {{facts::IdentityMismatch{.number = IdentityNumber::kDeviceId, .expected = 1, .found = 2}, 5},
     "slave 5: device ID is 0x00000002 but 0x00000001 is planned"},
    {{facts::IdentityMismatch{.number = IdentityNumber::kSerial, .at_start = true, .expected = 1, .found = 2}, 5},
     "slave 5: serial number is 0x00000002 but 0x00000001 was there at start"},
    {{facts::SlaveMissing{.plan = 3}}, "planned slave 3 is not on the line"},
    {{facts::SlaveMissing{.plan = 3, .known_by = KnownBy::kAlias, .number = 77, .planned = 3, .found = 3}},
     "planned slave 3 (alias 77) is not on the line"},
    {{facts::SlaveMissing{.plan = 3, .known_by = KnownBy::kDeviceId, .number = 77, .planned = 9, .found = 8}},
     "planned slave 3 (device ID 77) is not on the line; 8 slaves answer, 9 are planned"},
    {{facts::SlaveExtra{.planned = 7, .found = 8}, 7}, "slave 7 is not planned; 8 slaves answer, 7 are planned"},
    {{facts::SlaveExtra{.planned = 1, .found = 2}, 1}, "slave 1 is not planned; 2 slaves answer, 1 is planned"},
    {{facts::SlaveExtra{.planned = 2, .found = 2}, 1}, "slave 1 is not planned"},
    {{facts::SlavesSwapped{.other = 3}, 2}, "slave 2 and slave 3 have changed places"},
    {{facts::InOutSwapped{.port = 1}, 2}, "slave 2: IN and OUT are swapped, frames come in at port 1"},
    {{facts::DuplicateAlias{.other = 4, .known_by = KnownBy::kAlias, .number = 77}, 2},
     "slave 2 and slave 4 both answer to alias 77"},
    {{facts::DuplicateAlias{.other = 4, .known_by = KnownBy::kDeviceId, .number = 0}, 2},
     "slave 2 and slave 4 both answer to device ID 0"},
    {{facts::PlaceUnknown{.missing = 2, .returned = 1}, 5},
     "slave 5: of 2 missing slaves 1 came back, and neither wiring nor serial number identifies them"},
};

const Case kOfSlaves[] = {
    {{facts::SiiBusy{0x40}, 1}, "slave 1: EEPROM interface stays busy at word 0x0040"},
    {{facts::SiiError{.word = 0x40, .status = 0x2000}, 1},
     "slave 1: EEPROM access to word 0x0040 failed, status 0x2000"},
    {{facts::SiiContent{0x7F}, 1}, "slave 1: EEPROM content is not usable at word 0x007F"},
    {{facts::SiiBlank{}, 2}, "slave 2: EEPROM is blank: all bytes are 0xFF"},
    {{facts::SiiVerify{.word = 0x40, .written = 0x1234, .read = 0x5678}, 1},
     "slave 1: EEPROM word 0x0040 reads back as 0x5678 after 0x1234 was written"},
    {{facts::SiiChecksum{.right = 0x1F, .found = 0x20}, 5},
     "slave 5: EEPROM checksum is 0x20, 0x1F is expected: the slave ignores the content"},
    {{facts::StateRefused{
          .requested = AlState::kOp, .actual = AlState::kSafeOp, .code = AlStatusCode::kInvalidDcSyncConfiguration},
      3},
     "slave 3: requested OP, is in SAFEOP + error, AL status code 0x0030 (invalid DC SYNC configuration)"},
    {{facts::StateRefused{.requested = AlState::kSafeOp,
                          .actual = AlState::kPreOp,
                          .code = AlStatusCode::kInvalidOutputConfiguration,
                          .finding = ConfigurationFinding{.number = 2, .expected = 18, .received = 19}},
      3},
     "slave 3: requested SAFEOP, is in PREOP + error, AL status code 0x001D (invalid output configuration); sync "
     "manager 2 is set to 18 bytes, the slave's PDO mapping has 19"},
    {{facts::StateRefused{.requested = AlState::kPreOp, .actual = AlState::kInit}, 3},
     "slave 3: requested PREOP, is in INIT + error, AL status code 0x0000 (the slave gives no reason)"},
    {{facts::StateRefused{
          .requested = AlState::kPreOp, .actual = static_cast<AlState>(5), .code = static_cast<AlStatusCode>(0x8765)},
      3},
     "slave 3: requested PREOP, is in ? + error, AL status code 0x8765 (vendor specific)"},
    {{facts::StateTimeout{.requested = AlState::kOp,
                          .actual = AlState::kSafeOp,
                          .code = AlStatusCode::kSyncManagerWatchdog,
                          .timeout = std::chrono::seconds{10}},
      3},
     "slave 3: requested OP, is in SAFEOP and did not change within 10000 ms, AL status code 0x001B (sync "
     "manager watchdog)"},
    {{facts::NoMailbox{}, 2}, "slave 2: has no mailbox"},
    {{facts::NoMailbox{wire::MailboxType::kCoe}, 2}, "slave 2: has no CoE mailbox"},
    {{facts::NoMailbox{wire::MailboxType::kSoe}, 2}, "slave 2: has no SoE mailbox"},
    {{facts::NoBootMailbox{}, 3}, "slave 3: has no mailbox for BOOT: its EEPROM defines none for the bootstrap state"},
    {{facts::MailboxTimeout{.object = {0x6041, 0}, .timeout = std::chrono::seconds{2}}, 2},
     "slave 2: no mailbox reply for object 6041h:00 within 2000 ms"},
    {{facts::MailboxError{.object = {0x1018, 4}, .code = 2}, 2},
     "slave 2: answered object 1018h:04 with mailbox error 0x0002 (unsupported protocol)"},
    {{facts::MailboxError{.code = 0xCAFE}, 2}, "slave 2: answered with mailbox error 0xCAFE (unknown mailbox error)"},
    {{facts::MailboxTimeout{.timeout = std::chrono::seconds{2}}, 2}, "slave 2: no mailbox reply within 2000 ms"},
    {{facts::MailboxTimeout{.object = {0x60C2, 2}, .timeout = std::chrono::seconds{2}, .dropped = 1}, 2},
     "slave 2: no mailbox reply for object 60C2h:02 within 2000 ms; 1 reply was dropped, with the counter and content "
     "of "
     "the previous message"},
    {{facts::MailboxTimeout{.timeout = std::chrono::milliseconds{250}, .dropped = 3}, 2},
     "slave 2: no mailbox reply within 250 ms; 3 replies were dropped, with the counter and content of the previous "
     "message"},
    {{facts::MailboxMalformed{}, 2}, "slave 2: sent a malformed mailbox"},
    {{facts::MailboxMalformed{{0x1018, 4}}, 2}, "slave 2: sent a malformed mailbox for object 1018h:04"},
    {{facts::SdoAbort{.object = {0x1600, 1}, .code = wire::SdoAbort::kNotMappable}, 0},
     "slave 0: object 1600h:01 aborted with 0x06040041 (object cannot be mapped to a PDO)"},
    {{facts::SdoAbort{.object = {0x2001, 0xFF}, .code = static_cast<wire::SdoAbort>(0x12345678)}, 0},
     "slave 0: object 2001h:FF aborted with 0x12345678 (unknown abort code)"},
    {{facts::SdoSize{.object = {0x1000, 0}, .expected = 2, .received = 4}, 0},
     "slave 0: object 1000h:00 has 4 bytes, 2 were expected"},
    {{facts::FileRefused{wire::FoeError::kNotFound}, 0}, "slave 0: refused the file with FoE error 0x8001 (not found)"},
    {{facts::FileRefused{static_cast<wire::FoeError>(0xDEAD)}, 0},
     "slave 0: refused the file with FoE error 0xDEAD (unknown FoE error)"},
    {{facts::FilePacket{.expected = 70000, .received = 4464}, 1},
     "slave 1: packet 70000 of the file was expected, 4464 came"},
    {{facts::FileSize{1000}, 1}, "slave 1: sends more than the 1000 bytes of the file that are accepted"},
    {{facts::FileBusy{std::chrono::seconds{120}}, 1}, "slave 1: was busy with the file for 120000 ms without progress"},
    {{facts::NoEoe{}, 1}, "slave 1: does not support EoE according to its description"},
    {{facts::EoeRefused{wire::EoeType::kSetIpRequest, wire::EoeResult::kNoDhcpSupport}, 1},
     "slave 1: refused the IP parameters with EoE result 0x0202 (no DHCP support)"},
    {{facts::SoeRefused{{1, {0x8003}}, wire::SoeError::kNoIdn}, 3},
     "slave 3: refused P-0-0003 of drive 1 with SoE error 0x1001 (there is no such IDN)"},
    {{facts::SoeOther{{0, {17}}, {1, {18}}}, 3},
     "slave 3: request for S-0-0017 of drive 0 was answered with S-0-0018 of drive 1"},
    {{facts::SoeFragments{{0, {17}}, 2, 3}, 3},
     "slave 3: 2 further fragments of S-0-0017 of drive 0 were expected, 3 are announced"},
    {{facts::SoeContent{{0, {17}}, 5}, 3}, "slave 3: the 5 bytes of S-0-0017 of drive 0 do not match its attribute"},
    {{facts::SoeForm{{1, {0x8003}}, true, 4, wire::SoeDisplay::kSigned}, 3},
     "slave 3: the value for P-0-0003 of drive 1 does not fit: a list of elements of 4 bytes, signed, is expected"},
    {{facts::SoeForm{{1, {17}}, false, 1, wire::SoeDisplay::kHexadecimal}, 3},
     "slave 3: the value for S-0-0017 of drive 1 does not fit: one number of 1 byte, hexadecimal, is expected"},
    {{facts::SoeListLength{{1, {16}}, 24, 20}, 3},
     "slave 3: the list for S-0-0016 of drive 1 has 24 bytes, the drive has room for 20"},
    {{facts::SoeLimit{{1, {104}}, true, 700.0, 650.0}, 3},
     "slave 3: refused 700 for S-0-0104 of drive 1, above its upper limit 650"},
    {{facts::SoeLimit{{1, {104}}, false, -7.0, 2.0}, 3},
     "slave 3: refused -7 for S-0-0104 of drive 1, below its lower limit 2"},
    {{facts::SoeNotKept{{1, {104}}, 0, 700.0, 650.0}, 3},
     "slave 3: S-0-0104 of drive 1 reads back as 650 after 700 was written"},
    {{facts::SoeNotKept{{1, {16}}, 3, 51.0, 40.0}, 3},
     "slave 3: element 3 of S-0-0016 of drive 1 reads back as 40 after 51 was written"},
    {{facts::SoeCommandEnded{{0, {99}}, wire::SoeCommandState::kFailed}, 3},
     "slave 3: the procedure command S-0-0099 of drive 0 ended in data state 0x000F (failed)"},
    {{facts::SoeCommandTimeout{{0, {99}}, std::chrono::seconds{10}}, 3},
     "slave 3: the procedure command S-0-0099 of drive 0 did not end within 10000 ms"},
    {{facts::ProcessDataSize{.bytes = 1453, .limit = 1452}, 6},
     "slave 6: 1453 bytes of process data do not fit, the limit is 1452"},
    {{facts::TooFewFmmus{.needed = 4, .present = 3}, 6}, "slave 6: its process data need 4 FMMUs, it has 3"},
};

const Case kOfClocks[] = {
    {{facts::NoClocks{}, 4}, "no slave of the line has a distributed clock, but synchronisation to one is requested"},
    {{facts::NoClock{}, 4}, "slave 4: has no distributed clock, but SYNC signals are planned for it"},
    {{facts::ReferenceWithoutClock{}, 4}, "slave 4: is chosen as reference clock but has no distributed clock"},
    {{facts::BeforeReference{3}, 0},
     "slave 0: frames reach it before the reference clock, slave 3, so it cannot follow that clock"},
    {{facts::NoClockMode{}, 2},
     "slave 2: its description does not know the planned operation mode of the distributed clock"},
    {{facts::NotInPreOp{AlState::kOp}, 2}, "slave 2: SYNC signals are set up in PREOP, it is in OP"},
    {{facts::ContradictingDelays{1}, 2},
     "slave 2: less time passed at port 1 than after it; the receive times contradict each other"},
    {{facts::NoReceiveTimes{}, 2}, "the receive times of one frame could not be read from all slaves"},
    {{facts::StartTimePast{milliseconds{800}}},
     "the start time of SYNC0 had passed before it was written to all slaves, 800000 us were not enough"},
    {{facts::SyncRegister{.address = 0x0981, .written = 3, .read = 0}, 2},
     "slave 2: register 0x0981 is 0x0 after 0x3 was written"},
    {{facts::SyncObject{.object = {0x1C32, 1}, .written = 2, .read = 1}, 2},
     "slave 2: object 1C32h:01 is 1 after 2 was written"},
    {{facts::SyncCycleRange{.cycle = nanoseconds{0}, .limit = nanoseconds{0xFFFF'FFFF}}, 2},
     "slave 2: a SYNC0 cycle of 0 ns is outside 1 .. 4294967295 ns"},
    {{facts::SyncCycleBase{.cycle = microseconds{130}, .base = microseconds{125}}, 2},
     "slave 2: the SYNC0 cycle of 130000 ns is not a multiple of 125000 ns"},
    {{facts::SyncCycleAndPeriod{.cycle = microseconds{200}, .period = microseconds{125}}, 2},
     "slave 2: SYNC0 cycle of 200000 ns and cycle time of 125000 ns are not multiples of each other"},
    {{facts::SyncShift{.shift = -microseconds{125}, .cycle = microseconds{125}}, 2},
     "slave 2: the SYNC0 shift of -125000 ns is not shorter than the SYNC0 cycle of 125000 ns"},
    {{facts::Sync1WithoutSync0{0x0500}, 2},
     "slave 2: SYNC1 is activated without SYNC0, which starts it (assign/activate 0x0500)"},
    {{facts::Sync1Cycle{.cycle = microseconds{200}, .sync0_cycle = microseconds{125}}, 2},
     "slave 2: the SYNC1 cycle of 200000 ns is not a multiple of the SYNC0 cycle of 125000 ns"},
    {{facts::Sync1Shift{.shift = -nanoseconds{1}, .sync0_cycle = microseconds{125}}, 2},
     "slave 2: the SYNC1 shift of -1 ns is not between 0 and the SYNC0 cycle of 125000 ns"},
    {{facts::NoCommonCycle{microseconds{137}}, 2},
     "slave 2: its cycle of 137000 ns and those of the others have a common period of more than 4 s"},
    {{facts::FrameLead{.lead = -nanoseconds{1}, .period = microseconds{125}}},
     "frames cannot be -1 ns ahead of SYNC0 in a cycle of 125000 ns"},
    {{facts::NotLocked{
         .cause = dc::LockCause::kPhaseError, .mean_error = -nanoseconds{4321}, .window = nanoseconds{1250}}},
     "the cycle is not locked to the reference clock: its frames are -4321 ns off their phase on average and do not "
     "stay within 1250 ns of it"},
    {{facts::NotLocked{
         .cause = dc::LockCause::kAcquiring, .mean_error = -nanoseconds{4321}, .window = nanoseconds{1250}}},
     "the cycle is not locked to the reference clock: its frames are -4321 ns off their phase on average and do not "
     "stay within 1250 ns of it"},
    {{facts::NotLocked{.cause = dc::LockCause::kAcquiring,
                       .noise_ns = 23'456,
                       .mean_error = nanoseconds{900},
                       .window = nanoseconds{1250}}},
     "the cycle is not locked to the reference clock: its frames are 900 ns off their phase on average and do not "
     "stay within 1250 ns of it; individual frames vary by 23456 ns"},
    {{facts::NotLocked{.cause = dc::LockCause::kNoReference}},
     "the cycle is not locked to the reference clock: the reference clock does not answer"},
    {{facts::NotLocked{.cause = dc::LockCause::kFrequencyLimit}},
     "the cycle is not locked to the reference clock: it runs more than 500 ppm off the master's clock and cannot be "
     "disciplined"},
    {{facts::NotSynchronised{.difference = -nanoseconds{120}, .window = nanoseconds{100}}, 2},
     "slave 2: its clock is -120 ns off the reference clock, the limit is 100 ns"},
};

TEST(ErrorSentence, HoldsEveryFactOfEveryKind) {
  std::set<std::size_t> kinds;
  for (const std::span<const Case> cases :
       {std::span<const Case>(kOfTheLine), std::span<const Case>(kOfSlaves), std::span<const Case>(kOfClocks)}) {
    for (const auto& test : cases) {
      EXPECT_EQ(describe(test.error), test.sentence);
      kinds.insert(test.error.facts.index());
    }
  }
  EXPECT_EQ(kinds.size(), std::variant_size_v<ErrorFacts>);
}

TEST(Error, IsOfOneKindAndHasItsFacts) {
  const Error error{facts::WorkingCounter{.address = 0x0130, .received = 2}, 4};
  EXPECT_TRUE(error.is<facts::WorkingCounter>());
  EXPECT_FALSE(error.is<facts::NoAnswer>());
  ASSERT_NE(error.as<facts::WorkingCounter>(), nullptr);
  EXPECT_EQ(error.as<facts::WorkingCounter>()->received, 2);
  EXPECT_EQ(error.as<facts::NoAnswer>(), nullptr);
  EXPECT_EQ(error.slave, 4);
}

}  // namespace
}  // namespace driveline::ecat_master

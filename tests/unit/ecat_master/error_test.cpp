#include "driveline/ecat_master/error.hpp"

#include <gtest/gtest.h>

namespace driveline::ecat_master {
namespace {

static_assert(sizeof(Error) <= 24);
static_assert(std::is_trivially_copyable_v<Error>);

struct Case {
  Error error;
  const char* sentence;
};

Error make(ErrorKind kind, std::uint16_t slave, std::uint16_t address = 0, std::uint8_t subindex = 0,
           std::uint32_t expected = 0, std::uint32_t received = 0, std::uint32_t code = 0, std::uint32_t extra = 0) {
  Error error;
  error.kind = kind;
  error.slave = slave;
  error.address = address;
  error.subindex = subindex;
  error.expected = expected;
  error.received = received;
  error.code = code;
  error.extra = extra;
  return error;
}

Error state(ErrorKind kind, wire::AlState requested, wire::AlState actual, std::uint32_t code) {
  Error error = make(kind, 3, 0, 0, 0, 0, code);
  error.requested = requested;
  error.actual = actual;
  return error;
}

TEST(ErrorSentence, HoldsEveryFactOfEveryKind) {
  using K = ErrorKind;
  using wire::AlState;
  constexpr auto kLine = Error::kNoSlave;
  Error sizes = state(K::kStateRefused, AlState::kSafeOp, AlState::kPreOp, 0x001D);
  sizes.extra = 2;
  sizes.expected = 18;
  sizes.received = 19;
  Error late = state(K::kStateTimeout, AlState::kOp, AlState::kSafeOp, 0x001B);
  late.extra = 10'000'000;
  const Case cases[] = {
      {make(K::kNoAnswer, kLine, 0, 0, 5), "the line: no answer to a frame after 5 tries"},
      {make(K::kNoAnswer, 7, 0x130, 0, 5), "slave 7: no answer to a frame after 5 tries"},
      {make(K::kLinkDown, kLine), "the port has no link"},
      {make(K::kWorkingCounter, 4, 0x0130, 0, 1, 0), "slave 4: working counter 0 instead of 1 at address 0x0130"},
      {make(K::kNoSlaves, kLine), "no slave answers on the line"},
      {make(K::kTooManySlaves, kLine, 0, 0, 4096, 5000), "5000 slaves answer, the limit is 4096"},
      {make(K::kTooManySlaves, kLine, 0, 0, 0, 1), "1 slave answers, the limit is 0"},
      {make(K::kTopology, 2, 0x0110, 0, 3), "slave 2: its 3 open ports fit no tree of the slaves that answer"},
      {make(K::kSiiBusy, 1, 0x40), "slave 1: EEPROM interface stays busy at word 0x0040"},
      {make(K::kSiiError, 1, 0x40, 0, 0, 0, 0x2000), "slave 1: EEPROM access to word 0x0040 failed, status 0x2000"},
      {make(K::kSiiContent, 1, 0x7F), "slave 1: EEPROM content is not usable at word 0x007F"},
      {make(K::kSiiVerify, 1, 0x40, 0, 0x1234, 0x5678),
       "slave 1: EEPROM word 0x0040 reads back as 0x5678 after 0x1234 was written"},
      {state(K::kStateRefused, AlState::kOp, AlState::kSafeOp, 0x0030),
       "slave 3: asked for OP, is in SAFEOP + error, AL status code 0x0030 (invalid DC SYNC configuration)"},
      {sizes,
       "slave 3: asked for SAFEOP, is in PREOP + error, AL status code 0x001D (invalid output configuration); sync "
       "manager 2 is set to 18 bytes, the slave's PDO mapping has 19"},
      {late,
       "slave 3: asked for OP, is in SAFEOP and did not change within 10000 ms, AL status code 0x001B (sync "
       "manager watchdog)"},
      {state(K::kStateRefused, AlState::kPreOp, static_cast<AlState>(5), 0x8765),
       "slave 3: asked for PREOP, is in ? + error, AL status code 0x8765 (vendor specific)"},
      {make(K::kNoMailbox, 2), "slave 2: has no CoE mailbox"},
      {state(K::kNoMailbox, AlState::kBootstrap, AlState::kNone, 0),
       "slave 3: has no mailbox for BOOT: its EEPROM names none for the bootstrap state"},
      {make(K::kSiiContent, 2, 0, 0, 0, 0, kSiiBlank), "slave 2: EEPROM is blank, it holds nothing but 0xFF"},
      {make(K::kMailboxTimeout, 2, 0x6041, 0, 0, 0, 0, 2'000'000),
       "slave 2: no mailbox reply for object 6041h:00 within 2000 ms"},
      {make(K::kMailboxError, 2, 0x1018, 4, 0, 0, 2), "slave 2: answered object 1018h:04 with mailbox error 0x0002"},
      {make(K::kMailboxMalformed, 2, 0x1018, 4), "slave 2: sent a malformed mailbox for object 1018h:04"},
      {make(K::kSdoAbort, 0, 0x1600, 1, 0, 0, 0x06040041),
       "slave 0: object 1600h:01 aborted with 0x06040041 (object cannot be mapped to a PDO)"},
      {make(K::kSdoAbort, 0, 0x2001, 0xFF, 0, 0, 0x12345678),
       "slave 0: object 2001h:FF aborted with 0x12345678 (unknown abort code)"},
      {make(K::kSdoSize, 0, 0x1000, 0, 2, 4), "slave 0: object 1000h:00 has 4 bytes, 2 were expected"},
      {make(K::kIdentityMismatch, 5, 0, 0, 0x28, 0x9A), "slave 5: vendor id is 0x0000009A but 0x00000028 is planned"},
      {make(K::kIdentityMismatch, 5, 1, 0, 1, 2), "slave 5: product code is 0x00000002 but 0x00000001 is planned"},
      {make(K::kIdentityMismatch, 5, 2, 0, 1, 2), "slave 5: revision is 0x00000002 but 0x00000001 is planned"},
      {make(K::kIdentityMismatch, 5, 2, 1, 5, 4), "slave 5: revision is 0x00000004 but >= 0x00000005 is planned"},
      {make(K::kIdentityMismatch, 5, 3, 0, 1, 2), "slave 5: serial number is 0x00000002 but 0x00000001 is planned"},
      {make(K::kIdentityMismatch, 5, 4, 0, 1, 2), "slave 5: alias is 0x00000002 but 0x00000001 is planned"},
      {make(K::kIdentityMismatch, 5, 5, 0, 1, 2), "slave 5: device ID is 0x00000002 but 0x00000001 is planned"},
      {make(K::kIdentityMismatch, 5, 3, 0, 1, 2, 1),
       "slave 5: serial number is 0x00000002 but 0x00000001 was there at start"},
      {make(K::kPlaceUnknown, 5, 0, 0, 2, 1),
       "slave 5: of 2 that were missing 1 came back, and neither wiring nor serial number tells which"},
      {make(K::kSiiChecksum, 5, 0, 0, 0x1F, 0x20),
       "slave 5: EEPROM checksum is 0x20, 0x1F would be right: the slave does not use its content"},
      {make(K::kSlaveMissing, kLine, 0, 0, 0, 0, 0, 3), "planned slave 3 is not on the line"},
      {make(K::kSlaveMissing, kLine, 77, 1, 3, 3, 0, 3), "planned slave 3 (alias 77) is not on the line"},
      {make(K::kSlaveMissing, kLine, 77, 2, 9, 8, 0, 3),
       "planned slave 3 (device ID 77) is not on the line; 8 slaves answer, 9 are planned"},
      {make(K::kSlavesSwapped, 2, 0, 0, 0, 0, 0, 3), "slave 2 and slave 3 have changed places"},
      {make(K::kWiring, 2, 0, 0, 0, 0, 0, 1), "slave 2: IN and OUT are swapped, frames come in at port 1"},
      {make(K::kDuplicateAlias, 2, 77, 1, 0, 0, 0, 4), "slave 2 and slave 4 both answer to alias 77"},
      {make(K::kDuplicateAlias, 2, 0, 2, 0, 0, 0, 4), "slave 2 and slave 4 both answer to device ID 0"},
      {make(K::kSlaveExtra, 7, 0, 0, 7, 8), "slave 7 is not planned; 8 slaves answer, 7 are planned"},
      {make(K::kSlaveExtra, 1, 0, 0, 1, 2), "slave 1 is not planned; 2 slaves answer, 1 is planned"},
      {make(K::kSlaveExtra, 1, 0, 0, 2, 2), "slave 1 is not planned"},
      {make(K::kProcessDataSize, 6, 0, 0, 1452, 1453),
       "slave 6: 1453 bytes of process data do not fit, the limit is 1452"},
      {make(K::kNoExchange, kLine, 0, 0, 93'750, 100, 0, 98),
       "no cyclic frame came back within the 93 us that its cycle waits, in 100 cycles; 98 came later"},
      {make(K::kAxisNotEnabled, 1, 0, 0, 0, 0x0250, 0, 2'000'000),
       "axis 1: not in Operation enabled within 2000 ms, status word 0x0250"},
      {make(K::kAxisFault, 1, 0, 0, 0, 0x0218, 0x8611), "axis 1: fault 0x8611, following error, status word 0x0218"},
      {make(K::kCommunicationLost, kLine, 0, 0, 0, 8),
       "communication lost: 8 cycles in a row without valid process data"},
      {make(K::kClock, 4), "no slave of the line has a distributed clock, but synchronisation to one is asked for"},
      {make(K::kCancelled, kLine), "stopped on request"},
  };
  std::vector<bool> covered(static_cast<std::size_t>(K::kCancelled) + 1);
  for (const auto& test : cases) {
    EXPECT_EQ(describe(test.error), test.sentence);
    covered[static_cast<std::size_t>(test.error.kind)] = true;
  }
  for (std::size_t kind = 0; kind < covered.size(); ++kind) EXPECT_TRUE(covered[kind]) << "kind " << kind;
}

}  // namespace
}  // namespace driveline::ecat_master

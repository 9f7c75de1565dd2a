#include "driveline/ecat_master/sii/sii_writer.hpp"

#include <gmock/gmock.h>

#include <set>

#include "driveline/esi/sii.hpp"
#include "support/must.hpp"

namespace driveline::ecat_master {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr SlaveRef kSlave{2, 0x1003};

/// An EEPROM and its interface 0x0500-0x050F, with all possible failures. Written from the register description
/// (ETG.1000.4 6.4), not from the emulated controller.
class Eeprom final : public DatagramExchange {
 public:
  explicit Eeprom(std::size_t size) : words(size) {
    for (std::size_t i = 0; i < size; ++i) words[i] = static_cast<std::uint16_t>(0x1000 + i);
    words[4] = 0;
    words[7] = checksum();
  }

  std::vector<std::uint16_t> words;
  std::vector<std::size_t> writes;    ///< word addresses, in their order
  std::set<std::size_t> dead_words;   ///< never acknowledged when written
  std::set<std::size_t> stuck_words;  ///< keep their value without an error on the interface
  int unacknowledged = 0;             ///< number of commands that are not acknowledged
  int busy_polls = 0;                 ///< status reads that find the interface busy after a command
  bool busy_for_ever = false;
  int away_rounds = 0;                         ///< rounds in which the machine suspends the master for a second
  int refused_commands = 0;                    ///< commands that are not accepted although the status was idle
  std::size_t silent_after_writes = SIZE_MAX;  ///< after these the slave does not answer any more
  bool application_owns = true;

  [[nodiscard]] std::uint16_t checksum() const {
    std::array<std::byte, esi::SiiConfigArea::kSize> area{};
    for (std::size_t i = 0; i < 7; ++i) bytes::store_le(std::span(area).subspan(2 * i, 2), words[i]);
    return esi::sii_checksum(area);
  }
  [[nodiscard]] bool checksum_valid() const { return (words[7] & 0xFF) == checksum(); }
  [[nodiscard]] std::vector<std::byte> bytes() const {
    std::vector<std::byte> image(2 * words.size());
    for (std::size_t i = 0; i < words.size(); ++i) bytes::store_le(std::span(image).subspan(2 * i, 2), words[i]);
    return image;
  }

  Result<void> exchange(std::span<Request> requests) override {
    now_ += std::chrono::microseconds{100};
    if (away_rounds-- > 0) now_ += std::chrono::seconds{1};
    for (auto& request : requests) {
      request.answered = true;
      request.working_counter = 0;
      if (writes.size() > silent_after_writes || request.address.adp() != kSlave.station) continue;
      const bool command = request.command == wire::Command::kFpwr && request.address.ado() == 0x0502;
      if (command && refused_commands > 0) {
        --refused_commands;
        continue;
      }
      request.working_counter = 1;
      if (request.command == wire::Command::kFpwr) write(request.address.ado(), request.data);
      if (request.command == wire::Command::kFprd) read(request.address.ado(), request.data);
    }
    return {};
  }
  void pause(std::chrono::nanoseconds duration) override { now_ += duration; }
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept override { return now_; }

 private:
  void write(std::uint16_t address, std::span<const std::byte> data) {
    if (address == 0x0500) {
      if (data[0] == std::byte{1}) application_owns = true;
      if (data[0] == std::byte{2}) application_owns = false;
      return;
    }
    ASSERT_EQ(address, 0x0502);
    ASSERT_FALSE(application_owns) << "command without the EEPROM interface";
    ASSERT_EQ(polls_left_, 0) << "command while busy";
    const auto control = bytes::load_le<std::uint16_t>(data);
    address_ = bytes::load_le<std::uint32_t>(data.subspan(2));
    status_ = 0x0040;
    polls_left_ = busy_polls;
    if (unacknowledged > 0) {
      --unacknowledged;
      status_ |= 0x2000;
    } else if ((control & 0x0700) == 0x0200) {
      ASSERT_EQ(control & 1, 1) << "write without write enable";
      writes.push_back(address_);
      const auto at = address_ % words.size();  // a small EEPROM wraps round
      if (dead_words.count(address_) != 0) {
        status_ |= 0x2000;
      } else if (stuck_words.count(address_) == 0) {
        words[at] = bytes::load_le<std::uint16_t>(data.subspan(6));
      }
    }
  }

  void read(std::uint16_t address, std::span<std::byte> data) {
    if (address == 0x0500) {
      data[0] = application_owns ? std::byte{1} : std::byte{0};
      return;
    }
    ASSERT_EQ(address, 0x0502);
    const bool busy = busy_for_ever || polls_left_ > 0;
    if (polls_left_ > 0) --polls_left_;
    bytes::store_le<std::uint16_t>(data, static_cast<std::uint16_t>(status_ | (busy ? 0x8000 : 0)));
    for (std::size_t i = 0; i < 4; ++i) {
      bytes::store_le<std::uint16_t>(data.subspan(6 + 2 * i), words[(address_ + i) % words.size()]);
    }
  }

  std::size_t address_ = 0;
  std::uint16_t status_ = 0x0040;
  int polls_left_ = 0;
  std::chrono::nanoseconds now_{0};
};

/// The content with other words, checksum included.
std::vector<std::byte> changed(const Eeprom& eeprom, std::initializer_list<std::size_t> at) {
  Eeprom copy = eeprom;
  for (const auto word : at) copy.words[word] ^= 0x5A5A;
  copy.words[7] = copy.checksum();
  return copy.bytes();
}

auto write(Eeprom& eeprom, const std::vector<std::byte>& image, const SiiProgress& progress = {}) {
  Bus bus(eeprom);
  return write_sii(bus, kSlave, image, progress);
}

auto set_alias(Eeprom& eeprom, std::uint16_t alias) {
  Bus bus(eeprom);
  return write_alias(bus, kSlave, alias);
}

TEST(SiiWriter, WritesOnlyWhatDiffersAndKeepsTheRest) {
  Eeprom eeprom(64);
  const auto before = eeprom.bytes();
  const auto image = changed(eeprom, {20, 41});
  const auto report = must(write(eeprom, image));
  EXPECT_EQ(eeprom.bytes(), image);
  EXPECT_EQ(report->words_changed, 2U);
  EXPECT_EQ(report->words_unchanged, 62U);
  EXPECT_EQ(report->previous, before);
}

TEST(SiiWriter, ReturnsTheInterfaceToTheApplicationThatHadIt) {
  for (const bool owned : {true, false}) {
    Eeprom eeprom(64);
    eeprom.application_owns = owned;
    Bus bus(eeprom);
    ASSERT_TRUE(write_sii(bus, kSlave, changed(eeprom, {20})));
    EXPECT_EQ(eeprom.application_owns, owned);
    ASSERT_TRUE(read_sii_words(bus, kSlave, 3, 5));
    EXPECT_EQ(eeprom.application_owns, owned);
    eeprom.dead_words = {30};
    ASSERT_FALSE(write_sii(bus, kSlave, changed(eeprom, {30})));
    EXPECT_EQ(eeprom.application_owns, owned) << "also after a failure";
  }
}

TEST(SiiWriter, ChecksumIsInvalidFromTheFirstWordToTheLast) {
  Eeprom eeprom(64);
  const auto image = changed(eeprom, {0, 3, 20, 41});
  std::vector<bool> valid;
  const auto report = write(eeprom, image, [&](std::size_t done, std::size_t total) {
    if (done < total) valid.push_back(eeprom.checksum_valid());
    return true;
  });
  ASSERT_TRUE(report);
  EXPECT_THAT(eeprom.writes, ElementsAre(7, 20, 41, 0, 3, 7));
  EXPECT_THAT(valid, Each(false));
  EXPECT_EQ(valid.size(), 5U);
  EXPECT_TRUE(eeprom.checksum_valid());
}

TEST(SiiWriter, SameContentIsNotWritten) {
  Eeprom eeprom(64);
  const auto report = must(write(eeprom, eeprom.bytes()));
  EXPECT_THAT(eeprom.writes, IsEmpty());
  EXPECT_EQ(report->words_changed, 0U);
}

TEST(SiiWriter, BusyAndUnacknowledgedWordsAreWaitedForAndTriedAgain) {
  Eeprom eeprom(64);
  eeprom.busy_polls = 5;
  eeprom.unacknowledged = 4;
  const auto image = changed(eeprom, {20, 21, 22});
  ASSERT_EQ(failure_text(write(eeprom, image)), "");
  EXPECT_EQ(eeprom.bytes(), image);
}

TEST(SiiWriterFailure, WordThatCannotBeWrittenUndoesTheOthers) {
  Eeprom eeprom(64);
  const auto before = eeprom.bytes();
  const auto image = changed(eeprom, {20, 30, 40});
  eeprom.dead_words = {30};
  const auto report = write(eeprom, image);
  ASSERT_FALSE(report);
  EXPECT_TRUE(report.error().error.is<facts::SiiError>());
  EXPECT_EQ(std::get<facts::SiiError>(report.error().error.facts).word, 30);
  EXPECT_EQ(eeprom.bytes(), before);
  EXPECT_THAT(report.error().left, IsEmpty());
  EXPECT_TRUE(eeprom.checksum_valid());
  const auto sentence = describe(report.error());
  EXPECT_THAT(sentence, HasSubstr("slave 2"));
  EXPECT_THAT(sentence, HasSubstr("0x001E"));
}

TEST(SiiWriterFailure, WordThatReadsBackWrongIsFoundAndUndone) {
  Eeprom eeprom(64);
  const auto before = eeprom.bytes();
  const auto image = changed(eeprom, {20, 30, 40});
  eeprom.stuck_words = {40};
  const auto report = write(eeprom, image);
  ASSERT_FALSE(report);
  EXPECT_TRUE(report.error().error.is<facts::SiiVerify>());
  EXPECT_EQ(std::get<facts::SiiVerify>(report.error().error.facts).word, 40);
  EXPECT_THAT(report.error().left, IsEmpty());
  EXPECT_EQ(eeprom.bytes(), before);
  EXPECT_EQ(describe(report.error()),
            "slave 2: EEPROM word 0x0028 reads back as 0x1028 after 0x4A72 was written; the words written were "
            "restored, the EEPROM has its previous content");
}

TEST(SiiWriterFailure, SlaveThatFallsSilentLeavesAnInvalidChecksumAndAListOfWords) {
  Eeprom eeprom(64);
  const auto before = eeprom.bytes();
  const auto image = changed(eeprom, {20, 30, 31, 32, 40});
  eeprom.silent_after_writes = 4;  // 7, 20, 30, 31
  const auto report = write(eeprom, image);
  ASSERT_FALSE(report);
  EXPECT_TRUE(report.error().error.is<facts::WorkingCounter>());
  EXPECT_FALSE(eeprom.checksum_valid());
  EXPECT_EQ(report.error().previous, before);
  EXPECT_THAT(report.error().left, ElementsAre(7, 20, 30, 31, 32));
  EXPECT_THAT(describe(report.error()), HasSubstr("5 words could not be restored"));
  EXPECT_THAT(describe(report.error()), HasSubstr("0x0007, 0x0014, 0x001E-0x0020"));
}

TEST(SiiWriterFailure, ImageLargerThanTheEepromIsFoundByReadingItAllBack) {
  Eeprom small(32);
  const auto before = small.bytes();
  // The same content twice would pass; this one differs in the second half.
  auto image = before;
  image.insert(image.end(), before.begin(), before.end());
  image[2 * (32 + 12)] ^= std::byte{0xFF};
  const auto report = write(small, image);
  ASSERT_FALSE(report);
  EXPECT_TRUE(report.error().error.is<facts::SiiVerify>());
  EXPECT_EQ(small.bytes(), before);
}

TEST(SiiWriterFailure, StopHalfWayUndoesWhatWasWritten) {
  Eeprom eeprom(64);
  const auto before = eeprom.bytes();
  const auto report =
      write(eeprom, changed(eeprom, {20, 30, 40}), [](std::size_t done, std::size_t) { return done < 3; });
  ASSERT_FALSE(report);
  EXPECT_TRUE(report.error().error.is<facts::Cancelled>());
  EXPECT_THAT(report.error().left, IsEmpty());
  EXPECT_EQ(eeprom.bytes(), before);
}

TEST(SiiWriterFailure, InterfaceThatStaysBusyEndsBeforeAnythingIsWritten) {
  Eeprom eeprom(64);
  eeprom.busy_for_ever = true;
  const auto report = write(eeprom, changed(eeprom, {20}));
  ASSERT_FALSE(report);
  EXPECT_TRUE(report.error().error.is<facts::SiiBusy>());
  EXPECT_THAT(eeprom.writes, IsEmpty());
  EXPECT_THAT(describe(report.error()), HasSubstr("nothing has been written"));
}

TEST(SiiWriter, AMachineThatSuspendsTheMasterMakesNoInterfaceBusy) {
  for (const int away : {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}) {
    Eeprom eeprom(0x80);
    eeprom.busy_polls = 2;
    eeprom.refused_commands = 1;
    eeprom.away_rounds = away;
    ASSERT_TRUE(set_alias(eeprom, 7)) << away;
    EXPECT_EQ(eeprom.words[4], 7);
  }
}

TEST(SiiWriter, InterfaceThatTakesNoCommandForAWhileIsTriedAgain) {
  Eeprom eeprom(0x80);
  eeprom.refused_commands = 20;
  ASSERT_TRUE(set_alias(eeprom, 7));
  EXPECT_EQ(eeprom.words[4], 7);
  EXPECT_TRUE(eeprom.checksum_valid());
}

TEST(SiiWriterFailure, InterfaceThatNeverTakesACommandIsBusy) {
  Eeprom eeprom(0x80);
  eeprom.refused_commands = 1'000'000;
  EXPECT_THAT(failure_text(set_alias(eeprom, 7)), HasSubstr("slave 2: EEPROM interface stays busy at word 0x00"));
  EXPECT_THAT(eeprom.writes, IsEmpty());
}

TEST(SiiWriterFailure, ImageThatIsNoneIsRefused) {
  Eeprom eeprom(64);
  for (const std::size_t bytes : {0U, 2U, 14U, 17U, 0x20002U}) {
    const auto report = write(eeprom, std::vector<std::byte>(bytes));
    ASSERT_FALSE(report) << bytes;
    EXPECT_TRUE(report.error().error.is<facts::SiiContent>());
  }
  EXPECT_THAT(eeprom.writes, IsEmpty());
}

TEST(SiiWriterFailure, MayBeTriedAgain) {
  Eeprom eeprom(64);
  const auto image = changed(eeprom, {20, 30});
  Bus bus(eeprom);
  eeprom.stuck_words = {30};
  ASSERT_FALSE(write_sii(bus, kSlave, image));
  eeprom.stuck_words.clear();
  ASSERT_TRUE(write_sii(bus, kSlave, image));
  EXPECT_EQ(eeprom.bytes(), image);
}

TEST(AliasWriter, ChangesAliasAndChecksumOnly) {
  Eeprom eeprom(64);
  const auto before = eeprom.words;
  ASSERT_EQ(failure_text(set_alias(eeprom, 4711)), "");
  EXPECT_EQ(eeprom.words[4], 4711);
  EXPECT_TRUE(eeprom.checksum_valid());
  for (std::size_t i = 0; i < eeprom.words.size(); ++i) {
    if (i == 4 || i == 7) continue;
    EXPECT_EQ(eeprom.words[i], before[i]) << i;
  }
}

TEST(AliasWriter, DoesNotBlessAConfigurationAreaThatIsBroken) {
  Eeprom eeprom(64);
  eeprom.words[1] ^= 0x0100;
  const auto report = set_alias(eeprom, 4711);
  ASSERT_FALSE(report);
  EXPECT_TRUE(report.error().error.is<facts::SiiContent>());
  EXPECT_THAT(eeprom.writes, IsEmpty());
}

}  // namespace
}  // namespace driveline::ecat_master

#include "sii/sii_reader.hpp"

#include <gmock/gmock.h>

#include <optional>
#include <utility>

#include "support/must.hpp"

namespace driveline::ecat_master {
namespace {

/// A slave with only an EEPROM interface: command at 0x0502, address at 0x0504, data at 0x0508, 8 bytes each.
class Eeprom final : public DatagramExchange {
 public:
  /// An EEPROM of `kibit` KiBit without categories, all bytes 0xFF behind the header.
  explicit Eeprom(std::uint16_t kibit) : image(std::size_t{kibit} * 64, 0xFFFF) {
    std::fill(image.begin(), image.begin() + 0x40, std::uint16_t{0});
    image[0x3E] = static_cast<std::uint16_t>(kibit - 1);
  }
  /// Appends a category; returns the word behind it.
  std::size_t add_category(std::size_t at, std::uint16_t type, std::uint16_t words) {
    image.at(at) = type;
    image.at(at + 1) = words;
    for (std::uint16_t i = 0; i < words; ++i) image.at(at + 2 + i) = static_cast<std::uint16_t>(0x4000 + i);
    return at + 2 + words;
  }
  [[nodiscard]] std::vector<std::byte> bytes(std::size_t words) const {
    std::vector<std::byte> result;
    for (std::size_t i = 0; i < words; ++i) {
      result.push_back(static_cast<std::byte>(image.at(i) & 0xFF));
      result.push_back(static_cast<std::byte>(image.at(i) >> 8));
    }
    return result;
  }

  /// When a command of the master takes effect.
  enum class Takes : std::uint8_t { kAtOnce, kAtTheEndOfTheFrame };

  std::vector<std::uint16_t> image;
  std::uint16_t error_status = 0;
  std::size_t error_word = SIZE_MAX;
  std::size_t highest_word = 0;
  Takes takes = Takes::kAtOnce;
  std::size_t words_per_read = 4;
  bool shows_address = true;
  std::chrono::nanoseconds busy_time{0};
  std::chrono::nanoseconds frame_time = std::chrono::microseconds{10};
  /// The machine suspends the master for this time in each round up to `away_rounds`.
  std::chrono::nanoseconds away{0};
  std::size_t away_rounds = 0;
  std::size_t rounds = 0;
  std::size_t datagrams = 0;
  /// Register 0x0500, and what was written into it.
  std::byte owner{0};
  std::vector<std::byte> owners{};
  /// Simulates what an earlier reader has left on the interface: an address, and unrelated data.
  void leave_from_before(std::uint32_t shown, std::uint16_t rubbish) {
    word_ = shown;
    data_.fill(rubbish);
  }

  Result<void> exchange(std::span<Request> requests) override {
    now_ += frame_time;
    ++rounds;
    std::optional<std::uint32_t> shadow;
    if (rounds <= away_rounds) now_ += away;
    for (auto& request : requests) {
      ++datagrams;
      request.answered = true;
      request.working_counter = 1;
      if (request.command == wire::Command::kFpwr && request.address.ado() == 0x0502) {
        EXPECT_EQ(bytes::load_le<std::uint16_t>(request.data), 0x0100) << "a read command";
        shadow = bytes::load_le<std::uint32_t>(request.data.subspan(2));
        if (takes == Takes::kAtOnce) start(*std::exchange(shadow, std::nullopt));
      } else if (request.command == wire::Command::kFprd && request.address.ado() == 0x0502) {
        show(request.data);
      } else if (request.command == wire::Command::kFprd && request.address.ado() == 0x0500) {
        request.data[0] = owner;
      } else if (request.command == wire::Command::kFpwr && request.address.ado() == 0x0500) {
        owner = request.data[0];
        owners.push_back(owner);
      }
    }
    if (shadow) start(*shadow);
    return {};
  }
  void pause(std::chrono::nanoseconds duration) override { now_ += duration; }
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept override { return now_; }

 private:
  void start(std::uint32_t word) {
    if (now_ < done_at_) return;  // no command while another one is being executed
    word_ = word;
    highest_word = std::max<std::size_t>(highest_word, word);
    done_at_ = now_ + busy_time;
    for (std::size_t i = 0; i < words_per_read; ++i) {
      data_.at(i) = word + i < image.size() ? image[word + i] : std::uint16_t{0xFFFF};
    }
  }
  void show(std::span<std::byte> data) const {
    unsigned status = words_per_read == 4 ? 0x0040 : 0;
    if (now_ < done_at_) status |= 0x8000;
    if (word_ >= error_word) status |= error_status;
    bytes::store_le<std::uint16_t>(data, static_cast<std::uint16_t>(status));
    bytes::store_le<std::uint32_t>(data.subspan(2), shows_address ? word_ : 0xFFFFFFFFU);
    for (std::size_t i = 0; i < 4; ++i) bytes::store_le<std::uint16_t>(data.subspan(6 + 2 * i), data_.at(i));
  }

  std::uint32_t word_ = 0;
  std::array<std::uint16_t, 4> data_{};
  std::chrono::nanoseconds now_{0};
  std::chrono::nanoseconds done_at_{0};
};

Result<std::vector<std::byte>> read(Eeprom& eeprom) {
  Bus bus(eeprom);
  const SlaveRef slave{6, 0x1007};
  auto images = read_sii(bus, {&slave, 1});
  if (!images) return tl::unexpected(images.error());
  return std::move(images->at(0));
}

TEST(SiiReader, ReadsUpToTheEndMarkerAndNotTheWholeEeprom) {
  Eeprom eeprom(32);
  auto end = eeprom.add_category(0x40, 10, 21);
  end = eeprom.add_category(end, 30, 16);
  const auto image = must(read(eeprom));
  ASSERT_GE(image->size(), 2 * (end + 1));
  EXPECT_LT(image->size(), 2 * (end + 1 + 4));
  EXPECT_EQ(*image, eeprom.bytes(image->size() / 2));
}

TEST(SiiReader, TakesTheInterfaceFromTheApplicationAndReturnsIt) {
  Eeprom held(4);
  held.owner = std::byte{1};
  ASSERT_TRUE(read(held));
  // ETG.1000.4 6.4.3: 2 forces the application out, 0 is EtherCAT, 1 the application.
  EXPECT_THAT(held.owners, testing::ElementsAre(std::byte{2}, std::byte{0}, std::byte{1}));
  Eeprom ours(4);
  ASSERT_TRUE(read(ours));
  EXPECT_THAT(ours.owners, testing::ElementsAre(std::byte{2}, std::byte{0}));
}

TEST(SiiReader, ReadsABlankDirectory) {
  Eeprom eeprom(4);
  const auto image = must(read(eeprom));
  EXPECT_EQ(image->size(), 2U * 0x44);
}

TEST(SiiReader, AcceptsCategoriesThatFillTheEepromToTheLastWord) {
  for (const auto last : std::array<std::uint16_t, 6>{0, 1, 2, 3, 20, 62}) {
    Eeprom eeprom(2);  // 128 words, 64 of them for categories
    std::size_t end = 0x40;
    if (last < 62) end = eeprom.add_category(end, 10, static_cast<std::uint16_t>(60 - last));
    end = eeprom.add_category(end, 30, last);
    ASSERT_EQ(end, 128U);
    const auto image = read(eeprom);
    ASSERT_TRUE(image) << "last category of " << last << " words: " << describe(image.error());
    EXPECT_EQ(*image, eeprom.bytes(128)) << last;
    EXPECT_LT(eeprom.highest_word, 128U) << "nothing is there";
  }
}

TEST(SiiReader, RefusesCategoriesThatLeadBeyondTheEeprom) {
  Eeprom eeprom(4);
  eeprom.add_category(0x40, 10, 4);
  eeprom.image[0x46] = 30;
  eeprom.image[0x47] = 0x7000;
  const auto image = read(eeprom);
  ASSERT_FALSE(image);
  EXPECT_TRUE(image.error().is<facts::SiiContent>());
  EXPECT_EQ(image.error().slave, 6);
}

TEST(SiiReader, NamesTheWordThatCouldNotBeRead) {
  Eeprom eeprom(4);
  eeprom.error_status = 0x2000;
  eeprom.error_word = 8;
  const auto image = read(eeprom);
  ASSERT_FALSE(image);
  EXPECT_TRUE(image.error().is<facts::SiiError>());
  EXPECT_EQ(std::get<facts::SiiError>(image.error().facts).word, 8);
  EXPECT_EQ(std::get<facts::SiiError>(image.error().facts).status, 0x2040U);
}

/// An EEPROM with a name and PDOs, with the serial number and the right checksum.
Eeprom drive_eeprom(std::uint16_t serial) {
  Eeprom eeprom(16);
  auto end = eeprom.add_category(0x40, 10, 40);
  end = eeprom.add_category(end, 50, 90);
  eeprom.image[8] = 0x28;
  eeprom.image[14] = serial;
  // CRC-8 of 14 zero bytes, x^8 + x^2 + x + 1 with initial value 0xFF.
  eeprom.image[7] = 0x30;
  return eeprom;
}

TEST(SiiReader, AMachineThatSuspendsTheMasterMakesNoSlaveBusy) {
  for (const auto takes : {Eeprom::Takes::kAtOnce, Eeprom::Takes::kAtTheEndOfTheFrame}) {
    Eeprom eeprom(32);
    eeprom.add_category(0x40, 10, 21);
    eeprom.takes = takes;
    eeprom.away = std::chrono::milliseconds{300};
    eeprom.away_rounds = 10;
    const auto image = must(read(eeprom));
    EXPECT_EQ(*image, eeprom.bytes(image->size() / 2));
  }
}

TEST(SiiReader, AnEepromThatStaysBusyIsGivenUp) {
  Eeprom eeprom(32);
  eeprom.busy_time = std::chrono::seconds{10};
  const auto image = read(eeprom);
  ASSERT_FALSE(image);
  EXPECT_TRUE(image.error().is<facts::SiiBusy>());
  EXPECT_GE(eeprom.now(), std::chrono::milliseconds{100});
  EXPECT_LT(eeprom.now(), std::chrono::milliseconds{101});
}

TEST(SiiReader, GetsTheSameContentFromEveryKindOfController) {
  const auto expected = drive_eeprom(7).bytes(0x40 + 42 + 92 + 1);
  for (const auto takes : {Eeprom::Takes::kAtOnce, Eeprom::Takes::kAtTheEndOfTheFrame}) {
    for (const std::size_t words : {2U, 4U}) {
      for (const int busy_us : {0, 3, 35, 990}) {
        for (const bool shows : {true, false}) {
          auto eeprom = drive_eeprom(7);
          eeprom.takes = takes;
          eeprom.words_per_read = words;
          eeprom.busy_time = std::chrono::microseconds{busy_us};
          eeprom.shows_address = shows;
          // The worst case of an earlier reader: the address of the first word, and other data.
          eeprom.leave_from_before(0, 0xBAD0);
          const auto image = must(read(eeprom));
          ASSERT_GE(image->size(), expected.size());
          EXPECT_TRUE(std::equal(expected.begin(), expected.end(), image->begin()))
              << words << " words, " << busy_us << " us, at once " << (takes == Eeprom::Takes::kAtOnce) << ", address "
              << shows;
        }
      }
    }
  }
}

TEST(SiiReader, AsksForManyWordsPerFrameWhereTheyComeAtOnce) {
  auto fast = drive_eeprom(7);
  ASSERT_TRUE(read(fast));
  EXPECT_LE(fast.rounds, 8U) << "two for the interface, two for the first word, and few for 50 reads";
  auto latched = drive_eeprom(7);
  latched.takes = Eeprom::Takes::kAtTheEndOfTheFrame;
  ASSERT_TRUE(read(latched));
  EXPECT_LE(latched.rounds, 50U + 6U) << "one per read: the next command travels with the look for the answer";
}

TEST(SiiReader, DoesNotAskAgainForWhatItKnows) {
  auto eeprom = drive_eeprom(7);
  Bus bus(eeprom);
  const SlaveRef slave{6, 0x1007};
  const auto first = read_sii(bus, {&slave, 1});
  ASSERT_TRUE(first && first->front());
  EXPECT_EQ(bus.sii_cache().size(), 1U);
  eeprom.datagrams = 0;
  eeprom.highest_word = 0;
  const auto again = read_sii(bus, {&slave, 1});
  ASSERT_TRUE(again && again->front());
  EXPECT_EQ(*again->front(), *first->front());
  EXPECT_LT(eeprom.highest_word, 0x42U) << "the head only";
  // The same content with another serial number is another device.
  eeprom.image[14] = 8;
  eeprom.image[0x42] = 0x1234;
  const auto other = read_sii(bus, {&slave, 1});
  ASSERT_TRUE(other && other->front());
  EXPECT_NE(*other->front(), *first->front());
  EXPECT_EQ(bytes::load_le<std::uint16_t>(std::span(*other->front()).subspan(0x84)), 0x1234);
}

TEST(SiiReader, DoesNotRememberWhatCouldBeAnybodys) {
  for (const bool checksum : {true, false}) {
    auto eeprom = drive_eeprom(checksum ? 0 : 7);
    if (!checksum) eeprom.image[7] ^= 1;
    Bus bus(eeprom);
    const SlaveRef slave{6, 0x1007};
    ASSERT_TRUE(read_sii(bus, {&slave, 1}));
    EXPECT_EQ(bus.sii_cache().size(), 0U) << (checksum ? "no serial number and no alias" : "wrong checksum");
    eeprom.image[0x42] = 0x1234;
    const auto image = read_sii(bus, {&slave, 1});
    ASSERT_TRUE(image && image->front());
    EXPECT_EQ(bytes::load_le<std::uint16_t>(std::span(*image->front()).subspan(0x84)), 0x1234) << "read anew";
  }
}

}  // namespace
}  // namespace driveline::ecat_master

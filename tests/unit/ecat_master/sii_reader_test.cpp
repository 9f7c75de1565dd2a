#include "driveline/ecat_master/sii/sii_reader.hpp"

#include <gmock/gmock.h>

namespace driveline::ecat_master {
namespace {

/// A slave that consists of its EEPROM interface: command at 0x0502, address at 0x0504, data at 0x0508, 8 bytes each.
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

  std::vector<std::uint16_t> image;
  std::uint16_t error_status = 0;
  std::size_t error_word = SIZE_MAX;
  std::size_t highest_word = 0;

  Result<void> exchange(std::span<Request> requests) override {
    now_ += std::chrono::microseconds{10};
    for (auto& request : requests) {
      request.answered = true;
      request.working_counter = 1;
      if (request.command == wire::Command::kFpwr && request.address.ado() == 0x0502) {
        word_ = wire::load_le<std::uint32_t>(request.data.subspan(2));
        highest_word = std::max(highest_word, word_);
      } else if (request.command == wire::Command::kFprd && request.address.ado() == 0x0502) {
        wire::store_le<std::uint16_t>(request.data,
                                      static_cast<std::uint16_t>(0x0040 | (word_ >= error_word ? error_status : 0)));
        for (std::size_t i = 0; i < 4; ++i) {
          const auto value = word_ + i < image.size() ? image[word_ + i] : std::uint16_t{0xFFFF};
          wire::store_le<std::uint16_t>(request.data.subspan(6 + 2 * i), value);
        }
      }
    }
    return {};
  }
  void pause(std::chrono::nanoseconds duration) override { now_ += duration; }
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept override { return now_; }

 private:
  std::size_t word_ = 0;
  std::chrono::nanoseconds now_{0};
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
  const auto image = read(eeprom);
  ASSERT_TRUE(image);
  ASSERT_GE(image->size(), 2 * (end + 1));
  EXPECT_LT(image->size(), 2 * (end + 1 + 4));
  EXPECT_EQ(*image, eeprom.bytes(image->size() / 2));
}

TEST(SiiReader, ReadsABlankDirectory) {
  Eeprom eeprom(4);
  const auto image = read(eeprom);
  ASSERT_TRUE(image);
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
  EXPECT_EQ(image.error().kind, ErrorKind::kSiiContent);
  EXPECT_EQ(image.error().slave, 6);
}

TEST(SiiReader, NamesTheWordThatCouldNotBeRead) {
  Eeprom eeprom(4);
  eeprom.error_status = 0x2000;
  eeprom.error_word = 8;
  const auto image = read(eeprom);
  ASSERT_FALSE(image);
  EXPECT_EQ(image.error().kind, ErrorKind::kSiiError);
  EXPECT_EQ(image.error().address, 8);
  EXPECT_EQ(image.error().code, 0x2040U);
}

}  // namespace
}  // namespace driveline::ecat_master

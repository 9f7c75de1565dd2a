#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>

#include "driveline/esi/esi_file.hpp"
#include "driveline/esi/sii.hpp"
#include "sample_device.hpp"

/// Damaged files. The assertions are weak (an accepted file is not altered, a refusal has a position); the sanitizers,
/// which also run on these tests, find the rest.
namespace driveline::esi {
namespace {

using std::literals::operator""sv;
using test::random_device;
using test::sample_device;

void expect_sane(const std::vector<std::byte>& bytes) {
  const auto image = decode_sii(bytes);
  if (!image) {
    ASSERT_LE(image.error().word_offset, bytes.size() / 2);
    ASSERT_GT(image.error().needed_bytes, image.error().available_bytes);
    ASSERT_FALSE(to_text(image.error()).empty());
    return;
  }
  ASSERT_EQ(encode_sii(*image), bytes);
  const auto remade = decode_sii(encode_sii(make_sii(description_from_sii(*image))));
  ASSERT_TRUE(remade) << to_text(remade.error());
}

/// The image of the sample device in the smallest EEPROM that can hold it.
std::vector<std::byte> small_image() {
  DeviceDescription device = sample_device();
  device.eeprom_bytes = 128;
  return encode_sii(make_sii(device));
}

DeviceDescription small_random_device(std::mt19937& random) {
  DeviceDescription device = random_device(random);
  device.eeprom_bytes = 128;
  return device;
}

void expect_sane(const std::string& xml) {
  const auto file = read_esi(xml, "f.xml");
  if (!file) {
    ASSERT_GE(file.error().line, 1U);
    ASSERT_LE(file.error().line, 1U + static_cast<std::size_t>(std::count(xml.begin(), xml.end(), '\n')));
    ASSERT_FALSE(file.error().problem.empty());
    return;
  }
  ASSERT_TRUE(read_esi(write_esi(file->devices), "again.xml")) << xml;
}

TEST(SiiMutation, EveryByteFlipped) {
  const auto image = small_image();
  for (std::size_t i = 0; i < image.size(); ++i) {
    SCOPED_TRACE(i);
    auto damaged = image;
    damaged[i] ^= std::byte{0xFF};
    expect_sane(damaged);
    damaged[i] = image[i] ^ std::byte{1};
    expect_sane(damaged);
  }
}

TEST(SiiMutation, EveryTruncation) {
  const auto image = small_image();
  for (std::size_t size = 0; size <= image.size(); ++size) {
    SCOPED_TRACE(size);
    expect_sane(std::vector<std::byte>(image.begin(), image.begin() + static_cast<std::ptrdiff_t>(size)));
  }
}

TEST(SiiMutation, RandomDamage) {
  for (unsigned seed = 1; seed <= 3000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    auto image = seed % 2 == 0 ? small_image() : encode_sii(make_sii(small_random_device(random)));
    image.resize(std::min<std::size_t>(image.size(), 1024));
    for (unsigned i = 0; i <= seed % 8; ++i) image[random() % image.size()] = static_cast<std::byte>(random());
    expect_sane(image);
  }
}

TEST(SiiMutation, RandomCategories) {
  for (unsigned seed = 1; seed <= 3000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::vector<std::byte> image(128 + 2 * (random() % 100));
    for (auto& b : image) b = static_cast<std::byte>(random() % 4 == 0 ? random() : random() % 3);
    constexpr std::array kTypes = {10, 30, 40, 41, 50, 51, 60};
    if (image.size() >= 132) {
      image[128] = static_cast<std::byte>(kTypes[random() % kTypes.size()]);
      image[129] = std::byte{0};
      image[130] = static_cast<std::byte>(random() % 50);
      image[131] = std::byte{0};
    }
    image.insert(image.end(), 2, std::byte{0xFF});
    expect_sane(image);
  }
}

TEST(EsiMutation, EveryByteFlipped) {
  const std::string xml = write_esi({sample_device()});
  for (std::size_t i = 0; i < xml.size(); ++i) {
    SCOPED_TRACE(i);
    std::string damaged = xml;
    damaged[i] = static_cast<char>(damaged[i] ^ 1);
    expect_sane(damaged);
  }
}

TEST(EsiMutation, EveryTruncation) {
  const std::string xml = write_esi({sample_device()});
  for (std::size_t size = 0; size < xml.size(); ++size) {
    SCOPED_TRACE(size);
    const std::string damaged = xml.substr(0, size);
    expect_sane(damaged);
    if (size + 1 < xml.size()) {
      ASSERT_FALSE(read_esi(damaged, "f.xml")) << "accepted without its end";
    }
  }
}

TEST(EsiMutation, RandomDamage) {
  const std::string xml = write_esi({sample_device()});
  constexpr std::array<std::string_view, 12> kPieces = {"<",  ">",      "/>",      "&#0;", "#xFFFFFFFFF", "-1",
                                                        "\"", "\0\0"sv, "<Entry>", "]]>",  "99999999999", "\xFF"};
  static_assert(std::ranges::none_of(kPieces, &std::string_view::empty), "a piece that is empty damages nothing");
  for (unsigned seed = 1; seed <= 3000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::string damaged = xml;
    for (unsigned i = 0; i <= seed % 5; ++i) {
      const std::size_t at = random() % damaged.size();
      damaged.replace(at, random() % std::min<std::size_t>(40, damaged.size() - at + 1),
                      kPieces[random() % kPieces.size()]);
    }
    expect_sane(damaged);
  }
}

/// Numbers exchanged inside the elements: well-formed XML with wrong content.
TEST(EsiMutation, RandomNumbers) {
  const std::string xml = write_esi({sample_device()});
  for (unsigned seed = 1; seed <= 2000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::string damaged = xml;
    for (char& c : damaged) {
      if (c >= '0' && c <= '9' && random() % 50 == 0) c = static_cast<char>('0' + random() % 10);
    }
    expect_sane(damaged);
  }
}

TEST(EsiMutation, DeepNesting) {
  std::string xml;
  for (int i = 0; i < 200000; ++i) xml += "<EtherCATInfo>";
  expect_sane(xml);
  for (int i = 0; i < 200000; ++i) xml += "</EtherCATInfo>";
  expect_sane(xml);
}

}  // namespace
}  // namespace driveline::esi

#include "driveline/slaves/msd/sercos/servoone_idns.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/bytes/endian.hpp"
#include "driveline/slaves/idn/idn_dictionary.hpp"

namespace driveline::slaves::msd::sercos {
namespace {

using wire::AlState;
using wire::SoeCommandState;
using wire::SoeElement;
using wire::SoeError;
using Bytes = std::vector<std::byte>;

constexpr std::array kPhases = {AlState::kPreOp, AlState::kSafeOp, AlState::kOp};
constexpr std::array kElements = {SoeElement::kName, SoeElement::kAttribute, SoeElement::kUnit,   SoeElement::kMin,
                                  SoeElement::kMax,  SoeElement::kValue,     SoeElement::kDefault};

bool is_standard(const IdnRow& row) {
  return row.idn.raw < 0x8000;
}

/// Phases that allow a write, as in Table 10.1: "24" is CP2 and CP4.
std::string writable(const IdnRow& row) {
  std::string phases;
  if (!row.attribute.pre_op_protected) phases += '2';
  if (!row.attribute.safe_op_protected) phases += '3';
  if (!row.attribute.op_protected) phases += '4';
  return phases;
}

/// Raw numbers of the rows that are writable in exactly these phases.
std::vector<unsigned> writable_in(std::string_view phases) {
  std::vector<unsigned> found;
  for (const auto& row : servoone_idns().rows()) {
    if (writable(row) == phases) found.push_back(row.idn.raw);
  }
  return found;
}

TEST(ServoOneIdns, AreThoseOfTheManualAndFourMore) {
  std::vector<unsigned> beside;
  std::size_t standard = 0;
  std::uint16_t line = 0;
  for (const auto& row : servoone_idns().rows()) {
    standard += is_standard(row) ? 1 : 0;
    EXPECT_FALSE(row.source.empty()) << row.name;
    if (row.line == 0) {
      beside.push_back(row.idn.raw);
      continue;
    }
    EXPECT_GT(row.line, line) << row.name << ": Table 10.1 is in the order of the numbers";
    line = row.line;
  }
  EXPECT_EQ(servoone_idns().rows().size(), 479U);
  EXPECT_EQ(standard, 212U);
  EXPECT_THAT(beside, testing::ElementsAre(0x8000 + 156, 0x8000 + 279, 0x8000 + 743, 0x8000 + 2242));
}

TEST(ServoOneIdns, AreFoundByTheirNumbersAndNothingElseIs) {
  const auto& table = servoone_idns();
  std::size_t found = 0;
  for (unsigned raw = 0; raw <= 0xFFFF; ++raw) {
    const auto* row = table.find({static_cast<std::uint16_t>(raw)});
    if (row == nullptr) continue;
    EXPECT_EQ(row->idn.raw, raw);
    ++found;
  }
  EXPECT_EQ(found, table.rows().size());
}

/// Table 10.1 has 133 IDNs that no phase can write, 146 for CP2 alone, 190 for all; of the others the numbers.
TEST(ServoOneIdns, HaveTheProtectionOfTheManual) {
  const auto standard = [](const std::vector<unsigned>& idns) {
    return std::count_if(idns.begin(), idns.end(), [](unsigned raw) { return raw < 0x8000; });
  };
  const auto never = writable_in("");
  const auto cp2 = writable_in("2");
  const auto always = writable_in("234");
  EXPECT_EQ(standard(never), 86);
  EXPECT_EQ(never.size(), 133U + 1U) << "and P 279";
  EXPECT_EQ(standard(cp2), 46);
  EXPECT_EQ(cp2.size(), 146U);
  EXPECT_EQ(standard(always), 74);
  EXPECT_EQ(always.size(), 190U + 3U) << "and P 156, P 743, P 2242";
  EXPECT_THAT(writable_in("23"), testing::ElementsAre(32, 33, 34, 35, 147));
  EXPECT_THAT(writable_in("3"), testing::ElementsAre(128));
}

TEST(ServoOneIdns, TelegramsCarryNumbersThatTheyMay) {
  std::size_t stored = 0;
  for (const auto& row : servoone_idns().rows()) {
    const auto has = [&row](unsigned uses) { return (row.uses & uses) != 0; };
    EXPECT_TRUE(is_number(row) || !has(idn_use::kAt | idn_use::kMdt)) << row.name;
    EXPECT_FALSE(has(idn_use::kMdt) && row.attribute.op_protected) << row.name;
    EXPECT_FALSE(has(idn_use::kSaved) && is_read_only(row.attribute)) << row.name;
    stored += (row.uses & idn_use::kStored) != 0 ? 1 : 0;
  }
  EXPECT_EQ(stored, 30U) << "docs/sercos.md says so; at most 45 may be without effect";
  for (const std::uint16_t length : {std::uint16_t{185}, std::uint16_t{186}}) {
    EXPECT_EQ(servoone_idns().find({length})->initial, 20)
        << "the most bytes of a data record (SERCOS manual 191, 192)";
  }
}

/// A drive whose commands start and never end by themselves.
class Drive final : public IdnDictionary {
 public:
  Drive() : IdnDictionary({&servoone_idns()}) {}

 private:
  SoeAnswer<void> start_command(std::uint8_t, wire::Idn) override { return {}; }
};

Bytes le_bytes(const IdnRow& row, double number) {
  Bytes bytes(row.attribute.element_size());
  raw_to_bytes(raw_from_number(row.attribute, number), bytes);
  return bytes;
}

/// Another valid value of a number, or the only one.
double other_value(const IdnRow& row) {
  if (row.initial + 1 <= row.maximum) return row.initial + 1;
  return row.initial - 1 >= row.minimum ? row.initial - 1 : row.initial;
}

/// A value for a write, with the header of a list.
Bytes value_for(const IdnRow& row) {
  if (row.attribute.command) return le_bytes(row, wire::kSoeCommandStart);
  if (!row.attribute.list) return le_bytes(row, other_value(row));
  const auto size = static_cast<std::byte>(row.attribute.element_size());
  Bytes bytes{size, std::byte{0}, size, std::byte{0}};
  bytes.resize(4 + row.attribute.element_size(), std::byte{0x21});
  return bytes;
}

SoeAnswer<Bytes> text_or(std::string_view text, SoeError none) {
  if (text.empty()) return tl::unexpected(none);
  const auto size = static_cast<std::byte>(text.size());
  Bytes bytes{size, std::byte{0}, size, std::byte{0}};
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

SoeAnswer<Bytes> number_or(const IdnRow& row, bool exists, double number, SoeError none) {
  if (!exists) return tl::unexpected(none);
  return le_bytes(row, number);
}

/// Returns the answer to a read of an element of this row, but its value.
SoeAnswer<Bytes> expected_element(const IdnRow& row, SoeElement element) {
  switch (element) {
    case SoeElement::kName:
      return text_or(row.name, SoeError::kNoName);
    case SoeElement::kUnit:
      return text_or(row.unit, SoeError::kNoUnit);
    case SoeElement::kMin:
      return number_or(row, std::isfinite(row.minimum), row.minimum, SoeError::kNoMin);
    case SoeElement::kMax:
      return number_or(row, std::isfinite(row.maximum), row.maximum, SoeError::kNoMax);
    case SoeElement::kDefault:
      return number_or(row, row.has_default, row.initial, SoeError::kNoDefault);
    default:
      return tl::unexpected(SoeError::kNoElement);
  }
}

void expect_value_of_its_length(const IdnRow& row, const Bytes& value) {
  if (!row.attribute.list) {
    EXPECT_EQ(value.size(), row.attribute.element_size());
    return;
  }
  EXPECT_EQ(bytes::load_le<std::uint16_t>(value), value.size() - 4);
  EXPECT_EQ(bytes::load_le<std::uint16_t>(std::span(value).subspan(2)), row.capacity);
}

/// Reads an element and expects it as it is on the wire: number, text or list with header, or the error for a missing
/// one.
void expect_element(Drive& drive, const IdnRow& row, SoeElement element, AlState phase) {
  const auto answer = drive.read_element({0, row.idn, element, phase});
  if (element == SoeElement::kAttribute) {
    EXPECT_EQ(wire::SoeAttribute::decode(answer.value()), row.attribute);
  } else if (element == SoeElement::kValue) {
    expect_value_of_its_length(row, answer.value());
  } else {
    EXPECT_EQ(answer, expected_element(row, element));
  }
}

/// Expects a write to be refused where Table 10.1 has an x, and otherwise to be what is read next.
void expect_write(Drive& drive, const IdnRow& row, AlState phase) {
  const SoeAccess access{0, row.idn, SoeElement::kValue, phase};
  const char number = phase == AlState::kPreOp ? '2' : phase == AlState::kSafeOp ? '3' : '4';
  const auto phases = writable(row);
  const auto before = drive.read_element(access);
  const auto value = value_for(row);
  const auto done = drive.write_element(access, value);
  const auto after = drive.read_element(access);
  if (phases.find(number) == std::string::npos) {
    EXPECT_EQ(done.error(), phases.empty() ? SoeError::kValueReadOnly : SoeError::kValueProtected);
    EXPECT_EQ(after, before);
    return;
  }
  ASSERT_TRUE(done) << wire::to_text(done.error());
  EXPECT_EQ(Bytes(after->end() - static_cast<std::ptrdiff_t>(row.attribute.element_size()), after->end()),
            Bytes(value.end() - static_cast<std::ptrdiff_t>(row.attribute.element_size()), value.end()));
  if (row.attribute.command) {
    const auto state = drive.read_element({0, row.idn, SoeElement::kState, phase});
    EXPECT_EQ(bytes::load_le<std::uint16_t>(*state), static_cast<std::uint16_t>(SoeCommandState::kInProgress));
    EXPECT_TRUE(drive.write_element(access, le_bytes(row, wire::kSoeCommandCancel)));
  }
}

TEST(ServoOneIdns, EveryElementIsReadAndWrittenAsEachPhaseAllows) {
  Drive drive;
  for (const auto& row : servoone_idns().rows()) {
    const auto idn = row.idn.text();
    for (const auto phase : kPhases) {
      SCOPED_TRACE(std::string(idn.data(), idn.size()) + " in " + std::to_string(static_cast<int>(phase)));
      for (const auto element : kElements) expect_element(drive, row, element, phase);
      expect_write(drive, row, phase);
    }
  }
}

TEST(ServoOneIdns, ListsOfIdnsFollowFromTheTable) {
  Drive drive;
  const auto list = [&drive](std::uint16_t idn) {
    const auto answer = drive.read_element({0, {idn}, SoeElement::kValue, AlState::kPreOp});
    std::vector<unsigned> idns;
    for (std::size_t at = 4; at < answer->size(); at += 2) {
      idns.push_back(bytes::load_le<std::uint16_t>(std::span(*answer).subspan(at)));
    }
    return idns;
  };
  const auto all = list(17);
  EXPECT_EQ(all.size(), 479U);
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end()));
  EXPECT_THAT(list(25), testing::ElementsAre(99, 127, 128, 148, 152, 170, 216, 262, 263, 264, 0x8000 + 3030));
  EXPECT_THAT(list(187), testing::IsSupersetOf({40, 51, 53, 84, 144}));
  EXPECT_THAT(list(188), testing::IsSupersetOf(
                             {36, 37, 47, 80, 81, 145, 0x8000 + 141, 0x8000 + 3055, 0x8000 + 3056, 0x8000 + 3100}));
  EXPECT_THAT(list(292), testing::ElementsAre(1, 2, 3, 4, 6, 0x0B, 0x0C, 0x13, 0x14, 0x1B, 0x1C));
  EXPECT_THAT(list(0x8000 + 3002),
              testing::ElementsAre(11, 12, 13, 14, 0x8000 + 121, 0x8000 + 143, 144, 179, 0x8000 + 239, 310, 311, 312,
                                   330, 331, 332, 333, 334, 335, 336, 341, 401, 402, 403, 409, 410, 411, 412, 419));
  EXPECT_THAT(list(0x8000 + 3003), testing::ElementsAre(405, 406, 0x8000 + 141));
}

TEST(ServoOneIdns, TwoNumbersOfOneValueAreOneValue) {
  Drive drive;
  const auto written = bytes::to_le_bytes(std::uint32_t{0x00ABCDEF});
  ASSERT_TRUE(drive.write_element({0, {0x8000 + 743}, SoeElement::kValue, AlState::kOp}, written));
  EXPECT_EQ(drive.values(0).get(kServoOneValue.tracking_limit), 0x00ABCDEFU);
  EXPECT_EQ(drive.read_element({0, {0x8000 + 742}, SoeElement::kValue, AlState::kOp}),
            Bytes(written.begin(), written.end()));
  drive.values(0).set(kServoOneValue.tracking_error, std::int32_t{-7654});
  EXPECT_EQ(drive.read_element({0, {189}, SoeElement::kValue, AlState::kOp}),
            drive.read_element({0, {0x8000 + 279}, SoeElement::kValue, AlState::kOp}));
}

TEST(ServoOneIdns, EachHasALineOfTheReferencePage) {
  const auto page = idn_reference();
  std::size_t lines = 0;
  for (auto at = page.find("\n| "); at != std::string::npos; at = page.find("\n| ", at + 1)) ++lines;
  EXPECT_EQ(lines, servoone_idns().rows().size() + 1);
  EXPECT_THAT(page, testing::HasSubstr("| S-0-0079 | Rotational position resolution | U32 | 2 | 3600000 | "
                                       "1 ... 4294967295 |  | saved | 1592 | "));
  EXPECT_THAT(page, testing::HasSubstr("| S-0-0128 | CP4 transition check | command | 3 |  |  |  |  | 1639 | "));
}

}  // namespace
}  // namespace driveline::slaves::msd::sercos

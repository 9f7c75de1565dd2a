#include "text/soe_text.hpp"

#include <gmock/gmock.h>

namespace driveline::cli {
namespace {

using wire::SoeAttribute;
using wire::SoeDisplay;

std::vector<std::byte> soe_bytes(std::initializer_list<unsigned> values) {
  std::vector<std::byte> bytes;
  for (const auto value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

struct SoeValueCase {
  SoeAttribute attribute;
  std::vector<std::byte> bytes;
  const char* text;
  const char* json;
};

const SoeValueCase kSoeValues[] = {
    {{.length_code = 1, .display = SoeDisplay::kUnsigned}, soe_bytes({0xFF, 0xFF}), "65535", "65535"},
    {{.length_code = 0, .display = SoeDisplay::kSigned}, soe_bytes({0x80}), "-128", "-128"},
    {{.length_code = 2, .display = SoeDisplay::kSigned}, soe_bytes({0xFE, 0xFF, 0xFF, 0xFF}), "-2", "-2"},
    {{.length_code = 3, .display = SoeDisplay::kSigned},
     soe_bytes({0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}),
     "-1",
     "-1"},
    {{.length_code = 1, .display = SoeDisplay::kHexadecimal}, soe_bytes({0x2C, 0x01}), "0x012C", "300"},
    {{.length_code = 0, .display = SoeDisplay::kBinary}, soe_bytes({0x05}), "0b00000101", "5"},
    {{.length_code = 1, .display = SoeDisplay::kIdn}, soe_bytes({0x11, 0x80}), "P-0-0017", "\"P-0-0017\""},
    {{.length_code = 2, .display = SoeDisplay::kFloat}, soe_bytes({0, 0, 0xC0, 0xBF}), "-1.5", "-1.5"},
    {{.length_code = 0, .list = true, .display = SoeDisplay::kText}, soe_bytes({'h', 'i'}), "hi", "\"hi\""},
    {{.length_code = 1, .list = true, .display = SoeDisplay::kIdn},
     soe_bytes({0x11, 0, 0x12, 0}),
     "[S-0-0017, S-0-0018]",
     "[\"S-0-0017\",\"S-0-0018\"]"},
    {{.length_code = 1, .list = true, .display = SoeDisplay::kUnsigned}, {}, "[]", "[]"},
};

TEST(SoeText, ValuesAreShownAsTheirAttributeSaysAndReadTheSameWay) {
  for (const auto& c : kSoeValues) {
    EXPECT_EQ(soe_value_text(c.bytes, c.attribute), c.text);
    EXPECT_EQ(soe_value_json(c.bytes, c.attribute).dump(), c.json);
    std::string typed = c.text;
    if (typed.starts_with('[')) typed = typed.substr(1, typed.size() - 2);
    const auto parsed = parse_soe_value(typed, c.attribute);
    ASSERT_TRUE(parsed) << c.text << ": " << parsed.error().text;
    EXPECT_EQ(*parsed, c.bytes) << c.text;
  }
}

TEST(SoeText, BytesThatDoNotFitAreShownAsTheyAre) {
  EXPECT_EQ(soe_value_text(soe_bytes({1, 0xAB, 3}), {.length_code = 1}), "01 AB 03");
  EXPECT_EQ(soe_value_json(soe_bytes({1}), {.length_code = 1, .list = true}), "01");
}

TEST(SoeText, WhatIsNoValueIsRefusedAsUsage) {
  const SoeAttribute byte{.length_code = 0};
  for (const auto* text : {"", "256", "-129", "1x", "0x", "0x100", "one", "1,2", "S-0-0001", "1.5"}) {
    const auto parsed = parse_soe_value(text, byte);
    ASSERT_FALSE(parsed) << text;
    EXPECT_EQ(parsed.error().status, 2);
  }
  EXPECT_EQ(parse_soe_value("x", byte).error().text, "\"x\" is not a value of 1 byte, unsigned");
  EXPECT_FALSE(parse_soe_value("1,,2", {.length_code = 0, .list = true}));
  EXPECT_FALSE(parse_soe_value("1,", {.length_code = 0, .list = true}));
}

ecat_master::SoeParameter soe_parameter() {
  ecat_master::SoeParameter parameter;
  parameter.name = "Gain";
  parameter.attribute = SoeAttribute{.decimals = 2, .op_protected = true};
  parameter.unit = "As/rad";
  parameter.value = soe_bytes({100, 0});
  parameter.max = soe_bytes({200, 0});
  return parameter;
}

TEST(SoeText, AListHasALineForEachDatum) {
  auto parameter = soe_parameter();
  EXPECT_EQ(soe_line_text(wire::Idn{100}, parameter), "S-0-0100  Gain                              100 As/rad");
  parameter.unit.reset();
  parameter.value.reset();
  EXPECT_EQ(soe_line_text(wire::Idn{100}, parameter), "S-0-0100  Gain                              -");
}

TEST(SoeText, ATextOfTheDriveDoesNotSteerTheTerminal) {
  auto parameter = soe_parameter();
  parameter.name = "\x1b[2JGain\n";
  parameter.unit = "\x7Frad\t";
  EXPECT_EQ(soe_line_text(wire::Idn{100}, parameter), "S-0-0100  .[2JGain.                         100 .rad.");
  EXPECT_THAT(soe_parameter_text(wire::Idn{100}, parameter), testing::StartsWith("S-0-0100  .[2JGain.\n"));
  const SoeAttribute text{.length_code = 0, .list = true, .display = SoeDisplay::kText};
  EXPECT_EQ(soe_value_text(soe_bytes({'a', 0x1B, '\n', 0xC3, 0xA9}), text), "a..\xC3\xA9");
}

TEST(SoeText, ADatumIsALineForEachElementThatItHas) {
  EXPECT_EQ(soe_parameter_text(wire::Idn{100}, soe_parameter()),
            "S-0-0100  Gain\n"
            "  value     100\n"
            "  unit      As/rad\n"
            "  maximum   200\n"
            "  attribute 2 bytes, unsigned, 2 decimals, protected in OP\n");
}

TEST(SoeText, ADocumentNamesAllElements) {
  auto parameter = soe_parameter();
  parameter.state = 3;
  const auto document = soe_parameter_json(wire::Idn{100}, parameter);
  EXPECT_EQ(document["idn"], "S-0-0100");
  EXPECT_EQ(document["value"], 100);
  EXPECT_EQ(document["maximum"], 200);
  EXPECT_TRUE(document["minimum"].is_null());
  EXPECT_EQ(document["state"], 3);
  EXPECT_EQ(document["attribute"]["protected"], nlohmann::json::array({"OP"}));
  EXPECT_EQ(document["attribute"]["bytes"], 2);
}

}  // namespace
}  // namespace driveline::cli

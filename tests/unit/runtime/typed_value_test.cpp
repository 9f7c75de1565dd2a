#include "driveline/runtime/config/typed_value.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "support/must.hpp"

namespace driveline::runtime {
namespace {

std::vector<std::byte> bytes(std::initializer_list<int> values) {
  std::vector<std::byte> data;
  for (const int value : values) data.push_back(static_cast<std::byte>(value));
  return data;
}

ValueType type(std::string_view name) {
  return parse_type(name).value();
}

struct Row {
  const char* type;
  const char* written;  ///< as typed by the user
  std::vector<std::byte> data;
  const char* shown;
};

void PrintTo(const Row& row, std::ostream* stream) {
  *stream << row.type << ' ' << row.written;
}

class TypedValue : public testing::TestWithParam<Row> {};

TEST_P(TypedValue, GoesBothWays) {
  const auto& row = GetParam();
  const auto data = parse_value(row.written, type(row.type));
  ASSERT_TRUE(data) << describe(data.error());
  EXPECT_EQ(*data, row.data);
  EXPECT_EQ(format_value(row.data, type(row.type)).value(), row.shown);
}

INSTANTIATE_TEST_SUITE_P(
    Numbers, TypedValue,
    testing::Values(
        Row{"uint8", "255", bytes({0xFF}), "0xff 255"}, Row{"uint8", "0", bytes({0}), "0x00 0"},
        Row{"int8", "-128", bytes({0x80}), "0x80 -128"}, Row{"int8", "127", bytes({0x7F}), "0x7f 127"},
        Row{"uint16", "0x1234", bytes({0x34, 0x12}), "0x1234 4660"},
        Row{"uint16", "65535", bytes({0xFF, 0xFF}), "0xffff 65535"},
        Row{"int16", "-2", bytes({0xFE, 0xFF}), "0xfffe -2"}, Row{"int16", "0xFFFF", bytes({0xFF, 0xFF}), "0xffff -1"},
        Row{"int16", "-0x8000", bytes({0x00, 0x80}), "0x8000 -32768"},
        Row{"uint32", "0XDEADbeef", bytes({0xEF, 0xBE, 0xAD, 0xDE}), "0xdeadbeef 3735928559"},
        Row{"int32", "-2147483648", bytes({0, 0, 0, 0x80}), "0x80000000 -2147483648"},
        Row{"uint64", "18446744073709551615", bytes({0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}),
            "0xffffffffffffffff 18446744073709551615"},
        Row{"int64", "-9223372036854775808", bytes({0, 0, 0, 0, 0, 0, 0, 0x80}),
            "0x8000000000000000 -9223372036854775808"},
        Row{"int64", "-1", bytes({0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}), "0xffffffffffffffff -1"},
        Row{"float", "1.5", bytes({0, 0, 0xC0, 0x3F}), "1.5"}, Row{"float", "-2", bytes({0, 0, 0, 0xC0}), "-2"},
        Row{"double", "0.1", bytes({0x9A, 0x99, 0x99, 0x99, 0x99, 0x99, 0xB9, 0x3F}), "0.1"},
        Row{"double", "-1e300", bytes({0x9C, 0x75, 0x00, 0x88, 0x3C, 0xE4, 0x37, 0xFE}), "-1e+300"}));

INSTANTIATE_TEST_SUITE_P(Others, TypedValue,
                         testing::Values(Row{"string", "MSD", bytes({'M', 'S', 'D'}), "MSD"}, Row{"string", "", {}, ""},
                                         Row{"", "01 fF", bytes({0x01, 0xFF}), "0x01 0xff"},
                                         Row{"raw", "0102", bytes({0x01, 0x02}), "0x01 0x02"},
                                         Row{"raw", "01 02 03", bytes({1, 2, 3}), "0x01 0x02 0x03"},
                                         Row{"raw", "7f", bytes({0x7F}), "0x7f"},
                                         Row{"raw", "ffffffffffffffff",
                                             bytes({0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}),
                                             "0xff 0xff 0xff 0xff 0xff 0xff 0xff 0xff"},
                                         Row{"raw", "0x01 0x02", bytes({1, 2}), "0x01 0x02"}, Row{"raw", "", {}, ""},
                                         Row{"octet_string", "00 80", bytes({0, 0x80}), "0x00 0x80"},
                                         Row{"bool", "1", bytes({1}), "1"}, Row{"bool", "0", bytes({0}), "0"}));

struct Refused {
  const char* type;
  const char* written;
  const char* sentence;
};

void PrintTo(const Refused& row, std::ostream* stream) {
  *stream << row.type << ' ' << row.written;
}

class RefusedValue : public testing::TestWithParam<Refused> {};

TEST_P(RefusedValue, IsExplained) {
  EXPECT_EQ(failure_text(parse_value(GetParam().written, type(GetParam().type))), GetParam().sentence);
}

INSTANTIATE_TEST_SUITE_P(
    OutOfRange, RefusedValue,
    testing::Values(Refused{"uint8", "256", "value \"256\": out of the range of uint8"},
                    Refused{"int8", "128", "value \"128\": out of the range of int8"},
                    Refused{"int8", "-129", "value \"-129\": out of the range of int8"},
                    Refused{"int8", "0x100", "value \"0x100\": out of the range of int8"},
                    Refused{"int16", "-0x8001", "value \"-0x8001\": out of the range of int16"},
                    Refused{"uint32", "4294967296", "value \"4294967296\": out of the range of uint32"},
                    Refused{"int64", "9223372036854775808", "value \"9223372036854775808\": out of the range of int64"},
                    Refused{"uint64", "18446744073709551616",
                            "value \"18446744073709551616\": out of the range of uint64"}));

INSTANTIATE_TEST_SUITE_P(
    NotOfTheType, RefusedValue,
    testing::Values(Refused{"uint8", "", "value \"\": uint8 is expected"},
                    Refused{"uint8", "-1", "value \"-1\": uint8 is expected"},
                    Refused{"uint16", "0x", "value \"0x\": uint16 is expected"},
                    Refused{"uint16", "12a", "value \"12a\": uint16 is expected"},
                    Refused{"uint16", " 1", "value \" 1\": uint16 is expected"},
                    Refused{"int32", "--5", "value \"--5\": int32 is expected"},
                    Refused{"int32", "5.0", "value \"5.0\": int32 is expected"},
                    Refused{"float", "1,5", "value \"1,5\": float is expected"},
                    Refused{"double", "", "value \"\": double is expected"},
                    Refused{"raw", "123", "value \"123\": bytes of two hex digits are expected, or a --type"},
                    Refused{"raw", "0x1", "value \"0x1\": bytes of two hex digits are expected, or a --type"},
                    Refused{"raw", "0x", "value \"0x\": bytes of two hex digits are expected, or a --type"},
                    Refused{"bool", "true", "value \"true\": bool is expected"},
                    Refused{"", "hello", "value \"hello\": bytes of two hex digits are expected, or a --type"}));

TEST(TypedValues, ObjectOfAnotherSizeIsShownRaw) {
  EXPECT_EQ(format_value(bytes({0x50, 0x02}), ValueType::kInt32).error().reason,
            "the object has 2 bytes, but int32 has 4: 50 02");
  EXPECT_EQ(format_value({}, ValueType::kFloat).error().reason, "the object has 0 bytes, but float has 4: ");
  EXPECT_FALSE(decode_value(bytes({1}), ValueType::kUint16));
}

TEST(TypedValues, StringEndsAtTheFirstZero) {
  EXPECT_EQ(format_value(bytes({'M', 'S', 'D', 0, 0x80, 0xFF}), ValueType::kString).value(), "MSD");
}

TEST(TypedValues, UnicodeIsUtf16) {
  const auto text = [](std::initializer_list<int> values) {
    return format_value(bytes(values), ValueType::kUnicode).value();
  };
  EXPECT_EQ(text({'M', 0, 0xFC, 0, 0xAC, 0x20, 0, 0, 'x', 0}), "M\xC3\xBC\xE2\x82\xAC");
  EXPECT_EQ(text({0x3D, 0xD8, 0x00, 0xDE}), "\xF0\x9F\x98\x80");
  EXPECT_EQ(text({0x3D, 0xD8, 'x', 0}), "\xEF\xBF\xBDx") << "half of a pair";
  EXPECT_EQ(text({'M', 0, 'x'}), "M") << "half a character";
  EXPECT_FALSE(parse_value("x", ValueType::kUnicode));
}

TEST(TypedValues, UnknownTypeListsTheKnownOnes) {
  EXPECT_EQ(
      parse_type("word").error().reason,
      "type \"word\": one of raw, octet_string, bool, uint8, uint16, uint32, uint64, int8, int16, int32, int64, float, "
      "double, string, unicode_string is expected");
}

}  // namespace
}  // namespace driveline::runtime

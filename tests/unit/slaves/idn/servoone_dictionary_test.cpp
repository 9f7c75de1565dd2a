// The ServoOne's IDNs on a drive core: one value with two addresses, in the units of the weighting in force.
#include "driveline/slaves/msd/sercos/servoone_dictionary.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <stdexcept>
#include <string>
#include <vector>

#include "driveline/bytes/endian.hpp"
#include "driveline/rt_guard/rt_guard.hpp"
#include "driveline/slaves/msd/core/drive_table.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"
#include "driveline/slaves/msd/sercos/servoone_idns.hpp"

namespace driveline::slaves::msd::sercos {
namespace {

using namespace std::chrono_literals;
using wire::AlState;
using wire::SoeElement;
using wire::SoeError;

constexpr std::uint16_t kP = 0x8000;  ///< first raw number of the P parameters

template <typename... Numbers>
constexpr std::array<std::uint16_t, sizeof...(Numbers)> idns_of(Numbers... numbers) {
  return {static_cast<std::uint16_t>(numbers)...};
}

const DictionaryTable& servoone_table() {
  static const DictionaryTable kTable({drive_rows(Variant::kServoOne)}, kValue.end());
  return kTable;
}

class SilentBus final : public DriveBus {
 public:
  void report(const FaultMessage&) noexcept override {}
  [[nodiscard]] bool cause_persists(Fault) const noexcept override { return false; }
  void parameters_replaced() override {}
};

MsdParameters servoone() {
  MsdParameters parameters;
  parameters.variant = Variant::kServoOne;
  return parameters;
}

/// A drive whose commands start and never end by themselves.
class CoreIdns final : public ServoOneDictionary {
 public:
  using ServoOneDictionary::ServoOneDictionary;

 private:
  SoeAnswer<void> start_command(std::uint8_t, wire::Idn) override { return {}; }
};

/// Two drives; the tests use the second.
class ServoOneDictionaryTest : public testing::Test {
 protected:
  ServoOneDictionaryTest() {
    for (auto* drive : {&other, &core}) {
      drive->restart();
      drive->advance(0ms);
      drive->advance(5ms);
    }
  }

  static const IdnRow& row(std::uint16_t idn) { return *servoone_idns().find({idn}); }
  SoeAnswer<std::vector<std::byte>> read(std::uint16_t idn, SoeElement element = SoeElement::kValue) {
    return idns.read_element({1, {idn}, element, AlState::kPreOp});
  }
  double number(std::uint16_t idn) {
    return number_from_raw(row(idn).attribute, raw_from_bytes(row(idn).attribute, read(idn).value()));
  }
  SoeAnswer<void> write(std::uint16_t idn, double value, AlState phase = AlState::kPreOp) {
    std::vector<std::byte> bytes(row(idn).attribute.element_size());
    raw_to_bytes(raw_from_number(row(idn).attribute, value), bytes);
    return idns.write_element({1, {idn}, SoeElement::kValue, phase}, bytes);
  }
  SoeAnswer<void> write_text(std::uint16_t idn, std::string_view text) {
    std::vector<std::byte> bytes = {static_cast<std::byte>(text.size()), std::byte{0},
                                    static_cast<std::byte>(text.size()), std::byte{0}};
    for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
    return idns.write_element({1, {idn}, SoeElement::kValue, AlState::kPreOp}, bytes);
  }
  std::string text(std::uint16_t idn, SoeElement element = SoeElement::kValue) {
    const auto bytes = read(idn, element).value();
    std::string content;
    for (std::size_t i = 4; i < bytes.size(); ++i) content += static_cast<char>(bytes[i]);
    return content;
  }
  wire::SoeAttribute attribute(std::uint16_t idn) {
    return wire::SoeAttribute::decode(read(idn, SoeElement::kAttribute).value()).value();
  }
  /// The number in an object of the core.
  double object(std::uint16_t index, std::uint8_t subindex = 0) {
    const auto& entry = *servoone_table().find(index, subindex);
    return slaves::number_from_raw(entry.type, core.complete_values().raw(entry));
  }
  void set_object(std::uint16_t index, std::uint8_t subindex, double value) {
    const auto& entry = *servoone_table().find(index, subindex);
    core.process_values().set_raw(entry.slot, slaves::raw_from_number(entry.type, value));
  }

  SilentBus bus;
  DriveCore other{servoone(), servoone_table(), bus};
  DriveCore core{servoone(), servoone_table(), bus};
  CoreIdns idns{{&other, &core}};
};

TEST(ServoOneCoreValues, AreObjectsOfTheCoreInEveryVariant) {
  EXPECT_EQ(core_values().size(), 96U) << "docs/sercos.md says so";
  for (const auto& variant : kVariants) {
    const DictionaryTable table({drive_rows(variant.variant)}, kValue.end());
    const CoreLinks links(table);
    for (const auto& value : core_values()) {
      const auto idn = value.idn.text();
      SCOPED_TRACE(std::string(idn.data(), idn.size()));
      const auto* row = servoone_idns().find(value.idn);
      const auto* entry = table.find(value.index, value.subindex);
      ASSERT_NE(row, nullptr);
      ASSERT_NE(entry, nullptr);
      EXPECT_EQ(links.of(*row).value, &value);
      EXPECT_EQ(links.of(*row).entry, entry);
      EXPECT_FALSE(value.source.empty());
      EXPECT_EQ(is_string(entry->type), row->attribute.list);
      EXPECT_EQ(value.conversion == CoreConversion::kText, row->attribute.list);
      if (row->attribute.list) {
        EXPECT_EQ(entry->string_length, row->capacity);
        continue;
      }
      EXPECT_EQ(entry->slot, value.slot);
      EXPECT_EQ(entry->type, value.type);
      EXPECT_TRUE(!value.own_default || !is_read_only(row->attribute));
      const bool writable_object = (entry->access & access::kWriteConfiguring) != 0;
      // The core only shows these two data of the motor; a master may write them, without effect.
      const bool shown = value.index == 0x2000 + 461 || value.index == 0x2000 + 463;
      EXPECT_TRUE(is_read_only(row->attribute) || writable_object != shown);
    }
  }
}

/// No P parameter that the core has under its number is stored twice.
TEST(ServoOneCoreValues, IncludeEveryParameterThatTheCoreHas) {
  const CoreLinks links(servoone_table());
  for (const auto& row : servoone_idns().rows()) {
    const auto parameter = parameter_number(row.idn);
    if (row.idn.raw < kP) continue;
    const auto* entry = servoone_table().find(static_cast<std::uint16_t>(0x2000 + parameter), 0);
    if (entry == nullptr || row.attribute.list) continue;
    EXPECT_EQ(links.of(row).entry, entry) << row.name;
    EXPECT_NE(links.of(row).value, nullptr) << row.name;
  }
  EXPECT_EQ(links.of(*servoone_idns().find({76})).entry, nullptr) << "a setting of SERCOS alone";
}

TEST(ServoOneCoreValues, SNumbersAreParametersFrom10000On) {
  struct Case {
    std::uint16_t parameter;
    std::uint16_t raw;
  };
  for (const auto& c : {Case{10001, 1}, Case{10104, 104}, Case{14095, 4095}, Case{360, kP + 360}, Case{4095, 0x8FFF}}) {
    EXPECT_EQ(parameter_number({c.raw}), c.parameter);
    EXPECT_EQ(idn_of_parameter(c.parameter), wire::Idn{c.raw});
  }
  for (const std::uint16_t none : idns_of(4096, 9999, 14096, 65535)) EXPECT_EQ(idn_of_parameter(none), std::nullopt);
}

/// Numbers of an IDN, and of the object with the same value: calculated by hand from the units of both.
TEST_F(ServoOneDictionaryTest, OneValueHasTwoAddresses) {
  struct Case {
    std::uint16_t idn;
    double idn_number;
    std::uint16_t index;
    std::uint8_t subindex;
    double object_number;
  };
  for (const auto& c : {
           Case{kP + 360, 2150, 0x2000 + 360, 0, 2150},    // 1/min
           Case{104, 318, 0x2000 + 360, 0, 3180},          // 3.18 * 1000/min
           Case{100, 345, 0x2000 + 320, 0, 0.0345},        // 0.0345 Nm min
           Case{101, 125, 0x2000 + 321, 0, 12.5},          // 12.5 ms
           Case{296, 335, 0x2000 + 375, 0, 33.5},          // 33.5 %
           Case{348, 478, 0x2000 + 376, 0, 47.8},          // 47.8 %
           Case{124, 1234567, 0x2000 + 745, 0, 123.4567},  // 1/min
           Case{36, -1200300, 0x60FF, 0, -1200300},        // SPEED
           Case{37, 77000, 0x60B1, 0, 77000},              //
           Case{41, 555000, 0x6099, 1, 555000},            //
           Case{kP + 3031, 66000, 0x6099, 2, 66000},       //
           Case{42, 44000, 0x609A, 0, 44000},              // ACC
           Case{kP + 2242, 88000, 0x6085, 0, 88000},       //
           Case{260, 99000, 0x6083, 0, 99000},             //
           Case{259, 8800000, 0x6081, 0, 8800000},         //
           Case{47, -98765432, 0x607A, 0, -98765432},      // POS
           Case{57, 4321, 0x6067, 0, 4321},                //
           Case{159, 765432, 0x6065, 0, 765432},           //
           Case{80, -305, 0x6071, 0, -305},                // 0.1 % of the rated torque
           Case{81, 41, 0x60B2, 0, 41},                    //
           Case{92, 1750, 0x6072, 0, 1750},                //
           Case{113, 4500, 0x6080, 0, 4500},               // 1/min
           Case{kP + 370, 4, 0x2000 + 370, 0, 4},          // two bytes, and one
           Case{kP + 2261, 33, 0x6098, 0, 33},             //
           Case{kP + 2219, -1, 0x605B, 0, -1},             // an alias
           Case{kP + 213, 35.5, 0x2000 + 213, 0, 35.5},    //
           Case{kP + 460, 1.75, 0x2000 + 460, 0, 1.75},    // Nm
       }) {
    SCOPED_TRACE(c.idn);
    const double before = number(c.idn);
    EXPECT_NE(before, c.idn_number) << "a change can be seen";
    ASSERT_TRUE(write(c.idn, c.idn_number));
    EXPECT_FLOAT_EQ(static_cast<float>(object(c.index, c.subindex)), static_cast<float>(c.object_number));
    EXPECT_EQ(number(c.idn), c.idn_number);
    set_object(c.index, c.subindex, 0);
    EXPECT_EQ(number(c.idn), 0);
    set_object(c.index, c.subindex, c.object_number);
    EXPECT_EQ(number(c.idn), c.idn_number);
  }
}

/// Values that the drive alone writes.
TEST_F(ServoOneDictionaryTest, ActualValuesAreThoseOfTheCore) {
  struct Case {
    std::uint16_t index;
    std::uint8_t subindex;
    double object_number;
    std::uint16_t idn;
    double idn_number;
  };
  ASSERT_TRUE(write(kP + 457, 2.5));
  core.complete_publication();
  for (const auto& c : {
           Case{0x6064, 0, -123456, 51, -123456},          // POS
           Case{0x606C, 0, 654321, 40, 654321},            // SPEED
           Case{0x6077, 0, -712, 84, -712},                // 0.1 %
           Case{0x6078, 0, 480, 389, 12},                  // 48 % of 2.5 A in 0.1 A
           Case{0x60F4, 0, 321, 189, 321},                 //
           Case{0x60F4, 0, -87, kP + 279, -87},            //
           Case{0x60BA, 0, 5000, 130, 5000},               // probe 1, positive
           Case{0x60BB, 0, 5001, 131, 5001},               // probe 1, negative
           Case{0x60BC, 0, 5002, 132, 5002},               // probe 2, positive
           Case{0x60BD, 0, 5003, 133, 5003},               // probe 2, negative
           Case{0x2000 + 410, 0, 563.6, 380, 564},         // V
           Case{0x2000 + 410, 0, 563.5, kP + 410, 563.5},  // V
           Case{0x2000 + 701, 1, 71.3, 383, 713},          // 0.1 degrees Celsius
           Case{0x2000 + 701, 0, 12.5, kP + 3007, 12.5},   // %
           Case{0x2000 + 121, 0, 0x10081, kP + 121, 0x10081},
       }) {
    SCOPED_TRACE(c.idn);
    set_object(c.index, c.subindex, c.object_number);
    EXPECT_EQ(number(c.idn), c.idn_number);
  }
}

/// Actual values that the bus does not send wait in the core until they are read.
TEST_F(ServoOneDictionaryTest, WhatIsReadIsOfTheLastCycle) {
  core.send(ValueGroup::kPosition);
  set_object(0x606C, 0, 777);
  core.advance(10ms);
  EXPECT_EQ(idns.raw(1, row(40)), 777U) << "process data leave it";
  EXPECT_EQ(number(40), 0) << "the axis stands";
}

TEST_F(ServoOneDictionaryTest, TextsAreThoseOfTheCore) {
  ASSERT_TRUE(write_text(kP + 3, "Saw, left"));
  EXPECT_EQ(core.process_values().text(servoone_table().find(0x2003, 0)->slot), "Saw, left");
  EXPECT_EQ(text(kP + 3), "Saw, left");
  ASSERT_TRUE(write_text(141, "Motor 7"));
  EXPECT_EQ(text(141), "Motor 7") << "a text of SERCOS alone";
}

TEST_F(ServoOneDictionaryTest, TheCoreActsOnWrittenValues) {
  ASSERT_TRUE(write(104, 120, AlState::kOp));
  core.advance(10ms);
  EXPECT_NEAR(core.motion().settings().controller.position_gain_per_s, 20.0, 1e-5) << "1200 1/min";
  core.raise(Fault::kEncoder);
  ASSERT_TRUE(core.fault());
  core.advance(3000ms);
  ASSERT_TRUE(write(kP + 153, 1, AlState::kOp));
  EXPECT_EQ(number(kP + 153), 0);
  EXPECT_FALSE(core.fault());
}

/// The core's own rules refuse a value that the table of IDNs allows, and change nothing.
TEST_F(ServoOneDictionaryTest, TheCoreRefusesWhatItCannotDo) {
  struct Case {
    std::uint16_t idn;
    double value;
    SoeError error;
  };
  for (const auto& c : {
           Case{kP + 379, 1, SoeError::kValueTooLarge},  // 16 more bits of position
           Case{kP + 450, 2, SoeError::kValueTooLarge},  // the only type of motor is 1
           Case{259, 0, SoeError::kValueTooSmall},       // 6081h is 1 at least
           Case{113, -5, SoeError::kValueTooSmall},      // 6080h has no sign
           Case{kP + 2261, 0x7FFF, SoeError::kValueTooLarge},
           Case{kP + 120, 65664, SoeError::kValueTooLarge},  // above the maximum of the IDN
           Case{kP + 120, 128, SoeError::kValueInvalid},     // ISDSH cannot be inverted
       }) {
    SCOPED_TRACE(c.idn);
    const double before = number(c.idn);
    const auto answer = write(c.idn, c.value);
    ASSERT_FALSE(answer);
    EXPECT_EQ(answer.error(), c.error);
    EXPECT_EQ(number(c.idn), before);
  }
}

/// Every value that can be read can be written where its phase allows it, and is the same then.
TEST_F(ServoOneDictionaryTest, WhatIsReadCanBeWritten) {
  idns.write_defaults_to_core(1);
  std::size_t written = 0;
  for (const auto& row : servoone_idns().rows()) {
    if (row.attribute.command) continue;
    SCOPED_TRACE(row.name);
    const auto value = read(row.idn.raw);
    ASSERT_TRUE(value);
    const auto answer = idns.write_element({1, row.idn, SoeElement::kValue, AlState::kPreOp}, *value);
    if (row.attribute.pre_op_protected) {
      EXPECT_FALSE(answer);
      continue;
    }
    EXPECT_TRUE(answer) << (answer ? "" : wire::to_text(answer.error()));
    EXPECT_EQ(read(row.idn.raw), value);
    ++written;
  }
  EXPECT_EQ(written, 334U) << "of 479, 134 never and S-0-0128 in phase 3 alone; ten others are commands";
}

/// Values of SERCOS with a default of their own (SERCOS manual 484, 485; as the table of IDNs has them).
TEST_F(ServoOneDictionaryTest, DefaultsOfSercosReplaceThoseOfCia402) {
  EXPECT_EQ(object(0x2000 + 159), 5);
  idns.write_defaults_to_core(1);
  EXPECT_EQ(object(0x2000 + 159), 6);
  EXPECT_EQ(object(0x2000 + 165), 8);
  EXPECT_EQ(object(0x2000 + 370), 3);
  EXPECT_EQ(object(0x6099, 1), 230000);
  EXPECT_EQ(object(0x6072), 3000);
  EXPECT_EQ(object(0x2000 + 745), 10) << "100000 * 0.0001 1/min";
  EXPECT_EQ(number(113), object(0x6080)) << "the motor's own speed stays";
  EXPECT_EQ(number(kP + 457), object(0x2000 + 457)) << "the motor's own current stays";
  EXPECT_EQ(
      slaves::number_from_raw(esi::DataType::kUnsigned16, other.process_values().raw(kValue.control_location.number)),
      5)
      << "the other drive";
}

/// Unit and attribute of one IDN of each kind of data.
struct ShownUnit {
  std::uint16_t idn;
  const char* unit;
  unsigned decimals;
  unsigned conversion;
};

class ServoOneUnits : public ServoOneDictionaryTest {
 protected:
  void expect_units(const std::vector<ShownUnit>& units) {
    for (const auto& c : units) {
      SCOPED_TRACE(c.idn);
      EXPECT_EQ(text(c.idn, SoeElement::kUnit), c.unit);
      EXPECT_EQ(attribute(c.idn).decimals, c.decimals);
      EXPECT_EQ(attribute(c.idn).conversion_factor, c.conversion);
    }
  }
};

TEST_F(ServoOneUnits, FollowTheWeightingInForce) {
  const std::vector<ShownUnit> rotary = {{51, "deg", 4, 1}, {36, "1/min", 4, 1}, {260, "rad/s2", 3, 1},
                                         {80, "%", 1, 1},   {383, "degC", 1, 1}, {kP + 279, "deg", 4, 1},
                                         {92, "%", 1, 1},   {101, "ms", 1, 1},   {108, "%", 2, 1}};
  expect_units(rotary);
  struct Setting {
    std::uint16_t idn;
    double value;
  };
  for (const auto& c : {Setting{76, 0x49}, Setting{77, 25}, Setting{78, -6}, Setting{44, 0x39}, Setting{45, 3},
                        Setting{46, -2}, Setting{160, 0x01}, Setting{86, 0x12}}) {
    ASSERT_TRUE(write(c.idn, c.value));
  }
  expect_units(rotary);
  ASSERT_TRUE(idns.take_weighting(1)) << "the change to phase 3";
  expect_units({{51, "m", 6, 25},
                {kP + 743, "m", 6, 25},
                {36, "in/s", 2, 3},
                {260, "m/s2", 6, 1},
                {80, "in lbf", 2, 1},
                {383, "degC", 1, 1},
                {101, "ms", 1, 1}});
  EXPECT_EQ(idns.weighting(0).unit(WeightedData::kPosition).text.view(), "deg") << "the other drive";
  const auto positions = std::count_if(servoone_idns().rows().begin(), servoone_idns().rows().end(),
                                       [](const auto& row) { return row.unit == "POS"; });
  std::ptrdiff_t metres = 0;
  for (const auto& each : servoone_idns().rows()) {
    if (!each.unit.empty() && text(each.idn.raw, SoeElement::kUnit) == "m") ++metres;
  }
  EXPECT_EQ(metres, positions);
  EXPECT_EQ(attribute(419).decimals, 0) << "S-0-0419 has the unit of positions and is a word of bits";
}

TEST_F(ServoOneUnits, AreTextsOfTheUserWithoutWeighting) {
  for (const std::uint16_t idn : idns_of(76, 44, 160)) ASSERT_TRUE(write(idn, 0));
  ASSERT_TRUE(write_text(kP + 284, "teeth"));
  ASSERT_TRUE(write_text(kP + 290, "teeth/s2"));
  EXPECT_EQ(text(51, SoeElement::kUnit), "deg");
  ASSERT_TRUE(idns.take_weighting(1));
  expect_units({{51, "teeth", 0, 1}, {36, "incr/s", 0, 1}, {260, "teeth/s2", 0, 1}, {80, "%", 1, 1}});
}

TEST_F(ServoOneUnits, ThatContradictAreNotTaken) {
  ASSERT_TRUE(write(76, 1));
  EXPECT_FALSE(idns.take_weighting(1)) << "linear positions with rotary speeds";
  EXPECT_EQ(text(51, SoeElement::kUnit), "deg");
  EXPECT_EQ(idns.weighting_settings(1).position_type, 1);
  EXPECT_EQ(idns.weighting_settings(0).position_type, 2);
}

/// All settings, each with a number of its own.
TEST_F(ServoOneUnits, HaveTheirSettingsInTheseIdns) {
  std::uint16_t value = 3;
  std::vector<double> expected;
  for (const std::uint16_t idn :
       idns_of(76, 77, 78, 79, 103, 294, 55, 44, 45, 46, 43, 160, 161, 162, 86, 93, 94, 85, 121, 122, 123)) {
    ASSERT_TRUE(write(idn, value)) << idn;
    expected.push_back(value++);
  }
  const auto s = idns.weighting_settings(1);
  EXPECT_THAT((std::vector<double>{double(s.position_type),
                                   double(s.position_factor),
                                   double(s.position_exponent),
                                   double(s.rotary_resolution),
                                   double(s.modulo),
                                   double(s.modulo_divisor),
                                   double(s.position_polarity),
                                   double(s.speed_type),
                                   double(s.speed_factor),
                                   double(s.speed_exponent),
                                   double(s.speed_polarity),
                                   double(s.acceleration_type),
                                   double(s.acceleration_factor),
                                   double(s.acceleration_exponent),
                                   double(s.torque_type),
                                   double(s.torque_factor),
                                   double(s.torque_exponent),
                                   double(s.torque_polarity),
                                   double(s.gear_input),
                                   double(s.gear_output),
                                   double(s.feed_um)}),
              testing::ElementsAreArray(expected));
  ASSERT_TRUE(write(94, -7));
  EXPECT_EQ(idns.weighting_settings(1).torque_exponent, -7);
}

/// Torques in 0.01 Nm of a motor with 2.5 Nm, behind a gear of 5 to 2 and in front of it.
TEST_F(ServoOneDictionaryTest, TorquesAreConvertedToPerMilleOfTheRatedTorque) {
  ASSERT_TRUE(write(kP + 460, 2.5));
  ASSERT_TRUE(write(121, 5));
  ASSERT_TRUE(write(122, 2));
  struct Case {
    unsigned type;
    double torque;
    double per_mille;
  };
  for (const auto& c : {Case{0x02, 125, 500}, Case{0x42, 125, 200}, Case{0x00, -333, -333}, Case{0x40, 271, 271}}) {
    SCOPED_TRACE(c.type);
    ASSERT_TRUE(write(86, c.type));
    ASSERT_TRUE(idns.take_weighting(1));
    ASSERT_TRUE(write(80, c.torque, AlState::kOp));
    EXPECT_EQ(object(0x6071), c.per_mille);
    EXPECT_EQ(number(80), c.torque);
  }
  ASSERT_TRUE(write(86, 2));
  ASSERT_TRUE(idns.take_weighting(1));
  EXPECT_EQ(write(80, 8192, AlState::kOp).error(), SoeError::kValueTooLarge) << "32768 per mille";
  ASSERT_TRUE(write(80, 8191, AlState::kOp)) << "32764 per mille";
}

TEST_F(ServoOneDictionaryTest, PolarityTurnsOneValueEach) {
  struct Case {
    std::uint16_t word;
    unsigned bits;
    std::uint16_t idn;
    std::uint16_t index;
  };
  for (const auto& c : {Case{55, 0x01, 47, 0x607A}, Case{55, 0x04, 51, 0x6064}, Case{43, 0x01, 36, 0x60FF},
                        Case{43, 0x02, 37, 0x60B1}, Case{43, 0x04, 40, 0x606C}, Case{85, 0x01, 80, 0x6071},
                        Case{85, 0x02, 81, 0x60B2}, Case{85, 0x04, 84, 0x6077}}) {
    for (const std::uint16_t word : idns_of(43, 55, 85)) ASSERT_TRUE(write(word, word == c.word ? c.bits : 0));
    ASSERT_TRUE(idns.take_weighting(1));
    core.complete_publication();
    for (const std::uint16_t idn : idns_of(36, 37, 40, 47, 51, 80, 81, 84)) {
      const auto* value = CoreLinks(servoone_table()).of(row(idn)).value;
      set_object(value->index, value->subindex, 1234);
      EXPECT_EQ(number(idn), idn == c.idn ? -1234 : 1234) << c.word << " " << c.bits << " " << idn;
      idns.set_raw(1, row(idn), raw_from_number(row(idn).attribute, -567));
      EXPECT_EQ(object(value->index), idn == c.idn ? 567 : -567);
    }
    EXPECT_EQ(CoreLinks(servoone_table()).of(row(c.idn)).value->index, c.index);
  }
  ASSERT_TRUE(write(85, 0));
  ASSERT_TRUE(write(55, 1));
  ASSERT_TRUE(idns.take_weighting(1));
  EXPECT_EQ(write(47, -2147483648.0, AlState::kOp).error(), SoeError::kValueTooLarge) << "turned, it is 2^31";
  idns.set_raw(1, row(47), raw_from_number(row(47).attribute, -2147483648.0));
  EXPECT_EQ(object(0x607A), 2147483647.0) << "process data are limited";
}

/// Weighted conversions of the core are those of the weighting: degrees of a load behind a gear of 7 to 3.
TEST_F(ServoOneDictionaryTest, WeightingIsForTheMotorOfTheCore) {
  ASSERT_TRUE(write(76, 0x42));
  ASSERT_TRUE(write(121, 7));
  ASSERT_TRUE(write(122, 3));
  ASSERT_TRUE(write(kP + 460, 1.25));
  ASSERT_TRUE(idns.take_weighting(1));
  EXPECT_EQ(idns.weighting(1).scaling().to_increments(3 * 3'600'000), 7 * (1 << 20));
  EXPECT_NEAR(idns.weighting(1).motor_torque_nm(), 1.25e-3, 1e-12);
}

TEST_F(ServoOneDictionaryTest, ProcessDataMoveWithoutAllocation) {
  if (!rt::RtGuard::available()) GTEST_SKIP() << "a sanitizer owns malloc; the guard counts nothing here";
  double sum = 0;
  rt::RtGuard::enter();
  for (int i = 0; i < 1000; ++i) {
    for (const std::uint16_t idn : idns_of(47, 36, 80, 145, 51)) {
      idns.set_raw(1, row(idn), static_cast<std::uint64_t>(std::int64_t{i}));
      sum += static_cast<double>(idns.raw(1, row(idn)));
    }
  }
  EXPECT_EQ(rt::RtGuard::leave().total(), 0U);
  EXPECT_EQ(sum, 5 * 999 * 500) << "five times the sum of 0 to 999";
}

/// A core with the profile SERCOS has objects of its own at 2000h + 10000 + n, in units and signs of SERCOS: they count
/// more than objects of CiA 402 with the same meaning.
TEST(ServoOneCores, OwnParametersOfSercosAreTheValuesOfTheirIdns) {
  auto rows = drive_rows(Variant::kServoOne);
  const EntryRow command{.index = 0x2000 + 10047,
                         .type = esi::DataType::kInteger32,
                         .access = access::kReadWrite,
                         .name = "Position command value",
                         .minimum = -5000};
  const EntryRow type{.index = 0x2000 + 10076, .type = esi::DataType::kUnsigned16, .access = access::kReadWrite};
  rows.push_back(command);
  rows.push_back(type);
  const DictionaryTable table({rows}, kValue.end());
  SilentBus bus;
  DriveCore core(servoone(), table, bus);
  core.restart();
  CoreIdns idns({&core});
  const auto write = [&](std::uint16_t idn, auto value) {
    return idns.write_element({0, {idn}, SoeElement::kValue, AlState::kPreOp}, bytes::to_le_bytes(value));
  };
  ASSERT_TRUE(write(76, std::uint16_t{0x42}));
  ASSERT_TRUE(write(55, std::uint16_t{1}));
  EXPECT_EQ(core.process_values().raw(*table.find(type.index, 0)), 0x42U);
  EXPECT_EQ(idns.weighting_settings(0).position_type, 0x42);
  ASSERT_TRUE(idns.take_weighting(0));
  ASSERT_TRUE(write(47, std::int32_t{-4321}));
  EXPECT_EQ(static_cast<std::int64_t>(core.process_values().raw(*table.find(command.index, 0))), -4321) << "not turned";
  EXPECT_EQ(core.process_values().get(kValue.target_position), 0);
  EXPECT_EQ(write(47, std::int32_t{-5001}).error(), SoeError::kValueTooSmall) << "the object's own minimum";
}

TEST(ServoOneCores, WithoutAnObjectAreRefused) {
  auto rows = drive_rows(Variant::kServoOne);
  rows.erase(std::remove_if(rows.begin(), rows.end(), [](const auto& row) { return row.index == 0x609A; }), rows.end());
  const DictionaryTable table({rows}, kValue.end());
  SilentBus bus;
  DriveCore core(servoone(), table, bus);
  EXPECT_THROW(CoreIdns({&core}), std::logic_error);
}

}  // namespace
}  // namespace driveline::slaves::msd::sercos

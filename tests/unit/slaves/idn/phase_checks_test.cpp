// What S-0-0127 and S-0-0128 check: a row per check, with settings that break it alone.
#include "driveline/slaves/msd/sercos/phase_checks.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <string>
#include <vector>

#include "driveline/bytes/endian.hpp"
#include "driveline/slaves/msd/core/drive_table.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"
#include "driveline/slaves/msd/sercos/servoone_idns.hpp"

namespace driveline::slaves::msd::sercos {
namespace {

using wire::AlState;
using wire::SoeElement;

constexpr std::uint16_t kParameterP = 0x8000;  ///< first raw number of the P parameters

const DictionaryTable& checked_table() {
  static const DictionaryTable kTable({drive_rows(Variant::kServoOne)}, kValue.end());
  return kTable;
}

class QuietBus final : public DriveBus {
 public:
  void report(const FaultMessage&) noexcept override {}
  [[nodiscard]] bool cause_persists(Fault) const noexcept override { return false; }
  void parameters_replaced() override {}
};

class CheckedIdns final : public ServoOneDictionary {
 public:
  using ServoOneDictionary::ServoOneDictionary;

 private:
  SoeAnswer<void> start_command(std::uint8_t, wire::Idn) override { return {}; }
};

/// A datum that a master writes in phase 2: a number, or a list.
struct Written {
  std::uint16_t idn;
  std::vector<std::uint32_t> words;
};

/// A drive in phase 2 with the defaults of SERCOS.
class PhaseRig {
 public:
  PhaseRig() {
    core_.restart();
    idns.write_defaults_to_core(0);
  }

  void write(const Written& datum) {
    const auto& row = *servoone_idns().find({datum.idn});
    std::vector<std::byte> bytes;
    const auto size = row.attribute.element_size();
    for (const auto word : datum.words) {
      const auto all = bytes::to_le_bytes(word);
      bytes.insert(bytes.end(), all.begin(), all.begin() + static_cast<std::ptrdiff_t>(size));
    }
    if (row.attribute.list) {
      const auto length = static_cast<std::byte>(bytes.size());
      bytes.insert(bytes.begin(), {length, std::byte{0}, length, std::byte{0}});
    }
    EXPECT_TRUE(idns.write_element({0, row.idn, SoeElement::kValue, AlState::kPreOp}, bytes)) << row.name;
  }
  std::vector<unsigned> list(std::uint16_t idn) {
    const auto bytes = idns.read_element({0, {idn}, SoeElement::kValue, AlState::kPreOp}).value();
    std::vector<unsigned> words;
    for (std::size_t i = 4; i < bytes.size(); i += 2) {
      words.push_back(bytes::load_le<std::uint16_t>(std::span(bytes).subspan(i)));
    }
    return words;
  }

 private:
  static MsdParameters parameters() {
    MsdParameters parameters;
    parameters.variant = Variant::kServoOne;
    return parameters;
  }
  QuietBus bus_;
  DriveCore core_{parameters(), checked_table(), bus_};

 public:
  CheckedIdns idns{{&core_}};
};

struct CheckCase {
  const char* what;
  std::vector<Written> written;
  std::vector<unsigned> cp2;  ///< S-0-0021
  std::vector<unsigned> cp3;  ///< S-0-0022
};

std::vector<CheckCase> check_cases() {
  constexpr std::uint16_t p = kParameterP;
  return {
      {"defaults", {}, {}, {}},
      {"unit cycle of two bus cycles", {{1, {4000}}, {2, {2000}}}, {}, {}},
      {"unit cycle of 1.5 bus cycles", {{1, {3000}}, {2, {2000}}}, {1}, {}},
      {"bus cycle of 250.5 us", {{1, {4008}}, {2, {501}}}, {1, 2}, {}},
      {"AT of 20 bytes", {{16, {51, 40, 84, 130, 131, 144}}}, {}, {}},
      {"AT of 22 bytes", {{16, {51, 40, 84, 130, 131, 144, 179}}}, {16}, {}},
      {"AT with a command value", {{16, {51, 47}}}, {16}, {}},
      {"AT with an unknown number", {{16, {4000}}}, {16}, {}},
      {"AT that is not in use", {{15, {4}}, {16, {51, 47}}}, {}, {}},
      {"MDT with an actual value", {{24, {36, 51}}}, {24}, {}},
      {"MDT of 22 bytes", {{24, {36, 37, 47, 258, 259, 80}}}, {24}, {}},
      {"MDT with one twice", {{24, {36, 37, 36}}}, {24}, {}},
      {"MDT that is not in use", {{15, {2}}, {24, {36, 37, 36}}}, {}, {}},
      {"signals", {{26, {11, 330}}, {328, {15, 0}}, {27, {405, p + 141}}, {329, {0, 15}}}, {}, {}},
      {"status signal of a position", {{26, {51}}, {328, {0}}}, {26}, {}},
      {"control signal of a diagnosis", {{27, {11}}, {329, {0}}}, {27}, {}},
      {"status signals without bits", {{26, {11, 12}}, {328, {3}}}, {328}, {}},
      {"control signals without bits", {{27, {405, 406}}, {329, {3}}}, {329}, {}},
      {"status bit beyond its datum", {{26, {11}}, {328, {16}}}, {328}, {}},
      {"status bit of 32", {{26, {p + 121}}, {328, {31}}}, {}, {}},
      {"control bit beyond its datum", {{27, {405}}, {329, {16}}}, {329}, {}},
      {"encoder 1 on another channel", {{p + 530, {2}}}, {32}, {32}},
      {"encoder 2 not set up", {{33, {0x04}}}, {33}, {33}},
      {"encoder 2 of a drive profile", {{34, {0x1C}}, {35, {0x14}}}, {34, 35}, {34, 35}},
      {"encoder 2 in use", {{32, {0x0C}}, {p + 531, {3}}, {p + 522, {3}}}, {}, {}},
      {"no position mode needs no encoder", {{32, {2}}, {p + 530, {3}}}, {}, {}},
      {"mode with the bit for the service channel", {{33, {0x4004}}}, {33}, {33}},
      {"spline with signals", {{p + 370, {2}}, {24, {47, p + 3055, p + 3056}}}, {}, {}},
      {"spline without signals", {{p + 370, {2}}, {24, {47, p + 3055}}}, {p + 370}, {p + 370}},
      {"spline in a preferred telegram",
       {{p + 370, {2}}, {15, {4}}, {24, {47, p + 3055, p + 3056}}},
       {p + 370},
       {p + 370}},
      {"spline with a drive profile",
       {{p + 370, {2}}, {24, {47, p + 3055, p + 3056}}, {33, {0x13}}},
       {p + 370},
       {p + 370}},
      {"spline without position mode", {{p + 370, {2}}, {32, {1}}}, {}, {}},
      {"linear speed of a rotary position", {{44, {1}}}, {44}, {}},
      {"linear position", {{76, {1}}}, {44, 160}, {}},
      {"reserved bits of the polarities", {{43, {0x10}}, {55, {0x20}}, {85, {8}}}, {43, 55, 85}, {}},
      {"gear that is not exact",
       {{76, {0x4A}}, {79, {4294967231}}, {121, {4294967291}}, {122, {4294967279}}},
       {121},
       {}},
  };
}

TEST(ServoOnePhaseChecks, FindWhatIsInvalidAndNothingElse) {
  for (const auto& c : check_cases()) {
    SCOPED_TRACE(c.what);
    PhaseRig rig;
    for (const auto& datum : c.written) rig.write(datum);
    EXPECT_EQ(check_phase(rig.idns, 0, 3), c.cp2.empty());
    EXPECT_EQ(rig.list(21), c.cp2);
    EXPECT_EQ(check_phase(rig.idns, 0, 4), c.cp3.empty());
    EXPECT_EQ(rig.list(22), c.cp3);
    for (const auto& datum : find_invalid({rig.idns, 0}, 3)) EXPECT_FALSE(datum.reason.empty());
  }
}

/// Every row of the table of checks is broken by one case at least, but for the interpolation, whose limits the table
/// of IDNs has.
TEST(ServoOnePhaseChecks, EachHasACase) {
  std::vector<bool> seen(phase_checks().size());
  for (const auto& c : check_cases()) {
    PhaseRig rig;
    for (const auto& datum : c.written) rig.write(datum);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      seen[i] = seen[i] || phase_checks()[i].broken({rig.idns, 0});
    }
  }
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const auto& check = phase_checks()[i];
    const bool limited = check.idn.raw == kParameterP + 370 && check.source == "manual 888";
    EXPECT_EQ(seen[i], !limited) << check.reason;
    EXPECT_FALSE(check.source.empty());
  }
}

TEST(ServoOnePhaseChecks, AnInterpolationThatDoesNotExistIsInvalid) {
  PhaseRig rig;
  const auto& row = *servoone_idns().find({kParameterP + 370});
  for (const unsigned type : {0U, 5U}) {
    rig.idns.set_raw(0, row, type);  // as 60C0h of the core can set it
    EXPECT_FALSE(check_phase(rig.idns, 0, 3));
    EXPECT_FALSE(check_phase(rig.idns, 0, 4));
    EXPECT_EQ(rig.list(21), std::vector<unsigned>{kParameterP + 370});
    EXPECT_EQ(rig.list(22), std::vector<unsigned>{kParameterP + 370});
  }
}

TEST(ServoOnePhaseChecks, ListsAreEmptyAfterAGoodCheck) {
  PhaseRig rig;
  rig.write({44, {1}});
  EXPECT_FALSE(check_phase(rig.idns, 0, 3));
  EXPECT_EQ(rig.list(21).size(), 1U);
  rig.write({44, {2}});
  EXPECT_TRUE(check_phase(rig.idns, 0, 3));
  EXPECT_TRUE(rig.list(21).empty());
}

TEST(ServoOnePhaseChecks, ListsNameWhatIsChecked) {
  PhaseRig rig;
  const auto cp2 = rig.list(18);
  EXPECT_THAT(cp2,
              testing::ElementsAre(1, 2, 16, 24, 26, 27, 32, 33, 34, 35, 43, 44, 45, 46, 55, 76, 77, 78, 79, 85, 86, 93,
                                   94, 103, 121, 122, 123, 160, 161, 162, 208, 328, 329, kParameterP + 370));
  EXPECT_THAT(rig.list(19), testing::ElementsAre(32, 33, 34, 35, kParameterP + 370));
  EXPECT_TRUE(rig.list(23).empty());
}

}  // namespace
}  // namespace driveline::slaves::msd::sercos

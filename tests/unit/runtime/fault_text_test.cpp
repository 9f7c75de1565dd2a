// Faults as users write them in the line description and on the command line, and errors in them.
#include "driveline/runtime/config/fault_text.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

#include "driveline/runtime/config/line_config.hpp"

namespace driveline::runtime {
namespace {

using namespace std::chrono_literals;
using slaves::Fault;
using slaves::FaultKind;
using testing::HasSubstr;

const std::vector<std::string> kNames = {"x", "y", "z"};

struct FaultText : testing::Test {
  slaves::Wiring wiring = slaves::Wiring::line(3);
  FaultPlaces places{kNames, wiring};

  Fault parsed(std::string_view text) {
    const auto fault = parse_fault(text, places);
    if (!fault) throw std::runtime_error(describe(fault.error()));
    return *fault;
  }
  std::string error_of(std::string_view text) {
    const auto fault = parse_fault(text, places);
    return fault ? "" : describe(fault.error());
  }
};

TEST_F(FaultText, EveryParameterArrives) {
  const auto corrupt = parsed("corrupt way=back count=0x10 chance=0.25 seed=7 bits=3 for_ms=1.5");
  EXPECT_EQ(corrupt.kind, FaultKind::kCorrupt);
  EXPECT_EQ(corrupt.direction, slaves::FaultDirection::kBack);
  EXPECT_EQ(corrupt.count, 16U);
  EXPECT_EQ(corrupt.chance, 0.25);
  EXPECT_EQ(corrupt.seed, 7U);
  EXPECT_EQ(corrupt.bits, 3U);
  EXPECT_EQ(corrupt.duration, 1500us);
  const auto refuse = parsed("  refuse-transition\tslave=z state=SAFEOP code=0x001D ");
  EXPECT_EQ(refuse.slave, 2);
  EXPECT_EQ(refuse.state, wire::AlState::kSafeOp);
  EXPECT_EQ(refuse.code, wire::AlStatusCode::kInvalidOutputConfiguration);
  EXPECT_EQ(refuse.duration, 0ns);
  EXPECT_EQ(parsed("slow-transition slave=1 time_us=2500").time, 2500us);
}

TEST_F(FaultText, ACableIsNamedByItsPortOrByBothSlaves) {
  EXPECT_EQ(parsed("cable-break slave=x port=1").port, 1);
  EXPECT_EQ(parsed("cable-break slave=y to=z").port, 1);
  EXPECT_EQ(parsed("cable-break slave=y to=x").port, 0);
  EXPECT_EQ(error_of("cable-break slave=x"), "\"cable-break\" needs either port or to");
  EXPECT_EQ(error_of("cable-break slave=x port=1 to=y"), "\"cable-break\" needs either port or to");
  EXPECT_EQ(error_of("cable-break slave=x to=z"), "there is no cable between \"x\" and \"z\"");
  EXPECT_EQ(error_of("cable-break slave=z port=1"), "no cable is connected to port 1 of \"z\"");
}

TEST_F(FaultText, WhatIsWrongIsSaid) {
  EXPECT_THAT(error_of(""), HasSubstr("is not a kind of fault; the kinds are drop, delay"));
  EXPECT_THAT(error_of("dorp"), HasSubstr("\"dorp\" is not a kind of fault"));
  EXPECT_EQ(error_of("drop fast"), "\"fast\": KEY=VALUE is expected");
  EXPECT_EQ(error_of("drop speed=1"),
            "\"speed\" is unknown; the keys of \"drop\" are [way], [count], [chance], [seed], [for_ms]");
  EXPECT_EQ(error_of("drop slave=x"), "slave is not a key of \"drop\"; its keys are [way], [count], [chance], [seed]");
  EXPECT_EQ(error_of("power-off"), "\"power-off\" needs slave: name or position of a slave");
  EXPECT_EQ(error_of("power-off slave=q"), "slave there is no slave \"q\" among the 3");
  EXPECT_EQ(error_of("power-off slave=3"), "slave there is no slave \"3\" among the 3");
  EXPECT_EQ(error_of("drop count=0"), "count is \"0\", 1 to 4294967295 is expected");
  EXPECT_EQ(error_of("drop count=-1"), "count is \"-1\", 1 to 4294967295 is expected");
  EXPECT_EQ(error_of("drop chance=nan"), "chance is \"nan\", 0 to 1 is expected");
  EXPECT_EQ(error_of("drop way=up"), "way is \"up\", out or back is expected");
  EXPECT_EQ(error_of("drop for_ms=0"), "for_ms is \"0\", 0.001 to 86400000 is expected");
  EXPECT_EQ(error_of("delay time_us=1e9"), "time_us is \"1e9\", 1 to 60000000 is expected");
  EXPECT_EQ(error_of("refuse-transition slave=x state=SAVEOP"),
            "state is \"SAVEOP\", INIT, PREOP, BOOT, SAFEOP or OP is expected");
}

TEST_F(FaultText, HealingNeedsTheKindAndThePlace) {
  EXPECT_TRUE(parse_fault("slow-transition slave=y", places, false));
  EXPECT_TRUE(parse_fault("cable-break slave=y to=x", places, false));
  EXPECT_FALSE(parse_fault("slow-transition", places, false));
  EXPECT_FALSE(parse_fault("cable-break slave=y", places, false));
}

/// A complete fault of each kind with its required parameters.
std::string sample(const slaves::FaultKindRow& row) {
  std::string text(row.name);
  const auto add = [&](slaves::FaultParameter parameter, const char* word) {
    if (slaves::contains(row.needs, parameter)) text += word;
  };
  add(slaves::FaultParameter::kSlave, " slave=y");
  add(slaves::FaultParameter::kPort, " port=1");
  add(slaves::FaultParameter::kTime, " time_us=250");
  add(slaves::FaultParameter::kState, " state=OP");
  if (row.kind == FaultKind::kCableBreak) text += " to=z";
  return text + " for_ms=20";
}

TEST_F(FaultText, EveryKindIsWrittenAsItIsRead) {
  for (const auto& row : slaves::kFaultKinds) {
    const auto fault = parsed(sample(row));
    const auto text = fault_text(fault, places);
    const auto again = parsed(text);
    EXPECT_EQ(fault_text(again, places), text);
    EXPECT_EQ(again.kind, row.kind) << text;
    EXPECT_TRUE(again.same_place(fault)) << text;
    EXPECT_EQ(again.time, fault.time) << text;
    EXPECT_EQ(again.duration, fault.duration) << text;
  }
}

TEST_F(FaultText, TheLineFileKnowsEveryKindThatTheCommandLineKnows) {
  for (const auto& row : slaves::kFaultKinds) {
    // The words of the command line as keys of TOML.
    std::istringstream words(sample(row));
    std::string word;
    words >> word;
    std::string text =
        "[[slave]]\nname = \"x\"\n[[slave]]\nname = \"y\"\n[[slave]]\nname = \"z\"\n[[fault]]\nat_ms = 12.5\nkind = "
        "\"" +
        word + "\"\n";
    while (words >> word) {
      const auto equals = word.find('=');
      const auto value = word.substr(equals + 1);
      const bool number = value.find_first_not_of("0123456789.") == std::string::npos;
      text += word.substr(0, equals) + " = " + (number ? value : "\"" + value + "\"") + "\n";
    }
    const auto config = parse_line_config(text, "line.toml");
    ASSERT_TRUE(config) << describe(config.error()) << text;
    ASSERT_EQ(config->faults.size(), 1U);
    EXPECT_EQ(config->faults[0].at, 12500us);
    EXPECT_EQ(fault_text(config->faults[0].fault, places), fault_text(parsed(sample(row)), places));
  }
}

TEST_F(FaultText, HelpAndDocumentationNameEveryKindAndKey) {
  std::ifstream file(DRIVELINE_DOCS_DIR "/faults.md");
  std::ostringstream page;
  page << file.rdbuf();
  for (const auto& row : slaves::kFaultKinds) {
    EXPECT_THAT(fault_help(), HasSubstr(std::string(row.name)));
    EXPECT_THAT(page.str(), HasSubstr("| `" + std::string(row.name) + "` |"));
  }
  for (const auto& parameter : slaves::kFaultParameters) {
    EXPECT_THAT(fault_help(), HasSubstr(std::string(parameter.key)));
    EXPECT_THAT(page.str(), HasSubstr("| `" + std::string(parameter.key) + "` |"));
  }
}

TEST(FaultConfig, ErrorsNameFileAndLine) {
  const auto error_of = [](const std::string& fault) {
    const auto config = parse_line_config("[[slave]]\nname = \"x\"\n[[fault]]\n" + fault, "line.toml");
    return config ? "" : describe(config.error());
  };
  EXPECT_EQ(error_of("at_ms = 5\n"), "line.toml:3: [fault 1] kind: is missing, a string is expected");
  EXPECT_THAT(error_of("kind = \"dorp\"\n"),
              HasSubstr("line.toml:4: [fault 1] kind: \"dorp\" is not a kind of fault; the kinds are drop, "));
  EXPECT_EQ(error_of("kind = \"drop\"\nslave = \"x\"\n"),
            "line.toml:5: [fault 1] slave: is not a key of \"drop\"; its keys are [way], [count], [chance], [seed]");
  EXPECT_EQ(error_of("kind = \"power-off\"\nslave = \"q\"\n"),
            "line.toml:5: [fault 1] slave: there is no slave \"q\" among the 1");
  EXPECT_EQ(error_of("kind = \"power-off\"\nslave = true\n"),
            "line.toml:5: [fault 1] slave: is a boolean, a string or a number is expected");
  EXPECT_EQ(error_of("kind = \"power-off\"\n"),
            "line.toml:3: [fault 1]: \"power-off\" needs slave: name or position of a slave");
  EXPECT_EQ(error_of("kind = \"drop\"\nfor_ms = 0\n"),
            "line.toml:5: [fault 1] for_ms: is 0, 0.001 to 86400000 is expected");
  EXPECT_THAT(error_of("kind = \"drop\"\nhow = 3\n"), HasSubstr("line.toml:5: [fault 1] how: unknown key"));
}

}  // namespace
}  // namespace driveline::runtime

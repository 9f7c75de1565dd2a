// The real master and a slave with each persona: the line reaches OP, or its sentence says what is in the way, as
// docs/real_drives.md says.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdint>
#include <ostream>
#include <set>
#include <string>
#include <vector>

#include "driveline/runtime/line.hpp"
#include "driveline/slaves/persona/persona.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::bus_test {
namespace {

/// What the persona belongs to.
enum class Base : std::uint8_t {
  kAxis,      ///< a drive with an axis, free running
  kDcAxis,    ///< the same with [dc]
  kTerminal,  ///< a device with PDOs that only its EEPROM and its object dictionary describe
};

struct Row {
  const char* persona;      ///< as in the line description
  Base base = Base::kAxis;  ///< line that starts
  const char* keys = "";    ///< further keys of the [[slave]]
  const char* reason = "";  ///< part of the sentence with which the line does not start; empty: it reaches OP
};

const std::vector<Row>& rows() {
  static const std::vector<Row> kRows = {
      {"sync-type-read-only", Base::kDcAxis},
      {"sync-type-unsupported", Base::kDcAxis},
      {"sync-type-by-state", Base::kDcAxis},
      {"sync-cycle-read-only", Base::kDcAxis},
      {"sync-cycle-limited", Base::kDcAxis},
      {"no-sync-objects", Base::kDcAxis},
      {"no-interpolation-time"},
      {"interpolation-time-read-only"},
      {"interpolation-time-limited"},
      {"no-output-assignment", Base::kTerminal},
      {"no-output-assignment=0x08000000", Base::kTerminal},
      {"no-input-assignment", Base::kTerminal},
      {"no-input-assignment=0x06010001", Base::kTerminal},
      {"no-sync-manager-types", Base::kTerminal},
      {"fixed-assignment"},
      {"fixed-assignment=0x08000021", Base::kTerminal},
      {"fixed-mapping", Base::kTerminal},
      {"fixed-mapping", Base::kAxis, "", "needs 6040h"},
      {"mapping-limit=4"},
      {"mapping-limit=2", Base::kAxis, "", "0x06040042"},
      {"assignment-limit=3"},
      {"assignment-limit", Base::kAxis, "", "object 1C12h:00 aborted with 0x06040042"},
      {"overstated-assignment"},
      {"overstated-assignment=200", Base::kTerminal},
      {"no-complete-access", Base::kTerminal},
      {"four-byte-answers"},
      {"answers-without-size"},
      {"constant-counter"},
      {"constant-counter=0"},
      {"request-counter"},
      {"jumping-counter"},
      {"deaf-after-preop"},
      {"lost-requests"},
      {"late-answers"},
      {"requests-to-master"},
      {"messages-to-slave=0x1005"},
      {"emergencies"},
      {"emergencies=12"},
      {"stale-message"},
      {"safeop-refused-once"},
      {"slow-transitions=700"},
      {"slow-transitions=3500", Base::kAxis, "", "did not change within 3000 ms"},
      {"slow-transitions=3500", Base::kAxis,
       "timeouts = { preop_ms = 4000, safeop_ms = 4000, op_ms = 4000, back_to_init_ms = 4000 }"},
      {"needs-sync0", Base::kAxis, "", "0x0030"},
      {"needs-sync0", Base::kDcAxis},
      {"eeprom-for-application"},
      {"eeprom-types-swapped", Base::kTerminal},
      {"eeprom-types-zero", Base::kTerminal},
      {"eeprom-disabled", Base::kTerminal},
      {"eeprom-without-pdos", Base::kTerminal},
      {"eeprom-without-categories", Base::kTerminal, "", "0x0016"},
      {"eeprom-without-names", Base::kTerminal},
      {"eeprom-without-mailbox", Base::kTerminal},
      {"eeprom-reads-4-bytes", Base::kTerminal},
      {"slow-eeprom=2000", Base::kTerminal},
      {"slow-eeprom=120000", Base::kTerminal, "", "EEPROM interface stays busy"},
      {"clock-32-bit", Base::kDcAxis},
      {"no-clock"},
      {"no-clock", Base::kDcAxis, "", "has no distributed clock"},
      {"no-clock", Base::kDcAxis, "dc = { synchronous = false }", "no slave of the line has a distributed clock"},
      {"no-clock", Base::kDcAxis, "dc = { synchronous = false }\n[[slave]]\nname = \"y\"\n[[axis]]\nname = \"y\""},
      {"no-lrw", Base::kAxis, "", "0x0019"},
      {"no-lrw", Base::kAxis, "lrw = false"},
      {"few-fmmus=2"},
      {"few-fmmus", Base::kTerminal, "", "need 4 FMMUs, it has 3"},
      {"warning-bit"},
      {"follow-bit-always"},
      {"late-mode-display=80"},
  };
  return kRows;
}

void PrintTo(const Row& row, std::ostream* out) {
  *out << row.persona << " " << row.keys;
}

std::string line_text(const Row& row) {
  std::string text =
      "[line]\ncycle_us = 1000\n[realtime]\npolicy = \"degrade\"\n[telemetry]\nenabled = false\n"
      "[output]\nplots = false\n";
  if (row.base == Base::kDcAxis) text += "[dc]\n";
  text += std::string("[[slave]]\nname = \"x\"\npersona = \"") + row.persona + "\"\n" + row.keys + "\n";
  if (row.base == Base::kTerminal) return text + "esi = \"examples/terminals.xml\"\ndevice = \"MX4\"\n";
  return text +
         "[[axis]]\nname = \"x\"\nincrements_per_revolution = 65536\nmax_velocity = 100\nmax_acceleration = 1000\n";
}

/// Returns "" when the line has been in OP without a fault, else what is reported.
std::string start(const Row& row, const std::filesystem::path& output) {
  auto config = runtime::parse_line_config(line_text(row), "line.toml");
  if (!config) return describe(config.error());
  config->slaves[0].esi.reset();  // the master has to ask the device
  config->output.directory = output;
  runtime::Line::Options options;
  options.virtual_time = true;
  const auto line = runtime::Line::from_config(std::move(*config), options);
  if (!line) return describe(line.error());
  runtime::Line::RunSettings settings;
  settings.duration_s = 0.3;
  const auto report = (*line)->run(settings);
  if (!report) return describe(report.error());
  if (const auto failure = report->failure()) return describe(*failure);
  EXPECT_EQ(report->statistics.wkc_errors, 0U);
  // The terminal has 9 bytes in each direction.
  if (!report->process_data || report->process_data->bytes < 9) return "no process data";
  return report->state == "OP" ? "" : "state " + report->state;
}

class PersonaStart : public test::TemporaryDirectory, public testing::WithParamInterface<Row> {};

TEST_P(PersonaStart, ReachesOpOrSaysWhyNot) {
  const auto reported = start(GetParam(), directory / "out");
  if (*GetParam().reason == '\0') {
    EXPECT_EQ(reported, "");
  } else {
    EXPECT_THAT(reported, testing::HasSubstr(GetParam().reason));
  }
}

INSTANTIATE_TEST_SUITE_P(Each, PersonaStart, testing::ValuesIn(rows()), [](const auto& of_row) {
  std::string name = std::to_string(of_row.index) + "_" + of_row.param.persona;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '-' || c == '='; }, '_');
  return name;
});

TEST(PersonaStartRows, ContainEachPersona) {
  std::set<std::string> started;
  for (const auto& row : rows()) {
    const std::string word = row.persona;
    started.insert(word.substr(0, word.find('=')));
  }
  for (const auto& row : slaves::kPersonas) EXPECT_EQ(started.count(std::string(row.name)), 1U) << row.name;
}

}  // namespace
}  // namespace driveline::bus_test

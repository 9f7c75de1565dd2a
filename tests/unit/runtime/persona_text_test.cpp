#include "driveline/runtime/config/persona_text.hpp"

#include <gmock/gmock.h>

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "support/must.hpp"

namespace driveline::runtime {
namespace {

using slaves::PersonaKind;
using testing::HasSubstr;

constexpr auto kSlave = "[[slave]]\nname = \"x\"\n";

std::string error_of(const std::string& keys) {
  const auto config = parse_line_config(kSlave + keys, "line.toml");
  return config ? "" : describe(config.error());
}

TEST(PersonaText, EveryNameIsRead) {
  for (const auto& row : slaves::kPersonas) {
    const auto persona = must(parse_persona(row.name));
    EXPECT_EQ(persona->kind, row.kind);
    EXPECT_EQ(persona->value, row.value.standard);
  }
}

TEST(PersonaText, ValuesAreDecimalOrHexadecimal) {
  EXPECT_EQ(parse_persona("deaf-after-preop=450").value().value, 450U);
  EXPECT_EQ(parse_persona("no-output-assignment=0x08000021").value().value, 0x08000021U);
}

TEST(PersonaText, ErrorsSayWhatIsExpected) {
  const auto reason = [](const char* text) { return parse_persona(text).error().reason; };
  EXPECT_THAT(reason("no-clok"), HasSubstr("\"no-clok\" is not a persona; the personas are sync-type-read-only, "));
  EXPECT_THAT(reason("no-clok"), HasSubstr("; did you mean \"no-clock\"?"));
  EXPECT_EQ(reason("no-clock=3"), "\"no-clock\" has no value, \"=3\" is given");
  EXPECT_EQ(reason("few-fmmus=9"), "the value of \"few-fmmus\" is \"9\", 2 to 8 (FMMUs) is expected");
  EXPECT_EQ(reason("few-fmmus=3x"), "the value of \"few-fmmus\" is \"3x\", 2 to 8 (FMMUs) is expected");
  EXPECT_EQ(reason("messages-to-slave="),
            "the value of \"messages-to-slave\" is \"\", 0x0001 to 0xFFFF (station address) is expected");
}

TEST(PersonaText, HelpNamesEachWithItsSource) {
  const auto help = persona_help();
  for (const auto& row : slaves::kPersonas) {
    EXPECT_THAT(help, HasSubstr("\n  " + std::string(row.name) + "\n"));
    EXPECT_THAT(help, HasSubstr(std::string(row.source)));
  }
  EXPECT_THAT(help, HasSubstr("value: 1 to 60000 (ms); default 300"));
}

TEST(PersonaConfig, ListAndSingleName) {
  const auto list = must(parse_line_config(
      std::string(kSlave) +
          "persona = [\"no-clock\", \"emergencies=5\"]\n[[slave]]\nname = \"y\"\npersona = \"no-lrw\"\n",
      "line.toml"));
  ASSERT_EQ(list->slaves[0].personas.size(), 2U);
  EXPECT_EQ(list->slaves[0].personas[1].kind, PersonaKind::kEmergencies);
  EXPECT_EQ(list->slaves[0].personas[1].value, 5U);
  ASSERT_EQ(list->slaves[1].personas.size(), 1U);
  EXPECT_EQ(list->slaves[1].personas[0].kind, PersonaKind::kNoLrw);
}

TEST(PersonaConfig, ErrorsNameFileAndLine) {
  EXPECT_THAT(error_of("persona = \"no-clok\"\n"),
              HasSubstr("line.toml:3: [slave 1] persona: \"no-clok\" is not a persona; the personas are "));
  EXPECT_EQ(error_of("persona = [\"late-answers=20\", \"late-answers=30\"]\n"),
            "line.toml:3: [slave 1] persona: \"late-answers\" is there twice");
  EXPECT_EQ(
      error_of("persona = \"eeprom-types-zero\"\nsii_file = \"none.bin\"\n"),
      "line.toml:3: [slave 1] persona: \"eeprom-types-zero\" changes the EEPROM, whose content comes from sii_file");
  EXPECT_THAT(error_of("persona = 7\n"), HasSubstr("line.toml:3: [slave 1] persona: "));
}

TEST(PersonaConfig, SlavesOfTheLineHaveThem) {
  const auto config = must(parse_line_config(
      std::string(kSlave) +
          "alias = 9\npersona = [\"no-clock\", \"eeprom-without-mailbox\"]\n[[slave]]\nname = \"y\"\n",
      "line.toml"));
  const auto slaves = make_simulated_slaves(*config);
  ASSERT_EQ(slaves.size(), 2U);
  EXPECT_FALSE(slaves[0]->device().profile().distributed_clock);
  EXPECT_TRUE(slaves[1]->device().profile().distributed_clock);
  // The alias and the persona change the same EEPROM: word 4, and words 18h to 1Bh.
  const auto image = slaves[0]->esc().sii().image();
  EXPECT_EQ(image[8], std::byte{9});
  EXPECT_EQ(image[0x30], std::byte{0});
  EXPECT_NE(slaves[1]->esc().sii().image()[0x31], std::byte{0}) << "1000h, the mailbox of the drive";
}

}  // namespace
}  // namespace driveline::runtime

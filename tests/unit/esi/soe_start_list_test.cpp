#include "driveline/esi/soe_start_list.hpp"

#include <gmock/gmock.h>

namespace driveline::esi {
namespace {

/// A command as TwinCAT writes it; `changed` replaces one of its elements.
std::string command(const std::string& idn, const std::string& data, const std::string& rest = "",
                    const std::string& transition = "PS", const std::string& op_code = "3") {
  return "<InitCmd><Transition>" + transition +
         "</Transition><Comment><![CDATA[AT list]]></Comment><Timeout>0</Timeout>" + "<OpCode>" + op_code +
         "</OpCode><DriveNo>1</DriveNo><IDN>" + idn + "</IDN>" + (rest.empty() ? "<Elements>64</Elements>" : rest) +
         "<Attribute>0</Attribute><Data>" + data + "</Data></InitCmd>";
}

std::vector<std::byte> bytes_of(std::initializer_list<unsigned> values) {
  std::vector<std::byte> bytes;
  for (const auto value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

TEST(SoeStartList, IsReadWithAndWithoutWhatIsAroundIt) {
  const auto commands = command("16", "020002003300") + "\n" + command("0x804D", "04 00", "", "SO");
  for (const auto& text : {"<InitCmds>" + commands + "</InitCmds>", commands,
                           "<?xml version=\"1.0\"?><EtherCATConfig><Config><Slave><Mailbox><SoE><InitCmds>" + commands +
                               "</InitCmds></SoE></Mailbox></Slave></Config></EtherCATConfig>"}) {
    const auto list = read_soe_start_list(text);
    ASSERT_TRUE(list) << describe(list.error());
    EXPECT_TRUE(list->left_out.empty());
    ASSERT_EQ(list->entries.size(), 2U);
    const auto& first = list->entries[0];
    EXPECT_EQ(first.drive, 1);
    EXPECT_EQ(first.idn, 16);
    EXPECT_FALSE(first.before_op);
    EXPECT_EQ(first.data, bytes_of({2, 0, 2, 0, 0x33, 0}));
    EXPECT_EQ(first.comment, "AT list");
    EXPECT_EQ(list->entries[1].idn, 0x804D);
    EXPECT_TRUE(list->entries[1].before_op);
    EXPECT_EQ(list->entries[1].data, bytes_of({4, 0}));
  }
}

struct LeftOutCase {
  std::string command;
  const char* what;
  const char* why;
};

TEST(SoeStartList, SaysWhatItLeavesOut) {
  const std::vector<LeftOutCase> cases{
      {command("267", "0400"), "IDN 267 (AT list)", "it is a password"},
      {command("16", ""), "IDN 16 (AT list)", "it has no data in hex digits"},
      {command("16", "020"), "IDN 16 (AT list)", "it has no data in hex digits"},
      {command("16", "02", "", "IP"), "IDN 16 (AT list)", "it is for none of the transitions PS and SO"},
      {command("16", "02", "", "PS", "1"), "IDN 16 (AT list)", "it does not write"},
      {command("16", "02", "<Elements>4</Elements>"), "IDN 16 (AT list)", "it writes another element than the value"},
      {command("70000", "02"), "IDN 70000 (AT list)", "its IDN is no number from 0 to 65535"},
      {command("-1", "02"), "IDN -1 (AT list)", "its IDN is no number from 0 to 65535"},
      {"<InitCmd><Transition>PS</Transition><DriveNo>8</DriveNo><IDN>16</IDN><Data>02</Data></InitCmd>", "IDN 16",
       "its drive is no number from 0 to 7"},
  };
  for (const auto& c : cases) {
    const auto list = read_soe_start_list("<InitCmds>\n" + command("44", "0200") + "\n" + c.command + "</InitCmds>");
    ASSERT_TRUE(list) << describe(list.error());
    EXPECT_EQ(list->entries.size(), 1U) << c.why;
    ASSERT_EQ(list->left_out.size(), 1U) << c.why;
    EXPECT_EQ(list->left_out[0].line, 3U);
    EXPECT_EQ(list->left_out[0].what, c.what);
    EXPECT_EQ(list->left_out[0].why, c.why);
  }
}

TEST(SoeStartList, RefusesFilesThatAreNone) {
  EXPECT_THAT(describe(read_soe_start_list("<InitCmds><InitCmd>").error()), testing::StartsWith("is no XML at byte "));
  for (const auto* text : {"", "IDN;Data\n16;0200\n", "<InitCmds><InitCmd><Index>4096</Index></InitCmd></InitCmds>"}) {
    EXPECT_EQ(describe(read_soe_start_list(text).error()),
              "has no <InitCmd> with an <IDN>: the XML export of the SoE start-up list is expected")
        << text;
  }
}

}  // namespace
}  // namespace driveline::esi

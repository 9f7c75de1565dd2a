// [process_data], [[group]], [[copy]] and [slave.names] of a line description.
#include <gmock/gmock.h>

#include "driveline/runtime/config/line_config.hpp"

namespace driveline::runtime {
namespace {

using ecat_master::ImageLayout;
using testing::HasSubstr;

constexpr const char* kSlaves =
    "[[slave]]\nname = \"a\"\n[[slave]]\nname = \"b\"\n[[slave]]\nname = \"c\"\n";  // 6 lines

LineConfig parsed(const std::string& rest) {
  auto config = parse_line_config(kSlaves + rest, "line.toml");
  if (!config) throw std::runtime_error(describe(config.error()));
  return std::move(*config);
}

std::string refused(const std::string& rest) {
  const auto config = parse_line_config(kSlaves + rest, "line.toml");
  return config ? std::string{} : describe(config.error());
}

TEST(ProcessDataConfig, IsOneGroupInOneLrwByItself) {
  const auto config = parsed("");
  EXPECT_EQ(config.process_data.layout, ImageLayout::kOverlapped);
  EXPECT_TRUE(config.process_data.groups.empty());
  EXPECT_TRUE(config.process_data.copies.empty());
  EXPECT_EQ(exchange_divider(config, config.slaves[0]), 1U);
  EXPECT_FALSE(config.slaves[0].plan.lrw);
}

TEST(ProcessDataConfig, KnowsEveryLayout) {
  EXPECT_EQ(parsed("[process_data]\nlayout = \"overlapped\"\n").process_data.layout, ImageLayout::kOverlapped);
  EXPECT_EQ(parsed("[process_data]\nlayout = \"sequential\"\n").process_data.layout, ImageLayout::kSequential);
  EXPECT_EQ(parsed("[process_data]\nlayout = \"lrd_lwr\"\n").process_data.layout, ImageLayout::kSeparate);
  EXPECT_EQ(refused("[process_data]\nlayout = \"lrw\"\n"),
            "line.toml:8: [process_data] layout: is \"lrw\", one of \"overlapped\", \"sequential\", \"lrd_lwr\" is "
            "expected");
}

TEST(ProcessDataConfig, GathersSlavesThatNoGroupNamesInTheFirst) {
  const auto config = parsed(
      "[[group]]\nname = \"slow\"\nslaves = [\"b\"]\ndivider = 8\nphase = 3\nzero_outputs_after = 5\n"
      "[[group]]\nname = \"half\"\nslaves = [\"c\"]\ndivider = 2\n");
  const auto& groups = config.process_data.groups;
  ASSERT_EQ(groups.size(), 3U);
  EXPECT_EQ(groups[0].name, "others");
  EXPECT_EQ(groups[0].settings.divider, 1U);
  EXPECT_EQ(groups[1].name, "slow");
  EXPECT_EQ(groups[1].settings.divider, 8U);
  EXPECT_EQ(groups[1].settings.phase, 3U);
  EXPECT_EQ(groups[1].settings.bad_cycle_limit, 5U);
  EXPECT_EQ(groups[2].settings.divider, 2U);
  EXPECT_EQ(config.slaves[0].group, 0U);
  EXPECT_EQ(config.slaves[1].group, 1U);
  EXPECT_EQ(config.slaves[2].group, 2U);
  EXPECT_EQ(exchange_divider(config, config.slaves[1]), 8U);
}

TEST(ProcessDataConfig, MakesNoGroupOfOthersWhenThereAreNone) {
  const auto config =
      parsed("[[group]]\nname = \"one\"\nslaves = [\"c\", \"a\"]\n[[group]]\nname = \"two\"\nslaves = [\"b\"]\n");
  ASSERT_EQ(config.process_data.groups.size(), 2U);
  EXPECT_EQ(config.slaves[0].group, 0U);
  EXPECT_EQ(config.slaves[1].group, 1U);
  EXPECT_EQ(config.slaves[2].group, 0U);
}

TEST(ProcessDataConfig, CopiesKeepTheirPlaceInTheFile) {
  const auto config = parsed("[[copy]]\nfrom = \"a.In\"\n\nto = \"b.7000:01\"\n");
  ASSERT_EQ(config.process_data.copies.size(), 1U);
  const auto& copy = config.process_data.copies[0];
  EXPECT_EQ(copy.from, "a.In");
  EXPECT_EQ(copy.to, "b.7000:01");
  EXPECT_EQ(copy.from_place, "line.toml:8: [copy 1] from");
  EXPECT_EQ(copy.to_place, "line.toml:10: [copy 1] to");
}

TEST(ProcessDataConfig, EntriesGetNames) {
  const auto config = parsed("lrw = false\n[slave.names]\nposition_actual = \"6064h\"\n\"my lamp\" = \"Out 1\"\n");
  const auto& slave = config.slaves[2];
  EXPECT_EQ(slave.plan.lrw, false);
  ASSERT_EQ(slave.names.size(), 2U);
  EXPECT_EQ(slave.names[1].name, "position_actual");
  EXPECT_EQ(slave.names[1].object, "6064h");
  EXPECT_EQ(slave.names[1].place, "line.toml:9: [slave 3.names] position_actual");
  EXPECT_EQ(slave.names[0].name, "my lamp");
}

TEST(ProcessDataConfig, WrongValuesAreNamedWithTheirLine) {
  const std::string group = "[[group]]\nname = \"g\"\n";
  EXPECT_EQ(refused("[process_data]\nlay_out = \"lrw\"\n"),
            "line.toml:8: [process_data] lay_out: unknown key, expected one of: layout");
  EXPECT_EQ(refused(group), "line.toml:7: [group 1] slaves: names of slaves are expected, at least one");
  EXPECT_EQ(refused("[[group]]\nslaves = [\"a\"]\n"), "line.toml:7: [group 1] name: is missing, a string is expected");
  EXPECT_EQ(refused(group + "slaves = [\"z\"]\n"), "line.toml:9: [group 1] slaves: there is no [[slave]] named \"z\"");
  EXPECT_EQ(refused(group + "slaves = [\"a\", \"a\"]\n"), "line.toml:9: [group 1] slaves: \"a\" is there twice");
  EXPECT_EQ(refused(group + "slaves = [\"a\"]\n[[group]]\nname = \"h\"\nslaves = [\"a\"]\n"),
            "line.toml:12: [group 2] slaves: \"a\" is already in group \"g\"");
  EXPECT_EQ(refused(group + "slaves = [\"a\"]\n[[group]]\nname = \"g\"\nslaves = [\"b\"]\n"),
            "line.toml:11: [group 2] name: \"g\" is there twice");
  EXPECT_EQ(refused(group + "slaves = [\"a\"]\ndivider = 0\n"),
            "line.toml:10: [group 1] divider: is 0, 1 to 10000 is expected");
  EXPECT_EQ(refused(group + "slaves = [\"a\"]\ndivider = 4\nphase = 4\n"),
            "line.toml:11: [group 1] phase: is 4, 0 to 3 is expected");
  EXPECT_EQ(refused(group + "slaves = [\"a\"]\nlimit = 4\n"),
            "line.toml:10: [group 1] limit: unknown key, expected one of: divider, name, phase, slaves, "
            "zero_outputs_after");
  EXPECT_EQ(refused("[[group]]\nname = \"others\"\nslaves = [\"a\"]\n"),
            "line.toml:7: group: \"others\" is reserved for the slaves that are in no group");
  EXPECT_EQ(refused("[[copy]]\nfrom = \"a.In\"\n"), "line.toml:7: [copy 1] to: is missing, a string is expected");
  EXPECT_EQ(refused("[[copy]]\nfrom = \"z.In\"\nto = \"a.Out\"\n"),
            "line.toml:8: [copy 1] from: is \"z.In\", \"slave.object\" with the name of a [[slave]] is expected, for "
            "example \"a.6041h\"");
  EXPECT_THAT(refused("[[copy]]\nfrom = \"a\"\nto = \"b.Out\"\n"), HasSubstr("line.toml:8: [copy 1] from: is \"a\""));
  EXPECT_EQ(refused("[slave.names]\nx = 6064\n"),
            "line.toml:8: [slave 3.names] x: is an integer, a string is expected");
}

TEST(ProcessDataConfig, AxesAreNotLeftToCoast) {
  const std::string axis = "[[axis]]\nname = \"a\"\n[path]\nfile = \"p.csv\"\n";
  const std::string group = "[[group]]\nname = \"g\"\nslaves = [\"a\", \"b\"]\n";
  EXPECT_EQ(refused(axis + group + "zero_outputs_after = 4\n"),
            "line.toml:14: [group 1] zero_outputs_after: \"a\" has an axis: [bus] max_lost_cycles stops it, zero "
            "outputs would let it coast");
  EXPECT_EQ(refused(axis + "[bus]\nmax_lost_ms = 2\n" + group + "zero_outputs_after = 4\n"),
            "line.toml:16: [group 1] zero_outputs_after: \"a\" has an axis: [bus] max_lost_ms stops it, zero outputs "
            "would let it coast");
  EXPECT_EQ(refused(axis + group + "zero_outputs_after = 0\n"), "") << "never, for all";
}

TEST(ProcessDataConfig, DrivesInterpolateOnlyOverTimesTheyCanBeTold) {
  const std::string axis = "[[axis]]\nname = \"a\"\n[path]\nfile = \"p.csv\"\n";
  EXPECT_EQ(refused(axis + "[[group]]\nname = \"g\"\nslaves = [\"a\"]\ndivider = 3\n"),
            "line.toml:14: [group 1] divider: \"a\" would be exchanged every 375 us: object 60C2h of a drive holds 1 "
            "to 255 times a power of ten");
  EXPECT_EQ(refused(axis + "[line]\ncycle_us = 375\n"),
            "line.toml:12: [line] cycle_us: \"a\" would be exchanged every 375 us: object 60C2h of a drive holds 1 to "
            "255 times a power of ten");
  EXPECT_EQ(refused(axis + "[[group]]\nname = \"g\"\nslaves = [\"a\"]\ndivider = 2\n"), "");
}

}  // namespace
}  // namespace driveline::runtime

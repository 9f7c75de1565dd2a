#include "text/machine_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "text/wrapped_text.hpp"

namespace driveline::cli {
namespace {

std::vector<rt::RealtimeItem> sample() {
  return {
      {.name = "scheduler", .requested = "SCHED_FIFO 80", .effective = "SCHED_FIFO 80", .remedy = {}},
      {.name = "timer tick",
       .requested = "stopped",
       .effective = "ticks",
       .ok = false,
       .remedy = "boot with nohz_full=1",
       .cost = rt::Cost::kMicroseconds,
       .consequence = "some us"},
      {.name = "raw sockets",
       .requested = "allowed",
       .effective = "refused",
       .ok = false,
       .error_number = 1,
       .remedy = "run as root",
       .cost = rt::Cost::kPrevents,
       .consequence = "no frame can be sent"},
  };
}

TEST(MachineReport, WhatCostsMostComesFirstAndWhatIsFineLast) {
  EXPECT_EQ(machine_text(sample()),
            "PREVENTS  raw sockets              refused instead of allowed (Operation not\n"
            "                                   permitted)\n"
            "          costs: no frame can be sent\n"
            "          fix:   run as root\n"
            "SMALL     timer tick               ticks instead of stopped\n"
            "          costs: some us\n"
            "          fix:   boot with nohz_full=1\n"
            "ok        scheduler                SCHED_FIFO 80\n");
}

TEST(MachineReport, LinesAreBrokenBetweenWords) {
  const std::string word(30, 'w');
  EXPECT_EQ(wrapped("fix: ", word + " " + word + " " + std::string(14, 'e')),
            "fix: " + word + " " + word + "\n     " + std::string(14, 'e'));
  EXPECT_THAT(wrapped("fix: ", word + " " + word + " " + std::string(13, 'e')), testing::SizeIs(80)) << "just fits";
  EXPECT_EQ(wrapped("fix: ", std::string(90, 'w') + " e"), "fix: " + std::string(90, 'w') + "\n     e") << "too long";
  EXPECT_EQ(wrapped("", "a b"), "a b");
  EXPECT_EQ(shortened("spindle", 7), "spindle");
  EXPECT_EQ(shortened("spindles", 7), "spin...");
  EXPECT_EQ(shortened("\xC3\x84\xC3\x84\xC3\x84\xC3\x84", 4), "\xC3\x84\xC3\x84\xC3\x84\xC3\x84") << "UTF-8";
  EXPECT_EQ(shortened("\xC3\x84\xC3\x84\xC3\x84\xC3\x84\xC3\x84\xC3\x84", 5), "\xC3\x84\xC3\x84...");
}

TEST(MachineReport, ProgramsFindEverythingInTheOrderOfTheLook) {
  const auto rows = machine_json(sample());
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0], nlohmann::json::parse(R"({"name": "scheduler", "requested": "SCHED_FIFO 80",
    "found": "SCHED_FIFO 80", "ok": true, "cost": null, "consequence": null, "remedy": null})"));
  EXPECT_EQ(rows[2], nlohmann::json::parse(R"({"name": "raw sockets", "requested": "allowed", "found": "refused",
    "ok": false, "cost": "prevents", "consequence": "no frame can be sent", "remedy": "run as root"})"));
}

}  // namespace
}  // namespace driveline::cli

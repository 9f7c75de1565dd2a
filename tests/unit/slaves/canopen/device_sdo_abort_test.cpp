#include "device_rig.hpp"

namespace driveline::slaves::cia301 {
namespace {

// C31: each abort code, raised by a request. The codes and when they are raised are those of CiA 301 7.2.4.3.17.
struct AbortRow {
  const char* why;
  std::vector<const char*> requests;  // the last one is answered with the abort
  const char* answer;
};

class CanopenAbort : public CanopenDevice, public ::testing::WithParamInterface<AbortRow> {};

TEST_P(CanopenAbort, C31IsRaised) {
  std::vector<std::byte> answer;
  for (const char* request : GetParam().requests) answer = rig.ask(request);
  EXPECT_EQ(answer, hex(GetParam().answer)) << GetParam().why;
  // And the server goes on.
  EXPECT_EQ(rig.ask("40 01 20 00 00 00 00 00"), hex("4F 01 20 00 05 00 00 00"));
}

INSTANTIATE_TEST_SUITE_P(
    Sdo, CanopenAbort,
    ::testing::Values(
        AbortRow{"unknown command", {"E0 00 20 03 00 00 00 00"}, "80 00 20 03 01 00 04 05"},
        AbortRow{"segment without a request", {"00 01 02 03 04 05 06 07"}, "80 00 00 00 01 00 04 05"},
        AbortRow{"block upload is not there", {"A4 03 20 00 10 00 00 00"}, "80 03 20 00 01 00 04 05"},
        AbortRow{"block download is not there", {"C6 03 20 00 10 00 00 00"}, "80 03 20 00 01 00 04 05"},
        AbortRow{
            "toggle of an upload", {"40 03 20 00 00 00 00 00", "70 00 00 00 00 00 00 00"}, "80 03 20 00 00 00 03 05"},
        AbortRow{
            "toggle of a download", {"21 03 20 00 09 00 00 00", "10 31 32 33 34 35 36 37"}, "80 03 20 00 00 00 03 05"},
        AbortRow{"upload of a write-only object", {"40 05 20 00 00 00 00 00"}, "80 05 20 00 01 00 01 06"},
        AbortRow{"download to a read-only object", {"23 00 10 00 01 00 00 00"}, "80 00 10 00 02 00 01 06"},
        AbortRow{"no such object", {"40 FF 5F 02 00 00 00 00"}, "80 FF 5F 02 00 00 02 06"},
        AbortRow{"no such object to write", {"2F FF 5F 02 07 00 00 00"}, "80 FF 5F 02 00 00 02 06"},
        AbortRow{"no such sub-index", {"40 01 20 07 00 00 00 00"}, "80 01 20 07 11 00 09 06"},
        AbortRow{"more bytes than the object has", {"23 00 20 00 01 02 03 04"}, "80 00 20 00 12 00 07 06"},
        AbortRow{"fewer bytes", {"2F 02 20 00 01 00 00 00"}, "80 02 20 00 13 00 07 06"},
        AbortRow{"2 GiB are announced", {"21 03 20 00 00 00 00 80"}, "80 03 20 00 12 00 07 06"},
        AbortRow{"one byte too many is announced", {"21 03 20 00 65 00 00 00"}, "80 03 20 00 12 00 07 06"},
        AbortRow{"more data than announced",
                 {"21 03 20 00 09 00 00 00", "00 31 32 33 34 35 36 37", "17 31 32 33 34 00 00 00"},
                 "80 03 20 00 12 00 07 06"},
        AbortRow{"less data than announced",
                 {"21 03 20 00 09 00 00 00", "0D 31 00 00 00 00 00 00"},
                 "80 03 20 00 10 00 07 06"},
        AbortRow{"a value above the range", {"2B 06 20 00 2D 01 00 00"}, "80 06 20 00 31 00 09 06"},
        AbortRow{"a value below the range", {"2B 06 20 00 FA FF 00 00"}, "80 06 20 00 32 00 09 06"},
        AbortRow{"a value that is not there", {"2F 00 14 02 F1 00 00 00"}, "80 00 14 02 30 00 09 06"},
        AbortRow{"an object that cannot be mapped", {"23 00 16 01 20 00 03 20"}, "80 00 16 01 41 00 04 06"},
        AbortRow{"65 bits are mapped",
                 {"23 00 16 01 40 00 04 20", "23 00 16 02 01 00 01 00", "2F 00 16 00 02 00 00 00"},
                 "80 00 16 00 42 00 04 06"},
        AbortRow{"a node is monitored twice",
                 {"23 16 10 01 14 00 07 00", "23 16 10 02 14 00 07 00"},
                 "80 16 10 02 43 00 04 06"},
        AbortRow{"a wrong signature", {"23 10 10 01 73 61 76 66"}, "80 10 10 01 20 00 00 08"}));

TEST_F(CanopenDevice, C31AbortsOfTheApplicationAndItsState) {
  rig.application.can_keep = false;
  EXPECT_EQ(rig.ask("23 10 10 01 73 61 76 65"), hex("80 10 10 01 00 00 06 06"));  // hardware error
  rig.application.verdict = tl::unexpected(sdo::SdoAbort::kLocalControl);
  EXPECT_EQ(rig.ask("2B 00 20 00 01 00 00 00"), hex("80 00 20 00 21 00 00 08"));
  rig.application.verdict = {};
  rig.application.power = true;
  EXPECT_EQ(rig.ask("2F 07 20 00 03 00 00 00"), hex("80 07 20 00 22 00 00 08"));  // only while the power is off
  rig.application.power = false;
  EXPECT_EQ(rig.ask("2F 07 20 00 03 00 00 00"), hex("60 07 20 00 00 00 00 00"));
}

}  // namespace
}  // namespace driveline::slaves::cia301

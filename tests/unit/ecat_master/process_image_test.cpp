#include "driveline/ecat_master/process_data/process_image.hpp"

#include <gmock/gmock.h>

#include <chrono>

#include "driveline/ecat_master/cyclic/acyclic_budget.hpp"

namespace driveline::ecat_master {
namespace {

using wire::Command;

struct Bytes {
  std::size_t output = 0;
  std::size_t input = 0;
};

ProcessDataDemand demand(Bytes bytes) {
  ProcessDataDemand made;
  if (bytes.output > 0) made.channels.push_back({true, 2, 0x1100, bytes.output});
  if (bytes.input > 0) made.channels.push_back({false, 3, 0x1400, bytes.input});
  return made;
}

std::vector<ProcessDataDemand> demands(const std::vector<Bytes>& slaves) {
  std::vector<ProcessDataDemand> all;
  for (const auto& slave : slaves) all.push_back(demand(slave));
  return all;
}

ProcessImage lay_out(const std::vector<ProcessDataDemand>& wanted, const LayoutSettings& settings = {}) {
  auto image = ProcessImage::lay_out(wanted, settings);
  EXPECT_TRUE(image.has_value());
  return image.value_or(ProcessImage{});
}
ProcessImage lay_out(const std::vector<Bytes>& slaves) {
  return lay_out(demands(slaves));
}

TEST(ProcessImage, OverlapsOutputsAndInputsOfASlaveButNotSlaves) {
  const auto image = lay_out({{8, 12}, {20, 4}, {0, 0}, {6, 0}, {0, 2}});
  const auto places = image.places();
  ASSERT_EQ(places.size(), 5U);
  EXPECT_EQ(places[0].output_offset, 0U);
  EXPECT_EQ(places[0].input_offset, 0U);
  EXPECT_EQ(places[1].output_offset, 12U);
  EXPECT_EQ(places[1].input_offset, 12U);
  EXPECT_EQ(places[2].output_datagram, ProcessDataPlace::kNone);
  EXPECT_EQ(places[2].input_datagram, ProcessDataPlace::kNone);
  EXPECT_EQ(places[3].output_offset, 32U);
  EXPECT_EQ(places[3].input_datagram, ProcessDataPlace::kNone);
  EXPECT_EQ(places[4].input_offset, 38U);
  EXPECT_EQ(image.outputs().size(), 40U);
  EXPECT_EQ(image.inputs().size(), 40U);
  ASSERT_EQ(image.datagrams().size(), 1U);
  EXPECT_EQ(image.datagrams()[0].bytes, 40U);
  EXPECT_EQ(image.datagrams()[0].command, Command::kLrw);
  EXPECT_EQ(image.datagrams()[0].expected_working_counter, 3 + 3 + 0 + 2 + 1);
}

TEST(ProcessImage, TakesFmmusForWhatTheyAreMeant) {
  using Use = esi::FmmuUse;
  auto wanted = demands({{8, 12}});
  wanted[0].al_status = true;
  wanted[0].mailbox_status = 0x080D;
  wanted[0].fmmus = 5;
  wanted[0].fmmu_uses = {Use::kMailboxState, Use::kInputs, Use::kUnused, Use::kOutputs};
  const auto image = lay_out(wanted);
  const auto fmmus = image.fmmus(0);
  ASSERT_EQ(fmmus.size(), 4U);
  EXPECT_EQ(fmmus[0].physical_start, 0x080D);
  EXPECT_EQ(fmmus[1].physical_start, 0x1400);
  EXPECT_EQ(fmmus[2].physical_start, 0x0130) << "the AL status takes one that is meant for nothing";
  EXPECT_EQ(fmmus[3].physical_start, 0x1100);
  // Three of them, none meant for outputs: any can be used, and none is left for the mailbox.
  wanted[0].fmmus = 3;
  wanted[0].fmmu_uses = {Use::kInputs, Use::kInputs, Use::kInputs};
  const auto few = lay_out(wanted);
  ASSERT_EQ(few.fmmus(0).size(), 3U);
  EXPECT_EQ(few.fmmus(0)[0].physical_start, 0x1100);
  EXPECT_EQ(few.fmmus(0)[1].physical_start, 0x1400);
  EXPECT_EQ(few.fmmus(0)[2].physical_start, 0x0130);
  EXPECT_EQ(few.datagrams()[0].expected_working_counter, 3);
}

TEST(ProcessImage, LeavesFmmusOutThatAreMeantForSomethingElse) {
  using Use = esi::FmmuUse;
  auto wanted = demands({{0, 12}});
  wanted[0].fmmu_uses = {Use::kOutputs, Use::kInputs};
  const auto image = lay_out(wanted);
  ASSERT_EQ(image.fmmus(0).size(), 2U);
  EXPECT_FALSE(image.fmmus(0)[0].active);
  EXPECT_EQ(image.fmmus(0)[1].physical_start, 0x1400);
  EXPECT_EQ(image.datagrams()[0].expected_working_counter, 1);
}

TEST(ProcessImage, PutsInputsBehindOutputsWhenTheyMayNotOverlap) {
  const auto image = lay_out(demands({{8, 12}, {20, 4}}), {ImageLayout::kSequential, {}});
  EXPECT_EQ(image.places()[0].output_offset, 0U);
  EXPECT_EQ(image.places()[0].input_offset, 8U);
  EXPECT_EQ(image.places()[1].output_offset, 20U);
  EXPECT_EQ(image.places()[1].input_offset, 40U);
  ASSERT_EQ(image.datagrams().size(), 1U);
  EXPECT_EQ(image.datagrams()[0].bytes, 44U);
  EXPECT_EQ(image.datagrams()[0].expected_working_counter, 6);
}

TEST(ProcessImage, ReadsAndWritesInDatagramsOfTheirOwnWhenAsked) {
  const auto image = lay_out(demands({{8, 12}, {20, 0}, {0, 3}}), {ImageLayout::kSeparate, {}});
  ASSERT_EQ(image.datagrams().size(), 2U);
  EXPECT_EQ(image.datagrams()[0].command, Command::kLwr);
  EXPECT_EQ(image.datagrams()[0].bytes, 28U);
  EXPECT_EQ(image.datagrams()[0].expected_working_counter, 2);
  EXPECT_EQ(image.datagrams()[1].command, Command::kLrd);
  EXPECT_EQ(image.datagrams()[1].bytes, 15U);
  EXPECT_EQ(image.datagrams()[1].expected_working_counter, 2);
  EXPECT_EQ(image.datagrams()[0].frame, image.datagrams()[1].frame);
}

TEST(ProcessImage, SlavesThatDoNotTakeLrwTravelBesideThoseThatDo) {
  auto wanted = demands({{4, 4}, {4, 4}, {4, 4}});
  wanted[1].lrw = false;
  const auto image = lay_out(wanted);
  ASSERT_EQ(image.datagrams().size(), 3U);
  const Command commands[] = {Command::kLrw, Command::kLwr, Command::kLrd};
  const std::uint16_t counters[] = {6, 1, 1};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(image.datagrams()[i].command, commands[i]);
    EXPECT_EQ(image.datagrams()[i].expected_working_counter, counters[i]);
  }
}

TEST(ProcessImage, GivesEverySyncManagerAnFmmu) {
  ProcessDataDemand wanted;
  wanted.channels = {{true, 2, 0x1000, 3}, {true, 3, 0x1080, 2}, {false, 4, 0x1100, 1}, {false, 5, 0x1180, 7}};
  const auto image = lay_out({wanted});
  const auto fmmus = image.fmmus(0);
  ASSERT_EQ(fmmus.size(), 4U);
  const std::uint32_t logical[] = {0x10000, 0x10003, 0x10000, 0x10001};
  const std::uint16_t physical[] = {0x1000, 0x1080, 0x1100, 0x1180};
  const std::uint16_t lengths[] = {3, 2, 1, 7};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(fmmus[i].logical_start, logical[i]);
    EXPECT_EQ(fmmus[i].physical_start, physical[i]);
    EXPECT_EQ(fmmus[i].length, lengths[i]);
    EXPECT_EQ(fmmus[i].type, i < 2 ? wire::FmmuEntity::kTypeWrite : wire::FmmuEntity::kTypeRead);
    EXPECT_TRUE(fmmus[i].active);
  }
  EXPECT_EQ(image.datagrams()[0].expected_working_counter, 3) << "a slave counts once per direction, not per FMMU";
}

TEST(ProcessImage, MapsStatusBytesBehindTheProcessDataIfFmmusAreLeft) {
  auto wanted = demands({{8, 4}, {8, 4}, {8, 4}, {4, 0}});
  for (auto& slave : wanted) {
    slave.al_status = true;
    slave.mailbox_status = 0x080D;
  }
  wanted[0].fmmus = 4;
  wanted[1].fmmus = 3;
  wanted[2].fmmus = 2;
  const auto image = lay_out(wanted);
  const auto places = image.places();
  EXPECT_EQ(places[0].al_status_offset, 8U);
  EXPECT_EQ(places[0].mailbox_offset, 9U);
  EXPECT_EQ(places[1].al_status_offset, 18U);
  EXPECT_EQ(places[1].mailbox_offset, ProcessDataPlace::kNone);
  EXPECT_EQ(places[2].al_status_offset, ProcessDataPlace::kNone);
  EXPECT_EQ(image.fmmus(0)[2].physical_start, 0x0130);
  EXPECT_EQ(image.fmmus(0)[3].physical_start, 0x080D);
  // A slave without inputs also counts for reading, because its status bytes are read.
  EXPECT_EQ(image.datagrams()[0].expected_working_counter, 4 * 3);
}

TEST(ProcessImage, TheWorkingCounterFollowsTheStatusBytesIntoAnotherDatagram) {
  auto wanted = demands({{1452, 0}, {1452, 0}});
  for (auto& slave : wanted) slave.al_status = true;
  const auto image = lay_out(wanted, {ImageLayout::kSeparate, {}});
  ASSERT_EQ(image.datagrams().size(), 3U);
  EXPECT_EQ(image.datagrams()[0].expected_working_counter, 1);
  EXPECT_EQ(image.datagrams()[1].expected_working_counter, 1);
  EXPECT_EQ(image.datagrams()[2].expected_working_counter, 2) << "both status bytes";
  EXPECT_EQ(image.datagrams()[2].bytes, 2U);
}

TEST(ProcessImage, RefusesASlaveWithTooFewFmmus) {
  auto wanted = demands({{1, 1}, {1, 1}});
  wanted[1].fmmus = 1;
  const auto image = ProcessImage::lay_out(wanted);
  ASSERT_FALSE(image);
  EXPECT_EQ(describe(image.error()), "slave 1: its process data need 2 FMMUs, it has 1");
}

TEST(ProcessImage, CutsNoSlaveInTwo) {
  // 1500 - 2 - 12 bytes of data, less the AL status broadcast (14) and the drift compensation (20).
  EXPECT_EQ(ProcessImage::kMaxDatagramBytes, 1452U);
  const auto image = lay_out({{1000, 0}, {400, 0}, {60, 0}, {1452, 1}, {1, 0}});
  ASSERT_EQ(image.datagrams().size(), 4U);
  const std::size_t expected_bytes[] = {1400, 60, 1452, 1};
  const std::size_t expected_offsets[] = {0, 1400, 1460, 2912};
  const std::uint16_t expected_counters[] = {4, 2, 3, 2};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(image.datagrams()[i].bytes, expected_bytes[i]);
    EXPECT_EQ(image.datagrams()[i].offset, expected_offsets[i]);
    EXPECT_EQ(image.datagrams()[i].expected_working_counter, expected_counters[i]);
  }
  for (const auto& place : image.places()) {
    const auto& datagram = image.datagrams()[place.output_datagram];
    EXPECT_GE(place.output_offset, datagram.offset);
    EXPECT_LE(place.output_offset + place.output_bytes, datagram.offset + datagram.bytes);
  }
}

TEST(ProcessImage, NoFrameIsLongerThanEthernetAllows) {
  std::vector<Bytes> slaves(300, Bytes{23, 17});
  for (const auto layout : {ImageLayout::kOverlapped, ImageLayout::kSequential, ImageLayout::kSeparate}) {
    const auto image = lay_out(demands(slaves), {layout, {}});
    std::vector<std::size_t> bytes(image.frame_count(), wire::kDatagramsOffset);
    bytes[0] += ProcessImage::kReservedBytes;
    for (const auto& datagram : image.datagrams()) {
      bytes[datagram.frame] += wire::DatagramHeader::kOverhead + datagram.bytes;
    }
    for (const auto frame : bytes) EXPECT_LE(frame, 1514U);
    EXPECT_GE(image.frame_count(), 5U);
  }
}

TEST(ProcessImage, GroupsHaveFramesOfTheirOwn) {
  auto wanted = demands({{4, 4}, {4, 4}, {4, 4}});
  wanted[0].group = 1;
  const auto image = lay_out(wanted, {ImageLayout::kOverlapped, {{1, 0}, {4, 2}}});
  ASSERT_EQ(image.datagrams().size(), 2U);
  EXPECT_EQ(image.datagrams()[0].group, 0U);
  EXPECT_EQ(image.datagrams()[0].expected_working_counter, 6);
  EXPECT_EQ(image.datagrams()[1].group, 1U);
  EXPECT_EQ(image.datagrams()[1].expected_working_counter, 3);
  EXPECT_EQ(image.datagrams()[0].frame, 0U);
  EXPECT_EQ(image.datagrams()[1].frame, 1U);
  EXPECT_EQ(image.groups()[1].divider, 4U);
}

TEST(ProcessImage, AGroupThatPausesDoesNotTravelWithTheBroadcast) {
  const auto image = lay_out(demands({{4, 4}}), {ImageLayout::kOverlapped, {{2, 0}}});
  EXPECT_EQ(image.frame_count(), 2U);
  EXPECT_EQ(image.datagrams()[0].frame, 1U);
}

TEST(ProcessImage, RefusesASlaveThatFitsNoFrame) {
  const auto image = ProcessImage::lay_out(demands({{1, 1}, {0, 1453}}));
  ASSERT_FALSE(image);
  EXPECT_TRUE(image.error().is<facts::ProcessDataSize>());
  EXPECT_EQ(image.error().slave, 1);
  EXPECT_EQ(std::get<facts::ProcessDataSize>(image.error().facts).limit, 1452U);
  EXPECT_EQ(std::get<facts::ProcessDataSize>(image.error().facts).bytes, 1453U);
}

TEST(ProcessImage, WithoutProcessDataHasNoDatagram) {
  EXPECT_TRUE(lay_out(std::vector<Bytes>{}).datagrams().empty());
  const auto image = lay_out({{0, 0}, {0, 0}});
  EXPECT_TRUE(image.datagrams().empty());
  EXPECT_EQ(image.places().size(), 2U);
  EXPECT_TRUE(image.outputs().empty());
}

TEST(ProcessImage, StartsAtItsLogicalAddress) {
  EXPECT_EQ(ProcessImage::logical_address(0), 0x00010000U);
  EXPECT_EQ(ProcessImage::logical_address(38), 0x00010026U);
}

TEST(WireTime, MatchesACalculationByHand) {
  // One frame: Ethernet 14, EtherCAT 2, BRD 12 + 2, LRW 12 + data; preamble 8, FCS 4, gap 12; 80 ns a byte.
  EXPECT_EQ(wire_time_ns(lay_out({Bytes{19, 19}}), false), (14U + 2 + 14 + 12 + 19 + 24) * 80);
  EXPECT_EQ(wire_time_ns(lay_out(std::vector<Bytes>(8, Bytes{19, 19})), false), 218U * 80);
  // The time of the reference clock: a datagram of four bytes in the first frame.
  EXPECT_EQ(wire_time_ns(lay_out(std::vector<Bytes>(8, Bytes{19, 19})), true), (218U + 12 + 4) * 80);
  // Nothing but the broadcast: the shortest frame, 60 bytes.
  EXPECT_EQ(wire_time_ns(lay_out({Bytes{0, 0}}), false), 84U * 80);
  // Two frames, the second without the broadcast: 16 + 14 + 12 + 1440 + 24, 16 + 12 + 100 + 24.
  EXPECT_EQ(wire_time_ns(lay_out({{1440, 0}, {100, 0}}), false), (1506U + 152) * 80);
  // A short second frame is padded to 60 bytes.
  EXPECT_EQ(wire_time_ns(lay_out({{1440, 0}, {20, 0}}), false), (1506U + 84) * 80);
}

TEST(AcyclicFrames, HaveWhatTheCycleLeaves) {
  using std::chrono::microseconds;
  const auto drives = [](std::size_t count) { return lay_out(std::vector<Bytes>(count, Bytes{19, 19})); };
  // 112.5 us are 1406 bytes; 218 of them are the eight drives', 24 the preamble, FCS and gap of the frame itself.
  EXPECT_EQ(acyclic_bytes(drives(8), false, microseconds{125}), 1406U - 218 - 24);
  EXPECT_EQ(acyclic_bytes(drives(8), true, microseconds{125}), 1406U - 218 - 16 - 24);
  EXPECT_EQ(acyclic_bytes(drives(8), false, microseconds{1000}), 11250U - 218 - 24);
  EXPECT_EQ(acyclic_bytes(drives(8), false, microseconds{2000}), 8 * 1518U) << "as many frames as may be on their way";
  EXPECT_EQ(acyclic_bytes(drives(70), false, microseconds{125}), 60U) << "the shortest frame there is";
}

TEST(WireTime, IsThatOfTheBusiestCycle) {
  auto wanted = demands({{1440, 0}, {1440, 0}, {1440, 0}});
  wanted[1].group = 1;
  wanted[2].group = 2;
  constexpr std::uint64_t kFirst = 14 + 2 + 14 + 12 + 1440 + 24;
  constexpr std::uint64_t kOther = 14 + 2 + 12 + 1440 + 24;
  // Groups 1 and 2 alternate; with the same phase they coincide.
  EXPECT_EQ(wire_time_ns(lay_out(wanted, {{}, {{1, 0}, {2, 0}, {2, 1}}}), false), (kFirst + kOther) * 80);
  EXPECT_EQ(wire_time_ns(lay_out(wanted, {{}, {{1, 0}, {2, 0}, {2, 0}}}), false), (kFirst + 2 * kOther) * 80);
}

}  // namespace
}  // namespace driveline::ecat_master

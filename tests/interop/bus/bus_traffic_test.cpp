// The traffic of the bus tests in Wireshark's dissector: nothing malformed, and every mailbox message dissected as its
// type.
#include <gmock/gmock.h>

#include <fstream>
#include <iterator>
#include <map>

#include "drive_line.hpp"
#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/esi/esi_file.hpp"
#include "driveline/slaves/generic/generic_device.hpp"
#include "traffic.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
using slaves::Fault;
using slaves::FaultDirection;
using slaves::FaultKind;

TEST_F(BusTraffic, DiscoveryStartUpAndCyclicOperation) {
  DriveLine drives(3);
  Recorder recorder(drives.line());
  LineOperation operation(drives, recorder);
  ASSERT_EQ(sentence(operation.to_motion()), "");
  ASSERT_TRUE(operation.run_until(motion::MotionPhase::kFollowing, std::chrono::seconds{2}));
  operation.run(milliseconds{50});
  ASSERT_EQ(sentence(operation.master().shut_down()), "");
  expect_clean(recorder.frames);
  EXPECT_GT(recorder.requests, 30U);
  EXPECT_EQ(occurrences("ecat.cnt == 0", "ecat_mailbox.coe.sdoreq"), recorder.requests);
  EXPECT_EQ(occurrences("ecat.cnt == 1", "ecat_mailbox.coe.sdores"), recorder.replies);
}

TEST_F(BusTraffic, ServiceDataAndAborts) {
  DriveLine drives(2);
  Recorder recorder(drives.line());
  ecat_master::Master master(recorder, drives.clock);
  ASSERT_EQ(sentence(master.scan()), "");
  ASSERT_EQ(sentence(master.enter_pre_op()), "");
  recorder.frames.clear();
  recorder.requests = recorder.replies = 0;
  CoeClient coe(*master.mailbox(1));
  ASSERT_EQ(sentence(coe.upload(0x1008, 0)), "");
  ASSERT_EQ(sentence(coe.upload_as<std::uint32_t>(0x1018, 1)), "");
  ASSERT_EQ(sentence(coe.download_as<std::uint32_t>(0x6065, 0, 4711)), "");
  ASSERT_FALSE(coe.upload(0x5FFF, 0)) << "an abort";
  ASSERT_FALSE(coe.download_as<std::uint8_t>(0x6041, 0, 1)) << "another one";
  ASSERT_FALSE(coe.upload(0x1018, 0, true));
  expect_clean(recorder.frames);
  // Requests, and the aborts (read only, no complete access, no such object), which count as requests as well; replies.
  const auto codes = values("ecat.cnt == 1", "ecat_mailbox.coe.abortcode");
  EXPECT_EQ(codes, (std::map<std::string, std::size_t>{{"0x06010002", 1}, {"0x06010004", 1}, {"0x06020000", 1}}));
  EXPECT_EQ(occurrences("ecat.cnt == 0", "ecat_mailbox.coe.sdoreq"), recorder.requests);
  EXPECT_EQ(occurrences("ecat.cnt == 1", "ecat_mailbox.coe.sdores"), recorder.replies - codes.size());
  const auto indices = values("ecat.cnt == 0", "ecat_mailbox.coe.sdoidx");
  for (const char* index : {"0x1008", "0x1018", "0x6065", "0x5fff", "0x6041"}) {
    EXPECT_EQ(indices.count(index), 1U) << index;
  }
}

/// A terminal with mailboxes so short that its array of 120 bytes is transferred in segments.
std::unique_ptr<slaves::Slave> make_terminal() {
  std::ifstream stream("examples/terminals.xml", std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  const auto file = esi::read_esi(text, "examples/terminals.xml");
  if (!file) throw std::runtime_error(esi::to_text(file.error()));
  const auto device = file->choose({"MX4", {}, {}});
  if (!device) throw std::runtime_error(describe(device.error()));
  auto description = **device;
  for (std::size_t n = 0; n < 2; ++n) description.sync_managers.at(n).default_size = 64;
  auto model = slaves::generic::DeviceModel::create(std::move(description));
  if (!model) throw std::runtime_error(describe(model.error()));
  return std::make_unique<slaves::Slave>(
      std::make_unique<slaves::generic::GenericDevice>(*model, slaves::generic::GenericOptions{}));
}

TEST_F(BusTraffic, SegmentsCompleteAccessAndInformation) {
  rt::VirtualClock clock(milliseconds{1});
  std::vector<std::unique_ptr<slaves::Slave>> terminals;
  terminals.push_back(make_terminal());
  slaves::SimulatedLine line(clock, std::move(terminals));
  Recorder recorder(line, 0x1100);
  ecat_master::Master master(recorder, clock);
  ASSERT_EQ(sentence(master.scan()), "");
  ASSERT_EQ(sentence(master.enter_pre_op()), "");
  CoeClient coe(*master.mailbox(0));
  auto names = coe.upload(0x8010, 0, true);
  ASSERT_EQ(sentence(names), "");
  ASSERT_GT(names->size(), 64U);
  for (std::size_t i = 2; i < names->size(); ++i) (*names)[i] = static_cast<std::byte>(i);
  ASSERT_EQ(sentence(coe.download(0x8010, 0, *names, true)), "");
  const auto again = coe.upload(0x8010, 0, true);
  ASSERT_EQ(sentence(again), "");
  EXPECT_EQ(*again, *names);
  const auto objects = coe.object_list();
  ASSERT_EQ(sentence(objects), "");
  for (const auto index : *objects) ASSERT_EQ(sentence(coe.object_description(index)), "");
  ASSERT_EQ(sentence(coe.entry_description(0x8010, 1)), "");
  expect_clean(recorder.frames);
  EXPECT_EQ(occurrences("ecat.cnt == 0", "ecat_mailbox.coe"), recorder.requests);
  EXPECT_EQ(occurrences("ecat.cnt == 1", "ecat_mailbox.coe"), recorder.requests + recorder.replies)
      << "requests as they come back from the line, and replies";
  EXPECT_GE(occurrences("ecat.cnt == 0", "ecat_mailbox.coe.sdoccsus"), 4U) << "segments of two uploads";
  EXPECT_GE(occurrences("ecat.cnt == 0", "ecat_mailbox.coe.sdoccsds"), 2U) << "and of a download";
}

TEST_F(BusTraffic, FaultsOfTheLine) {
  DriveLine drives(4);
  Recorder recorder(drives.line());
  LineOperation operation(drives, recorder);
  ASSERT_EQ(sentence(operation.to_op()), "");
  const Fault faults[] = {
      {.kind = FaultKind::kDrop, .chance = 0.2},
      {.kind = FaultKind::kDrop, .direction = FaultDirection::kBack, .chance = 0.2},
      {.kind = FaultKind::kDelay, .chance = 0.1, .time = microseconds{300}},
      {.kind = FaultKind::kDuplicate, .chance = 0.2},
      {.kind = FaultKind::kDamage, .slave = 2, .port = 0, .chance = 0.2},
      {.kind = FaultKind::kShortWorkingCounter, .slave = 1},
      {.kind = FaultKind::kCableBreak, .slave = 2, .port = 1},
      {.kind = FaultKind::kPowerOff, .slave = 3},
      {.kind = FaultKind::kMailboxSilent, .slave = 0},
      {.kind = FaultKind::kEepromBusy, .slave = 0, .time = milliseconds{1}},
      {.kind = FaultKind::kSlowTransition, .slave = 0, .time = milliseconds{1}},
  };
  for (const auto& fault : faults) {
    ASSERT_TRUE(drives.line().inject(fault));
    operation.run(milliseconds{10});
    ASSERT_TRUE(drives.line().heal(fault));
  }
  static_cast<void>(operation.master().shut_down());
  LineOperation again(drives, recorder);
  ASSERT_EQ(sentence(again.to_op()), "") << "after all of them";
  expect_clean(recorder.frames);
}

TEST_F(BusTraffic, EmergenciesAndSdoWhileCycling) {
  DriveLine drives(2);
  Recorder recorder(drives.line());
  LineOperation operation(drives, recorder);
  ASSERT_EQ(sentence(operation.to_motion()), "");
  ASSERT_TRUE(operation.run_until(motion::MotionPhase::kFollowing, std::chrono::seconds{2}));
  recorder.frames.clear();
  drives.drive(1).set_dc_link(false);
  operation.run(milliseconds{10});
  ASSERT_EQ(sentence(operation.master().mailbox(1)->poll()), "");
  CoeClient coe(*operation.master().mailbox(1));
  ASSERT_EQ(sentence(coe.upload_as<std::uint32_t>(0x1018, 1)), "");
  expect_clean(recorder.frames);
  // An emergency, of which the dissector knows the CoE type (ETG.1000.6 5.6.4: service 1).
  EXPECT_GE(values("ecat.cnt == 1", "ecat_mailbox.coe.type").count("1"), 1U);
}

}  // namespace
}  // namespace driveline::bus_test

#include <gmock/gmock.h>

#include <algorithm>
#include <memory>

#include "drive_line.hpp"
#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/coe/sdo_request.hpp"
#include "driveline/ecat_master/coe/sdo_script.hpp"
#include "fault_ports.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
namespace facts = ecat_master::facts;
using ecat_master::Master;
using ecat_master::SdoFuture;
using ecat_master::SdoRequest;
using Fault = slaves::MailboxTransport::Fault;

/// A line in PREOP.
struct OpenLine {
  explicit OpenLine(std::size_t count) : drives(count), master(drives.line(), drives.clock) {
    EXPECT_EQ(sentence(master.scan()), "");
    EXPECT_EQ(sentence(master.enter_pre_op()), "");
  }
  CoeClient coe(std::size_t slave) { return CoeClient(master.mailboxes(), static_cast<std::uint16_t>(slave)); }
  /// Requests the serial numbers of all drives at the same time.
  std::vector<SdoFuture> ask_all() {
    std::vector<SdoFuture> futures;
    for (std::size_t i = 0; i < drives.size(); ++i) futures.push_back(coe(i).start_upload({0x1018, 4, false}));
    return futures;
  }

  DriveLine drives;
  Master master;
};

TEST(MailboxesOfManySlaves, AreServedSideBySide) {
  OpenLine line(64);
  const auto futures = line.ask_all();
  for (std::size_t i = 0; i < futures.size(); ++i) {
    ASSERT_EQ(sentence(futures[i].get()), "");
    EXPECT_EQ(bytes::load_le<std::uint32_t>(*futures[i].get()), 1000 + i);
  }
}

TEST(MailboxesOfManySlaves, TakeTheTimeOfOne) {
  OpenLine line(32);
  auto begin = line.drives.clock.now();
  ASSERT_EQ(sentence(line.coe(31).upload(0x1018, 4)), "");
  const auto one = line.drives.clock.now() - begin;
  begin = line.drives.clock.now();
  for (const auto& future : line.ask_all()) ASSERT_EQ(sentence(future.get()), "");
  EXPECT_LT(line.drives.clock.now() - begin, 3 * one) << "one after the other would take 32 times as long";
}

TEST(MailboxesOfManySlaves, ASilentOneDelaysNobody) {
  OpenLine line(8);
  line.drives.slave(3).mailbox().set_fault(Fault::kSilent);
  line.drives.slave(5).mailbox().set_fault(Fault::kBusy);
  const auto futures = line.ask_all();
  const auto begin = line.drives.clock.now();
  for (const std::size_t i : {0U, 1U, 2U, 4U, 6U, 7U}) EXPECT_EQ(sentence(futures[i].get()), "");
  EXPECT_LT(line.drives.clock.now() - begin, milliseconds{20});
  EXPECT_FALSE(futures[3].ready());
  // A silent slave does not block others while it is silent.
  for (int round = 0; round < 20; ++round) ASSERT_EQ(sentence(line.coe(0).upload(0x1018, 1)), "");
  EXPECT_LT(line.drives.clock.now() - begin, milliseconds{200});
  EXPECT_EQ(sentence(futures[3].get()), "slave 3: no mailbox reply for object 1018h:04 within 2000 ms");
  EXPECT_EQ(sentence(futures[5].get()), "slave 5: no mailbox reply for object 1018h:04 within 2000 ms");
}

TEST(MailboxesOfManySlaves, ScriptsRunSideBySideAndEndOneByOne) {
  OpenLine line(6);
  line.drives.slave(1).mailbox().set_fault(Fault::kSilent);
  std::vector<ecat_master::SdoScript> scripts;
  for (std::uint16_t i = 0; i < 6; ++i) {
    const auto value = bytes::to_le_bytes<std::uint32_t>(5000U + i);
    scripts.push_back({i, {{{0x6065, 0, false}, {value.begin(), value.end()}}}});
    if (i == 4) scripts.back().steps.insert(scripts.back().steps.begin(), {{0x5FFF, 0, false}, {std::byte{1}}});
  }
  const auto results = run_scripts(line.master.mailboxes(), scripts);
  ASSERT_EQ(results.size(), 6U);
  EXPECT_EQ(sentence(results[1]), "slave 1: no mailbox reply for object 6065h:00 within 2000 ms");
  EXPECT_EQ(sentence(results[4]),
            "slave 4: object 5FFFh:00 aborted with 0x06020000 (object does not exist in the object dictionary)");
  for (const std::size_t i : {0U, 2U, 3U, 5U}) {
    EXPECT_EQ(sentence(results[i]), "");
    EXPECT_EQ(line.coe(i).upload_as<std::uint32_t>(0x6065, 0).value(), 5000 + i);
  }
  EXPECT_NE(line.coe(4).upload_as<std::uint32_t>(0x6065, 0).value(), 5004U) << "nothing is written behind a failure";
}

TEST(MailboxDialogues, OfHigherPriorityGoFirst) {
  OpenLine line(1);
  std::vector<int> order;
  auto note = [&order](int number) { return [&order, number](const auto&) { order.push_back(number); }; };
  auto coe = line.coe(0);
  std::vector<SdoFuture> futures;
  futures.push_back(coe.start_upload({0x1018, 1, false}, note(0), 0));
  futures.push_back(coe.start_upload({0x1018, 1, false}, note(1), 0));
  futures.push_back(coe.start_upload({0x1018, 1, false}, note(2), 3));
  futures.push_back(coe.start_upload({0x1018, 1, false}, note(3), 1));
  for (const auto& future : futures) future.wait();
  EXPECT_THAT(order, testing::ElementsAre(2, 3, 0, 1));
}

TEST(MailboxDialogues, CallBackMayAskAgain) {
  OpenLine line(1);
  std::optional<std::uint32_t> product;
  auto first = line.coe(0).start_upload({0x1018, 1, false}, [&](const auto& vendor) {
    ASSERT_TRUE(vendor);
    product = line.coe(0).template upload_as<std::uint32_t>(0x1018, 2).value();
  });
  first.wait();
  EXPECT_EQ(product, slaves::msd::kProductCode);
}

TEST(MailboxDialogues, WithoutAnOpenMailboxFailAtOnce) {
  DriveLine drives(1);
  ScannedMaster master(drives.line(), drives.clock);
  EXPECT_EQ(sentence(CoeClient(master.mailboxes(), 0).upload(0x1018, 1)), "slave 0: has no CoE mailbox");
}

TEST(MailboxDialogues, AreCancelledWhenTheMailboxStartsAnew) {
  OpenLine line(2);
  line.drives.slave(0).mailbox().set_fault(Fault::kSilent);
  const auto future = line.coe(0).start_upload({0x1018, 1, false});
  line.master.mailboxes().step();
  ASSERT_FALSE(future.ready());
  ASSERT_EQ(sentence(line.master.enter_pre_op()), "");
  EXPECT_TRUE(future.ready());
  EXPECT_EQ(sentence(future.get()), "stopped on request");
}

TEST(SdoAfterATimeout, GetsItsOwnAnswer) {
  OpenLine line(1);
  line.drives.slave(0).mailbox().set_fault(Fault::kSilent);
  ASSERT_FALSE(line.coe(0).upload(0x1018, 1));
  line.drives.slave(0).mailbox().set_fault(Fault::kNone);
  const auto product = line.coe(0).upload_as<std::uint32_t>(0x1018, 2);
  ASSERT_EQ(sentence(product), "");
  EXPECT_EQ(*product, slaves::msd::kProductCode);
}

TEST(SdoRequestOfTheCycle, ReadsAndWritesWhileOthersStepTheEngine) {
  OpenLine line(2);
  auto& engine = line.master.mailboxes();
  const auto request = make_request(engine, 1, 0x6065, 0, 4);
  EXPECT_EQ(request->state(), SdoRequest::State::kIdle);
  const auto value = bytes::to_le_bytes<std::uint32_t>(4711);
  ASSERT_TRUE(request->start_download(value));
  EXPECT_FALSE(request->start_upload()) << "one at a time";
  auto run = [&] {
    for (int i = 0;
         i < 1000 && request->state() != SdoRequest::State::kDone && request->state() != SdoRequest::State::kFailed;
         ++i) {
      engine.drive();
    }
  };
  run();
  ASSERT_EQ(request->state(), SdoRequest::State::kDone);
  EXPECT_EQ(line.coe(1).upload_as<std::uint32_t>(0x6065, 0).value(), 4711U);
  ASSERT_TRUE(request->start_upload());
  run();
  ASSERT_EQ(request->state(), SdoRequest::State::kDone);
  EXPECT_THAT(request->data(), testing::ElementsAreArray(value));
}

TEST(SdoRequestOfTheCycle, TellsWhyItFailed) {
  OpenLine line(1);
  auto& engine = line.master.mailboxes();
  const auto missing = make_request(engine, 0, 0x5FFF, 0, 4);
  const auto small = make_request(engine, 0, 0x1008, 0, 4);
  ASSERT_TRUE(missing->start_upload());
  ASSERT_TRUE(small->start_upload());
  for (int i = 0; i < 1000 && small->state() != SdoRequest::State::kFailed; ++i) engine.drive();
  ASSERT_EQ(missing->state(), SdoRequest::State::kFailed);
  EXPECT_TRUE(missing->error().is<facts::SdoAbort>());
  ASSERT_EQ(small->state(), SdoRequest::State::kFailed);
  EXPECT_TRUE(small->error().is<facts::SdoSize>());
  EXPECT_TRUE(small->data().empty());
  EXPECT_FALSE(small->start_download(std::array<std::byte, 5>{})) << "longer than its capacity";
}

TEST(SdoInformationOfADrive, ListsObjectsAndDescribesThem) {
  OpenLine line(1);
  auto coe = line.coe(0);
  const auto all = coe.object_list();
  ASSERT_EQ(sentence(all), "");
  EXPECT_TRUE(std::is_sorted(all->begin(), all->end()));
  EXPECT_THAT(*all, testing::IsSupersetOf({0x1000, 0x1018, 0x1600, 0x1A00, 0x6040, 0x6041, 0x607A}));
  const auto mappable = coe.object_list(ecat_master::ObjectList::kRxMappable);
  ASSERT_EQ(sentence(mappable), "");
  EXPECT_THAT(*mappable, testing::Contains(0x6040));
  EXPECT_THAT(*mappable, testing::Not(testing::Contains(0x6041)));
  const auto identity = coe.object_description(0x1018);
  ASSERT_EQ(sentence(identity), "");
  EXPECT_EQ(identity->object_code, 9) << "record";
  EXPECT_EQ(identity->max_subindex, 4);
  EXPECT_FALSE(identity->name.empty());
  const auto window = coe.entry_description(0x6065, 0);
  ASSERT_EQ(sentence(window), "");
  EXPECT_EQ(window->data_type, 0x0007) << "UNSIGNED32";
  EXPECT_EQ(window->bit_length, 32);
  EXPECT_NE(window->access & wire::entry_access::kWriteOp, 0);
  EXPECT_TRUE(window->default_value);
  EXPECT_EQ(sentence(coe.object_description(0x5FFF)),
            "slave 0: object 5FFFh:00 aborted with 0x06020000 (object does not exist in the object dictionary)");
  EXPECT_EQ(sentence(coe.entry_description(0x1018, 99)),
            "slave 0: object 1018h:63 aborted with 0x06090011 (sub-index does not exist)");
}

TEST(EmergenciesOfTheLine, AreFetchedWithoutBeingAskedFor) {
  DriveLine drives(3);
  FollowingOperation operation(drives);
  drives.drive(1).set_dc_link(false);
  operation.run(milliseconds{10});
  const auto fetched_from = drives.clock.now();
  // Transfers with another drive read the mailbox of the faulty one as well.
  for (int i = 0; i < 50; ++i) ASSERT_EQ(sentence(CoeClient(*operation.master().mailbox(2)).upload(0x1018, 1)), "");
  const auto records = operation.master().emergencies().all();
  ASSERT_EQ(records.size(), 1U);
  EXPECT_EQ(records[0].slave, 1);
  EXPECT_EQ(records[0].message.error_code, 0x3220);
  EXPECT_GE(records[0].time, fetched_from);
  EXPECT_THAT(describe(records[0]),
              testing::HasSubstr("slave 1: emergency 0x3220, DC link undervoltage, error register 0x05,"));
}

}  // namespace
}  // namespace driveline::bus_test

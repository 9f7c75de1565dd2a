// Surveying a line and writing EEPROMs, with the simulated controllers.
#include "driveline/ecat_master/discovery/line_survey.hpp"

#include <gmock/gmock.h>

#include <set>

#include "drive_line.hpp"
#include "driveline/ecat_master/sii/sii_writer.hpp"
#include "driveline/esi/sii.hpp"
#include "started_line.hpp"
#include "support/must.hpp"

namespace driveline::bus_test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

ecat_master::SlaveRef ref_of(ecat_master::Bus& bus, std::size_t position) {
  return ecat_master::survey(bus).value().at(position).ref;
}

std::vector<std::byte> image_of(DriveLine& drives, std::size_t position) {
  const auto image = drives.slave(position).esc().sii().image();
  return {image.begin(), image.end()};
}

TEST(LineSurvey, LeavesARunningLineAsItIs) {
  DriveLine drives(4);
  LineOperation operation(drives);
  ASSERT_TRUE(operation.to_safe_op()) << "no line to look at";
  ecat_master::DirectExchange exchange(drives.line(), drives.clock);
  ecat_master::Bus bus(exchange);
  const auto slaves = must(ecat_master::survey(bus));
  ASSERT_EQ(slaves->size(), 4U);
  for (const auto& slave : *slaves) {
    EXPECT_EQ(slave.al.status.state, wire::AlState::kSafeOp);
    EXPECT_EQ(slave.ref.station, operation.master().slaves()[slave.ref.position].info.ref.station);
    EXPECT_TRUE(ecat_master::read_esc_information(bus, slave.ref));
  }
  std::vector<ecat_master::SlaveRef> refs;
  for (const auto& slave : *slaves) refs.push_back(slave.ref);
  for (const auto& image : ecat_master::read_each_sii(bus, refs)) EXPECT_TRUE(image);
  EXPECT_TRUE(drives.all_in(wire::AlState::kSafeOp));
  operation.start_cycle();
  ASSERT_TRUE(operation.to_op()) << "the look has left something behind";
}

TEST(LineSurvey, GivesAddressesWhereTheyAreMissingOrNotUnique) {
  DriveLine drives(3);
  ecat_master::DirectExchange exchange(drives.line(), drives.clock);
  ecat_master::Bus bus(exchange);
  const auto first = must(ecat_master::survey(bus));
  std::set<std::uint16_t> stations;
  for (const auto& slave : *first) stations.insert(slave.ref.station);
  EXPECT_EQ(stations.size(), 3U);
  EXPECT_EQ(stations.count(0), 0U);
  ASSERT_TRUE(bus.write((*first)[2].ref, wire::reg::kStationAddress, (*first)[0].ref.station));
  const auto second = must(ecat_master::survey(bus));
  EXPECT_NE((*second)[0].ref.station, (*second)[2].ref.station);
}

TEST(LineSurvey, SaysWhatTheControllerIs) {
  DriveLine drives(2);
  ecat_master::DirectExchange exchange(drives.line(), drives.clock);
  ecat_master::Bus bus(exchange);
  const auto last = must(ecat_master::read_esc_information(bus, ref_of(bus, 1)));
  EXPECT_EQ(ecat_master::esc_type_name(last->type), "ET1100");
  EXPECT_EQ(last->fmmus, 8);
  EXPECT_EQ(last->sync_managers, 8);
  EXPECT_TRUE(last->dl_status.ports[0].link);
  EXPECT_FALSE(last->dl_status.ports[1].link);  // end of the line
  EXPECT_EQ(last->port_type(0), ecat_master::EscInformation::PortType::kMii);
}

TEST(LineSurvey, OneSlaveWithoutReadableEepromDoesNotHideTheOthers) {
  DriveLine drives(3);
  ecat_master::DirectExchange exchange(drives.line(), drives.clock);
  ecat_master::Bus bus(exchange);
  const auto slaves = must(ecat_master::survey(bus));
  drives.slave(1).esc().sii().set_busy_time(std::chrono::hours{1});
  std::vector<ecat_master::SlaveRef> refs;
  for (const auto& slave : *slaves) refs.push_back(slave.ref);
  const auto images = ecat_master::read_each_sii(bus, refs);
  ASSERT_EQ(images.size(), 3U);
  EXPECT_TRUE(images[0]);
  EXPECT_TRUE(images[2]);
  ASSERT_FALSE(images[1]);
  EXPECT_THAT(sentence(images[1]), HasSubstr("slave 1"));
}

TEST(EepromWrite, NewImageIsThereAfterThePowerCycle) {
  DriveLine drives(2);
  ecat_master::DirectExchange exchange(drives.line(), drives.clock);
  ecat_master::Bus bus(exchange);
  auto image = esi::decode_sii(image_of(drives, 1)).value();
  image.serial_number = 0xCAFE0001;
  image.config.station_alias = 4711;
  image.checksum = esi::sii_checksum(image.config.bytes());
  const auto bytes = esi::encode_sii(image);
  drives.slave(1).esc().sii().set_busy_time(milliseconds{5});
  ASSERT_EQ(failure_text(ecat_master::write_sii(bus, ref_of(bus, 1), bytes)), "");
  EXPECT_EQ(image_of(drives, 1), bytes);
  EXPECT_EQ(ecat_master::survey(bus).value()[1].alias, 0) << "loaded at power-on only";
  drives.line().set_power(1, false);
  drives.leave_alone(milliseconds{10});
  drives.line().set_power(1, true);
  drives.leave_alone(milliseconds{10});
  EXPECT_EQ(ecat_master::survey(bus).value()[1].alias, 4711);
}

TEST(EepromWrite, PowerCutAtAnyWordIsNoticedAtTheNextStart) {
  DriveLine reference(1);
  auto image = esi::decode_sii(image_of(reference, 0)).value();
  image.product_code ^= 0xFFFF;
  image.revision += 1;
  image.standard_mailbox.send_size = 256;
  const auto wanted = esi::encode_sii(image);
  const auto before = image_of(reference, 0);
  // Number of written words, including marker and checksum.
  for (std::size_t cut = 1; cut <= 6; ++cut) {
    DriveLine drives(1);
    ecat_master::DirectExchange exchange(drives.line(), drives.clock);
    ecat_master::Bus bus(exchange);
    const auto report = ecat_master::write_sii(bus, ref_of(bus, 0), wanted, [&](std::size_t done, std::size_t) {
      if (done == cut) drives.line().set_power(0, false);
      return true;
    });
    const auto now = image_of(drives, 0);
    if (now == wanted) continue;  // the power was cut after the last word
    ASSERT_FALSE(report);
    EXPECT_THAT(report.error().left, testing::Not(IsEmpty()));
    EXPECT_EQ(report.error().previous, before);
    drives.line().set_power(0, true);
    drives.leave_alone(milliseconds{10});
    EXPECT_FALSE(drives.slave(0).esc().sii().loaded()) << "a half image passed for a good one after word " << cut;
    // The master reports the wrong checksum, whatever the power cut has done to the identity.
    ScannedMaster master(drives.line(), drives.clock);
    std::vector<ecat_master::SlavePlan> plans(1);
    plans[0].vendor_id = image.vendor_id;
    plans[0].product_code = image.product_code;
    constexpr auto* kSentence =
        "slave 0: EEPROM checksum is 0x[0-9A-F]{2}, 0x[0-9A-F]{2} is expected: the slave ignores the content";
    EXPECT_THAT(sentence(master.configure(plans)), testing::MatchesRegex(kSentence)) << "after word " << cut;
    EXPECT_THAT(sentence(master.configure({})), testing::MatchesRegex(kSentence)) << "after word " << cut;
  }
}

TEST(EepromWrite, AliasOfOneSlaveOnly) {
  DriveLine drives(3);
  ecat_master::DirectExchange exchange(drives.line(), drives.clock);
  ecat_master::Bus bus(exchange);
  ASSERT_TRUE(ecat_master::write_alias(bus, ref_of(bus, 2), 99));
  EXPECT_EQ(esi::decode_sii(image_of(drives, 2)).value().config.station_alias, 99);
  EXPECT_TRUE(esi::decode_sii(image_of(drives, 2)).value().checksum_valid());
  EXPECT_FALSE(drives.slave(0).esc().sii().modified());
  EXPECT_FALSE(drives.slave(1).esc().sii().modified());
}

}  // namespace
}  // namespace driveline::bus_test

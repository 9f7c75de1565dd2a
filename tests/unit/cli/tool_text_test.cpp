// Output of the tools, compared with the columns in the documentation and in users' listings of the IgH tool:
//   slaves:  "0  0:0  OP  +  EK1100 EtherCAT Coupler (2A E-Bus)"
//   pdos:    "SM2: PhysAddr 0x1100, DefaultSize    6, ControlRegister 0x24, Enable 1" / "  RxPDO 0x1600 "..."" /
//            "    PDO entry 0x7000:01,  1 bit, "Set""
//   slaves -v: "  Vendor Id:       0x00000664" ...
#include <gmock/gmock.h>

#include "driveline/esi/sii.hpp"
#include "progress_bar.hpp"
#include "text/pdo_view.hpp"
#include "text/sii_text.hpp"
#include "text/slave_text.hpp"

namespace driveline::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// A terminal with two RxPDOs, one of them with a gap, like those of a Beckhoff stepper terminal.
esi::DeviceDescription terminal() {
  esi::DeviceDescription device;
  device.vendor_id = 2;
  device.product_code = 0x1B773052;
  device.revision = 0x00100000;
  device.name = "EL7031 1K. Schrittmotor";
  device.type = "EL7031";
  device.mailbox.coe = true;
  device.mailbox.coe_sdo_info = true;
  device.sync_managers = {
      {esi::SyncManager::Use::kMailboxOut, 0x1000, 128, 0, 0, 0x26, true},
      {esi::SyncManager::Use::kMailboxIn, 0x1080, 128, 0, 0, 0x22, true},
      {esi::SyncManager::Use::kOutputs, 0x1100, 6, 0, 0, 0x24, true},
  };
  esi::Pdo pdo;
  pdo.index = 0x1600;
  pdo.name = "FB RxPDO-Map Outputs Ch.1";
  pdo.sync_manager = 2;
  pdo.entries = {{0x7000, 1, 1, "Set", esi::DataType::kBoolean},
                 {0, 0, 14, "", esi::DataType::kBoolean},
                 {0x7000, 17, 32, "Value", esi::DataType::kInteger32}};
  device.rx_pdos = {pdo};
  return device;
}

SlaveView view_of(std::uint16_t position, wire::AlState state, bool error, const esi::DeviceDescription& device) {
  SlaveView view;
  view.slave.ref = {position, static_cast<std::uint16_t>(0x1001 + position)};
  view.slave.al.status = {state, error, false};
  view.alias_position = "0:" + std::to_string(position);
  view.sii = esi::make_sii(device);
  return view;
}

TEST(SlaveTable, ColumnsAsUsersKnowThem) {
  const std::vector<SlaveView> slaves = {view_of(0, wire::AlState::kPreOp, false, terminal())};
  EXPECT_EQ(slave_table(slaves), "0  0:0  PREOP  +  EL7031 1K. Schrittmotor\n");
}

TEST(SlaveTable, ErrorsAreFlaggedAndColumnsLineUp) {
  std::vector<SlaveView> slaves = {view_of(0, wire::AlState::kOp, false, terminal()),
                                   view_of(10, wire::AlState::kSafeOp, true, terminal())};
  slaves[1].sii->vendor_id = 0x28;
  slaves[1].sii->product_code = 0x1234;
  slaves[1].sii->categories.clear();
  EXPECT_EQ(slave_table(slaves),
            "0   0:0   OP      +  EL7031 1K. Schrittmotor\n"
            "10  0:10  SAFEOP  E  0x00000028:0x00001234\n");
}

TEST(SlaveTable, TroubleStandsWhereTheNameWould) {
  auto slave = view_of(0, wire::AlState::kInit, false, terminal());
  slave.sii.reset();
  slave.trouble = "EEPROM: the image ends early";
  EXPECT_EQ(slave_table({&slave, 1}), "0  0:0  INIT  +  EEPROM: the image ends early\n");
}

TEST(SlaveDetails, HaveIdentityPortsMailboxesAndSyncManagers) {
  SlaveFacts facts;
  auto& controller = facts.controller;
  controller.type = 0x11;
  controller.port_descriptor = 0x0F;
  controller.features = 0x000C;
  controller.dl_status = wire::DlStatus::from_raw(0x5A33);
  facts.neighbours[0] = 2;
  controller.receive_time_ns = {4294967290, 14, 0, 0};
  const auto text = slave_details(view_of(3, wire::AlState::kPreOp, false, terminal()), facts);
  for (const auto* part :
       {"=== Master 0, Slave 3 ===\n", "State: PREOP\nFlag: +\n", "  Vendor Id:       0x00000002\n",
        "  Product code:    0x1b773052\n", "  Revision number: 0x00100000\n", "  Serial number:   0x00000000\n",
        "  Distributed clocks: yes, 64 bit\n", "Port  Type  Link  Loop    Signal  NextSlave  RxTime [ns]  Diff [ns]\n",
        "   0  MII   up    open    yes             2   4294967290          0\n",
        "   1  MII   up    open    yes             -           14         20\n", "   2  N/A   down  closed  no ",
        "  Supported protocols: CoE\n", "    Enable SDO Info: yes\n", "  Order number: EL7031\n",
        "SM0: PhysAddr 0x1000, DefaultSize  128, ControlRegister 0x26, Enable 1\n"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
}

TEST(PdoText, ThreeLevels) {
  const auto channels = pdos_from_sii(esi::make_sii(terminal()));
  EXPECT_EQ(to_text(channels),
            "SM0: PhysAddr 0x1000, DefaultSize  128, ControlRegister 0x26, Enable 1\n"
            "SM1: PhysAddr 0x1080, DefaultSize  128, ControlRegister 0x22, Enable 1\n"
            "SM2: PhysAddr 0x1100, DefaultSize    6, ControlRegister 0x24, Enable 1\n"
            "  RxPDO 0x1600 \"FB RxPDO-Map Outputs Ch.1\"\n"
            "    PDO entry 0x7000:01,  1 bit, \"Set\"\n"
            "    PDO entry 0x0000:00, 14 bit, \"Gap\"\n"
            "    PDO entry 0x7000:11, 32 bit, \"Value\"\n");
}

TEST(PdoText, OnlyPdosAssignedByDefaultBelongToASyncManager) {
  auto device = terminal();
  device.rx_pdos[0].sync_manager.reset();
  EXPECT_THAT(to_text(pdos_from_sii(esi::make_sii(device))), Not(HasSubstr("RxPDO")));
}

TEST(CppDeclaration, CommentsOfTheSlaveCannotLeaveTheComment) {
  auto device = terminal();
  device.rx_pdos[0].name = "a\\\nint evil;";
  SlavePdos slave{view_of(1, wire::AlState::kPreOp, false, device), PdoSource::kSii, {}};
  slave.sync_managers = pdos_from_sii(*slave.slave.sii);
  const auto text = cpp_declaration(slave);
  EXPECT_THAT(text, HasSubstr("kSlave1Pdos{"));
  EXPECT_THAT(text, HasSubstr("{0x7000, 0x11, 32},  // Value\n"));
  EXPECT_THAT(text, HasSubstr("{0x0000, 0x00, 14},  // gap\n"));
  EXPECT_THAT(text, Not(HasSubstr("\\")));
  EXPECT_THAT(text, Not(HasSubstr("\nint evil")));
}

TEST(AliasPositions, CountFromTheLastAlias) {
  EXPECT_THAT(alias_positions(std::array<std::uint16_t, 6>{0, 0, 7, 0, 0, 9}),
              ElementsAre("0:0", "0:1", "7:0", "7:1", "7:2", "9:0"));
}

TEST(ProtocolNames, OnePerBit) {
  EXPECT_THAT(protocol_names(0x3F), ElementsAre("AoE", "EoE", "CoE", "FoE", "SoE", "VoE"));
  EXPECT_THAT(protocol_names(esi::sii_mailbox::kCoe | esi::sii_mailbox::kFoe), ElementsAre("CoE", "FoE"));
}

TEST(ProgressText, ShowsTheShareAndTheBytes) {
  EXPECT_EQ(progress_text(0, 2048), "[........................................]   0 %  0.0 of 2.0 KiB");
  EXPECT_EQ(progress_text(1024, 2048), "[####################....................]  50 %  1.0 of 2.0 KiB");
  EXPECT_EQ(progress_text(2048, 2048), "[########################################] 100 %  2.0 of 2.0 KiB");
  EXPECT_EQ(progress_text(1536, 0), "1.5 KiB") << "nobody knows how much will come";
}

}  // namespace
}  // namespace driveline::cli

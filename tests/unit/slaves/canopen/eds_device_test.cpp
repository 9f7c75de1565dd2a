// Devices simulated from their EDS or DCF.
#include "driveline/slaves/canopen/eds_device.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "driveline/canopen_wire/nmt.hpp"
#include "driveline/canopen_wire/sdo.hpp"
#include "driveline/slaves/msd/can/can_table.hpp"
#include "support/io_device_eds.hpp"
#include "support/must.hpp"
#include "support/scripted_node.hpp"

namespace driveline::slaves::cia301 {
namespace {

using bytes_test::copy_of;
using bytes_test::hex;
using canopen::Frame;
using test::kIoDeviceEds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using namespace std::chrono_literals;
constexpr auto kIn = SignalId::Direction::kInput;
constexpr auto kOut = SignalId::Direction::kOutput;

std::shared_ptr<const EdsModel> model_of(std::string_view eds) {
  return *must(EdsModel::create(*must(esi::read_eds(eds, "io.eds"))));
}

/// The EDS with one text replaced by another.
std::string with(std::string_view before, std::string_view after) {
  std::string eds(kIoDeviceEds);
  const auto place = eds.find(before);
  if (place == std::string::npos) throw std::logic_error("the EDS has no " + std::string(before));
  return eds.replace(place, before.size(), after);
}

std::string refusal(std::string_view eds) {
  const auto model = EdsModel::create(*must(esi::read_eds(eds, "io.eds")));
  return model ? "" : describe(model.error());
}

/// A device with node-ID 5 and a master.
struct EdsRig {
  explicit EdsRig(std::string_view eds = kIoDeviceEds, EdsDeviceOptions options = {.serial_number = 77})
      : device(model_of(eds), (options.node_id = 5, std::move(options))) {
    bus.attach(master);
    bus.attach(device.device());
    run(2ms);
  }
  void run(nanoseconds time) { bus.advance(bus.now() + time); }
  void send(std::uint32_t identifier, std::string_view payload) {
    master.send_at(bus.now(), Frame::of(identifier, hex(payload)));
    run(1ms);
  }
  void start() { send(0, "01 05"); }
  std::vector<std::vector<std::byte>> payloads(std::uint32_t identifier) const {
    std::vector<std::vector<std::byte>> all;
    for (const auto& one : master.received) {
      if (one.frame.identifier.value == identifier) all.push_back(copy_of(one.frame.payload()));
    }
    return all;
  }
  std::vector<std::byte> ask(std::string_view request) {
    send(0x605, request);
    const auto all = payloads(0x585);
    return all.empty() ? std::vector<std::byte>{} : all.back();
  }

  can::Bus bus;
  can::ScriptedNode master;
  EdsDevice device;
};

TEST(EdsDevice, BootsAndAnswersByItsObjects) {
  EdsRig rig;
  EXPECT_THAT(rig.payloads(0x705), ElementsAre(hex("00")));
  EXPECT_EQ(rig.ask("40 00 10 00 00 00 00 00"), hex("43 00 10 00 91 01 0F 00"));
  EXPECT_EQ(rig.ask("40 18 10 01 00 00 00 00"), hex("43 18 10 01 34 12 00 00"));
  EXPECT_EQ(rig.ask("40 18 10 02 00 00 00 00"), hex("43 18 10 02 01 04 00 00")) << "of [DeviceInfo]";
  EXPECT_EQ(rig.ask("40 18 10 04 00 00 00 00"), hex("43 18 10 04 4D 00 00 00")) << "that of the line";
  EXPECT_EQ(rig.ask("40 14 10 00 00 00 00 00"), hex("43 14 10 00 85 00 00 00")) << "$NODEID";
  EXPECT_EQ(rig.ask("40 08 10 00 00 00 00 00"), hex("41 08 10 00 06 00 00 00"));
  EXPECT_EQ(rig.ask("60 00 00 00 00 00 00 00"), hex("03 49 4F 20 38 2F 38 00"));
  EXPECT_EQ(rig.ask("40 16 10 00 00 00 00 00"), hex("80 16 10 00 00 00 02 06")) << "has no 1016h";
}

TEST(EdsDevice, ItsSerialNumberOutlivesEveryReset) {
  EdsRig rig;
  for (const std::string_view reset : {"82 05", "81 05"}) {
    rig.send(0, reset);
    EXPECT_EQ(rig.ask("40 18 10 04 00 00 00 00"), hex("43 18 10 04 4D 00 00 00")) << reset;
  }
}

TEST(EdsDevice, TypesAccessAndLimitsAreThoseOfTheFile) {
  EdsRig rig;
  EXPECT_EQ(rig.ask("2B 00 20 00 E8 03 00 00"), hex("60 00 20 00 00 00 00 00"));
  EXPECT_EQ(rig.ask("2B 00 20 00 E9 03 00 00"), hex("80 00 20 00 31 00 09 06"));
  EXPECT_EQ(rig.ask("2B 00 20 00 00 00 00 00"), hex("80 00 20 00 32 00 09 06"));
  EXPECT_EQ(rig.ask("23 00 20 00 01 00 00 00"), hex("80 00 20 00 12 00 07 06"));
  EXPECT_EQ(rig.ask("2F 00 60 01 01 00 00 00"), hex("80 00 60 01 02 00 01 06"));
  EXPECT_EQ(rig.ask("40 00 20 00 00 00 00 00"), hex("4B 00 20 00 E8 03 00 00"));
}

TEST(EdsDevice, PdosHaveTheMappingAndTheTypesOfTheFile) {
  EdsRig rig;
  rig.start();
  EXPECT_EQ(rig.device.device().state(), canopen::NmtState::kOperational);
  EXPECT_THAT(rig.payloads(0x185), ElementsAre(hex("00")));
  rig.send(0x205, "A5");
  EXPECT_THAT(rig.payloads(0x185), ElementsAre(hex("00"), hex("A5"))) << "inputs repeat outputs";
  EXPECT_THAT(rig.payloads(0x285), IsEmpty()) << "waits for SYNC";
  rig.send(0x305, "FE FF");
  EXPECT_EQ(rig.device.signal({kOut, 1}), 0.0);
  rig.send(0x080, "");
  EXPECT_EQ(rig.device.signal({kOut, 1}), -2.0);
  rig.send(0x080, "");
  EXPECT_THAT(rig.payloads(0x285), ElementsAre(hex("FE FF"), hex("FE FF"))) << "1401h has a COB-ID by CiA 301";
}

TEST(EdsDevice, HeartbeatAndGuardingByTheObjectsThatExist) {
  EdsRig rig;
  EXPECT_EQ(rig.ask("2B 17 10 00 0A 00 00 00"), hex("60 17 10 00 00 00 00 00"));
  rig.run(31ms);
  EXPECT_THAT(rig.payloads(0x705), ElementsAre(hex("00"), hex("7F"), hex("7F"), hex("7F"), hex("7F")))
      << "at once, and each 10 ms";
}

TEST(EdsDevice, InputsFollowScriptsAndSettings) {
  const auto model = model_of(kIoDeviceEds);
  EdsDeviceOptions options;
  Signal signal;
  signal.shape = Signal::Shape::kSteps;
  signal.steps = {{20ms, 7.0}};
  options.inputs = {{model->entries(kIn)[0].row, signal}};
  can::Bus bus;
  can::ScriptedNode master;
  options.node_id = 5;
  EdsDevice device(model, options);
  bus.attach(master);
  bus.attach(device.device());
  master.send_at(5ms, Frame::of(0, hex("01 05")));
  bus.advance(30ms);
  EXPECT_EQ(device.signal({kIn, 0}), 7.0);
  ASSERT_EQ(master.received.back().frame, Frame::of(0x185, hex("07")));
  EXPECT_EQ(master.received.back().time / 1ms, 20);
  EXPECT_EQ(device.signal_name({kIn, 0}), "Digital inputs/Inputs 1-8");
  EXPECT_EQ(device.find_signal(kIn, "Analog in")->number, 1U);
  EXPECT_EQ(device.find_signal(kIn, "6401:01")->number, 1U);
  EXPECT_EQ(device.find_signal(kOut, "Digital outputs/Outputs 1-8")->number, 0U);
  EXPECT_THAT(describe(device.find_signal(kIn, "Motor").error()), HasSubstr("\"Analog inputs/Analog in\" (6401:01)"));
  EXPECT_FALSE(device.check_signal_value(0, 256.0));
  EXPECT_TRUE(device.check_signal_value(1, -32768.0));
  device.set_signal(0, 9.0);
  bus.advance(31ms);
  EXPECT_EQ(master.received.back().frame, Frame::of(0x185, hex("09")));
  bus.advance(100ms);
  EXPECT_EQ(device.signal({kIn, 0}), 9.0) << "the script has ended";
}

TEST(EdsDevice, StoresParametersWhereItHas1010h) {
  EdsRig rig;
  rig.ask("2B 00 20 00 64 00 00 00");
  EXPECT_EQ(rig.ask("23 10 10 01 73 61 76 65"), hex("60 10 10 01 00 00 00 00"));
  EXPECT_EQ(rig.ask("40 10 10 01 00 00 00 00"), hex("43 10 10 01 01 00 00 00")) << "what it can, not the signature";
  rig.ask("2B 00 20 00 65 00 00 00");
  rig.device.restart();
  rig.run(5ms);
  EXPECT_EQ(rig.ask("40 00 20 00 00 00 00 00"), hex("4B 00 20 00 64 00 00 00"));
  EXPECT_EQ(rig.ask("40 00 14 01 00 00 00 00"), hex("43 00 14 01 05 02 00 00"));
}

TEST(EdsDevice, ValuesOfADcfReplaceTheDefaults) {
  auto dcf = with("DefaultValue=10\n", "DefaultValue=10\nParameterValue=33\n");
  const std::string cob_id = "DefaultValue=$NODEID+0x200\n";
  dcf.replace(dcf.find(cob_id), cob_id.size(), cob_id + "ParameterValue=0x345\n");
  EdsRig rig(dcf);
  EXPECT_EQ(rig.ask("40 00 20 00 00 00 00 00"), hex("4B 00 20 00 21 00 00 00"));
  EXPECT_EQ(rig.ask("40 00 14 01 00 00 00 00"), hex("43 00 14 01 45 03 00 00")) << "without the node-ID";
}

TEST(EdsDevice, TheEdsOfADriveOfOurs) {
  const auto eds = esi::write_eds(msd::can_description(msd::Variant::kMsd), "msd.eds");
  EdsRig rig(eds);
  EXPECT_EQ(rig.ask("40 00 10 00 00 00 00 00"), hex("43 00 10 00 92 01 02 00"));
  EXPECT_EQ(rig.ask("40 00 14 01 00 00 00 00"), hex("43 00 14 01 05 02 00 00"));
  for (const std::string_view request :
       {"23 00 14 01 05 02 00 80", "23 00 16 01 10 00 40 60", "2F 00 16 00 01 00 00 00", "23 00 14 01 05 02 00 00",
        "23 00 18 01 85 01 00 80", "23 00 1A 01 10 00 41 60", "2F 00 1A 00 01 00 00 00", "2F 00 18 02 01 00 00 00",
        "23 00 18 01 85 01 00 00"}) {
    EXPECT_EQ(rig.ask(request)[0], std::byte{0x60}) << request;
  }
  rig.start();
  for (const std::string_view word : {"06 00", "07 00", "0F 00"}) {
    rig.send(0x205, word);
    rig.run(5ms);
  }
  rig.send(0x080, "");
  ASSERT_THAT(rig.payloads(0x185), testing::SizeIs(1));
  EXPECT_EQ(rig.payloads(0x185)[0][0] & std::byte{0x6F}, std::byte{0x27}) << "an ideal drive is enabled";
}

TEST(EdsDevice, WhatCannotBeSimulatedIsSaid) {
  EXPECT_THAT(refusal(with("DefaultValue=0x62000108", "DefaultValue=0x62000110")),
              HasSubstr("the default mapping 1600h is not possible"))
      << "16 bits of 8";
  EXPECT_THAT(refusal(with("DefaultValue=0x62000108", "DefaultValue=0x62010108")), HasSubstr("1600h"));
  EXPECT_THAT(refusal(with("DefaultValue=0x62000108", "DefaultValue=0x16000120")), HasSubstr("1600h")) << "itself";
  EXPECT_THAT(
      refusal(with("[1017]\nParameterName=Heartbeat\nDataType=6", "[1017]\nParameterName=Heartbeat\nDataType=9")),
      HasSubstr("its 1017h:00 is a text or a domain, a number is expected"));
  EXPECT_THAT(refusal(with("2=0x2001\n", "2=0x2001\n3=0x15FF\n[15FF]\nParameterName=x\nDataType=7\n")),
              HasSubstr("it has the PDO 15FFh, the simulation has 128 PDOs of each direction"));
  EXPECT_EQ(refusal(kIoDeviceEds), "");
}

}  // namespace
}  // namespace driveline::slaves::cia301

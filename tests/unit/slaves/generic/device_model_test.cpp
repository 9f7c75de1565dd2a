#include "device_bench.hpp"

namespace driveline::slaves::generic {
namespace {

using testing::HasSubstr;

/// The minimum content of a file: a type, and PDOs or a mailbox.
esi::DeviceDescription bare_device() {
  esi::DeviceDescription device;
  device.vendor_id = 1;
  device.product_code = 2;
  device.type = "Bare";
  return device;
}

esi::Pdo pdo(std::uint16_t index, std::uint8_t bits) {
  return {index, "PDO", false, false, std::nullopt, {{0x6000, 1, bits, "Entry", esi::DataType::kUnsigned8}}};
}

TEST(CompleteDescription, MakesWhatTheFileLeavesOut) {
  auto device = bare_device();
  device.mailbox.coe = true;
  device.rx_pdos = {pdo(0x1600, 8)};
  device.tx_pdos = {pdo(0x1A00, 12)};
  device = complete_description(device);
  ASSERT_EQ(device.sync_managers.size(), 4U);
  EXPECT_EQ(device.sync_managers[0].start_address, 0x1000);
  EXPECT_EQ(device.sync_managers[1].start_address, 0x1080);
  EXPECT_EQ(device.sync_managers[2].start_address, 0x1100);
  EXPECT_EQ(device.sync_managers[3].start_address, 0x1104);  // after three buffers of a byte, on an even address
  EXPECT_EQ(device.sync_managers[2].control, 0x64);
  EXPECT_EQ(device.sync_managers[3].control, 0x00);  // three buffers, read by the master
  EXPECT_EQ(device.sync_managers[3].default_size, 2);
  EXPECT_EQ(device.rx_pdos[0].sync_manager, 2);
  EXPECT_EQ(device.tx_pdos[0].sync_manager, 3);
  EXPECT_EQ(device.fmmus.size(), 3U);
}

TEST(CompleteDescription, LeavesWhatIsThere) {
  for (const char* name : {"BC100", "DI8", "AI2", "MX4"}) {
    EXPECT_EQ(complete_description(example(name)), example(name)) << name;
  }
}

TEST(CompleteDescription, ABareDeviceRuns) {
  auto device = bare_device();
  device.mailbox.coe = true;
  device.rx_pdos = {pdo(0x1600, 8)};
  device.tx_pdos = {pdo(0x1A00, 8)};
  DeviceBench bench(device);
  bench.go_to_op();
  for (int i = 0; i < 3; ++i) bench.exchange(bytes({0x5A}), 3);
  EXPECT_EQ(bench.exchange(bytes({0x5A}), 3), bytes({0x5A}));
  auto plain = bare_device();
  plain.tx_pdos = {pdo(0x1A00, 8)};
  DeviceBench without_mailbox(plain);
  EXPECT_TRUE(without_mailbox.slave().esc().device_emulation());
  without_mailbox.go_to_op();
}

TEST(DeviceModel, FindsInputsByNamePdoOrAddress) {
  const auto model = model_of(example("AI2"));
  EXPECT_EQ(*model->find_input("Channel 2/Value"), model->table().find(0x6010, 17));
  EXPECT_EQ(*model->find_input("6010:11"), model->table().find(0x6010, 17));
  EXPECT_EQ(*model->find_input("0x6010:0x11"), model->table().find(0x6010, 17));
  EXPECT_EQ(*model->find_input("Toggle"), model->table().find(0x1800, 9));
}

TEST(DeviceModel, SaysWhichInputsThereAre) {
  const auto model = model_of(example("AI2"));
  EXPECT_THAT(
      describe(model->find_input("Vlaue").error()),
      HasSubstr("is no input of the device; there are \"Channel 1/Underrange\" (6000:01), \"Channel 1/Overrange\""));
  EXPECT_EQ(describe(model->find_input("Value").error()),
            "is not a unique name; there are \"Channel 1/Value\" (6000:11), \"Channel 2/Value\" (6010:11)");
  EXPECT_EQ(describe(model_of(example("DO4"))->find_input("Output").error()),
            "is no input of the device; the device has no inputs");
}

TEST(DeviceModel, AnEntryOfNoBitsIsNoInput) {
  auto device = example("AI2");
  for (auto& pdo : device.tx_pdos) {
    for (auto& entry : pdo.entries) {
      if (entry.index == 0x6010 && entry.subindex == 0x11) entry.bit_length = 0;
    }
  }
  const auto model = model_of(device);
  for (const char* name : {"Channel 2/Value", "6010:11"}) {
    const auto found = model->find_input(name);
    ASSERT_FALSE(found) << name;
    EXPECT_THAT(describe(found.error()), testing::StartsWith("is no input of the device; there are ")) << name;
  }
  EXPECT_TRUE(model->find_input("Channel 1/Value"));
}

TEST(DeviceModel, ChecksSignals) {
  const auto model = model_of(example("AI2"));
  const auto* value = *model->find_input("Channel 1/Value");
  EXPECT_TRUE(check_signal(*value, {Signal::Shape::kSine, -32768, 32767, 1s}));
  EXPECT_EQ(describe(check_signal(*value, {Signal::Shape::kSine, -32769, 0, 1s}).error()),
            "-32769 does not fit the 16 bits of the entry, -32768 to 32767 do");
  const auto* limit = *model->find_input("Channel 1/Limit");
  EXPECT_EQ(describe(check_signal(*limit, {Signal::Shape::kToggle, 0, 4, 1s}).error()),
            "4 does not fit the 2 bits of the entry, 0 to 3 do");
  EXPECT_TRUE(check_signal(*limit, {Signal::Shape::kConstant, 3, 4, 1s})) << "a constant has one value";
  const auto mixed = model_of(example("MX4"));
  EXPECT_EQ(describe(check_signal(**mixed->find_input("Text"), {}).error()), "the entry is not a number");
}

TEST(DeviceModel, RefusesWhatNoControllerHolds) {
  auto device = bare_device();
  device.sync_managers.resize(17);
  EXPECT_EQ(describe(DeviceModel::create(device).error()),
            "it has 17 sync managers, a slave controller has at most 16");
  device.sync_managers.resize(1);
  device.sync_managers[0] = {Use::kInputs, 0xFF00, 200, 0, 0, 0x20, true};
  EXPECT_EQ(describe(DeviceModel::create(device).error()),
            "sync manager 0 from 0xFF00 needs memory up to 0x10157, memory ends at 0xFFFF");
}

TEST(DeviceModel, GetsTheMemoryItsSyncManagersNeed) {
  auto device = bare_device();
  device.sync_managers = {{Use::kInputs, 0x3000, 1400, 0, 0, 0x20, true}};
  EXPECT_EQ(model_of(device)->ram_kib(), 13U);  // 8 KiB and 4200 bytes
}

}  // namespace
}  // namespace driveline::slaves::generic

// Devices from an ESI file, operated through their slave controller: with or without mailbox, inputs only, outputs
// only, entries smaller than a byte and across byte borders, several sync managers per direction.
#include "device_bench.hpp"

namespace driveline::slaves::generic {
namespace {

TEST(GenericDevice, ACouplerHasNoProcessData) {
  DeviceBench bench(example("BC100"));
  EXPECT_EQ(bench.description().revision, 0x00020000U);
  EXPECT_TRUE(bench.slave().esc().device_emulation());
  bench.go_to_op();
  EXPECT_EQ(bench.output_bytes() + bench.input_bytes(), 0U);
}

TEST(GenericDevice, AnswersForAnIdOnlyWhereItsFileAnnouncesOne) {
  for (const bool announced : {false, true}) {
    auto description = example("AI2");
    description.identification = announced;
    DeviceBench bench(description);
    EXPECT_EQ(bench.description().identification, announced) << "in the EEPROM";
    bench.write(wire::reg::kAlControl.address, bytes({0x21, 0x00}));
    EXPECT_EQ(bench.read(wire::reg::kAlStatus.address, 1), bytes({announced ? 0x21U : 0x01U}));
  }
}

TEST(GenericDevice, InputsOnlyWithScriptedBits) {
  const auto model = model_of(example("DI8"));
  GenericOptions options;
  options.inputs = {script(*model, "Channel 1/Input", {Signal::Shape::kConstant, 1.0, 0.0, 1s}),
                    script(*model, "6070:01", {Signal::Shape::kToggle, 0.0, 1.0, 1ms})};
  DeviceBench bench(model, options);
  bench.go_to_op();
  ASSERT_EQ(bench.input_bytes(), 1U);
  ASSERT_EQ(bench.output_bytes(), 0U);
  std::vector<unsigned> seen;
  for (int i = 0; i < 16; ++i) {
    const auto data = bench.exchange({}, 1);
    seen.push_back(std::to_integer<unsigned>(data[0]));
  }
  EXPECT_THAT(seen, testing::Each(testing::AnyOf(0x01U, 0x81U)));
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 0x81U), 8) << "half of two periods of eight steps";
}

TEST(GenericDevice, OutputsOnlyOnTheDigitalOutputRegister) {
  DeviceBench bench(example("DO4"));
  bench.go_to_op();
  ASSERT_EQ(bench.output_bytes(), 1U);
  ASSERT_EQ(bench.input_bytes(), 0U);
  bench.exchange(bytes({0x0A}), 2);
  const auto value = [&](std::uint16_t index) {
    return bench.device().dictionary().raw(*bench.device().model().table().find(index, 1));
  };
  EXPECT_EQ(value(0x7000), 0U);
  EXPECT_EQ(value(0x7010), 1U);
  EXPECT_EQ(value(0x7020), 0U);
  EXPECT_EQ(value(0x7030), 1U);
}

TEST(GenericDevice, InputsBehindAMailboxWithGapsAndSignedValues) {
  const auto model = model_of(example("AI2"));
  GenericOptions options;
  options.inputs = {script(*model, "Channel 1/Value", {Signal::Shape::kConstant, -2.0, 0.0, 1s}),
                    script(*model, "Channel 2/Limit", {Signal::Shape::kConstant, 2.0, 0.0, 1s}),
                    script(*model, "Toggle", {Signal::Shape::kConstant, 1.0, 0.0, 1s})};
  DeviceBench bench(model, options);
  bench.go_to_op();
  EXPECT_EQ(bench.exchange({}, 1), bytes({0x00, 0x80, 0xFE, 0xFF, 0x08, 0x00, 0x00, 0x00}));
}

TEST(GenericDevice, TwoSyncManagersEachWayLoopedBack) {
  DeviceBench bench(example("MX4"));
  bench.go_to_op();
  ASSERT_EQ(bench.output_bytes(), 9U);
  ASSERT_EQ(bench.input_bytes(), 9U);
  // Enable 1, Select 5, Setpoint 0x8123 from bit 4, gap, Text; Code 0x42, Fast setpoint 0xBEEF
  const auto outputs = bytes({0x3B, 0x12, 0x08, 'a', 'b', 'c', 0x42, 0xEF, 0xBE});
  bench.exchange(outputs, 3);  // 1 for the inputs, 2 for the outputs
  bench.exchange(outputs, 3);
  // Selected in bits 0-2, Actual value from bit 3, Enabled in bit 19, gap, Text; Code, Fast value
  EXPECT_EQ(bench.exchange(outputs, 3), bytes({0x1D, 0x09, 0x0C, 'a', 'b', 'c', 0x42, 0xEF, 0xBE}));
}

TEST(GenericDevice, ScriptedInputsAreNotLoopedBack) {
  const auto model = model_of(example("MX4"));
  GenericOptions options;
  options.inputs = {script(*model, "Actual value", {Signal::Shape::kConstant, 100.0, 0.0, 1s})};
  DeviceBench bench(model, options);
  bench.go_to_op();
  const auto outputs = bytes({0x3B, 0x12, 0x08, 0, 0, 0, 0x42, 0xEF, 0xBE});
  for (int i = 0; i < 3; ++i) bench.exchange(outputs, 3);
  const auto inputs = bench.exchange(outputs, 3);
  EXPECT_EQ(bytes::load_le<std::uint32_t>(inputs) >> 3 & 0xFFFF, 100U);
  // The next input of 16 bits then repeats the first output of 16 bits.
  EXPECT_EQ(bytes::load_le<std::uint16_t>(std::span(inputs).subspan(7)), 0x8123U);
}

TEST(GenericDevice, WithoutLoopBackInputsStayAtTheirDefaults) {
  GenericOptions options;
  options.loop_back = false;
  DeviceBench bench(example("MX4"), options);
  bench.go_to_op();
  const auto outputs = bytes({0xFF, 0xFF, 0x0F, 1, 2, 3, 4, 5, 6});
  for (int i = 0; i < 3; ++i) bench.exchange(outputs, 3);
  EXPECT_EQ(bench.exchange(outputs, 3), std::vector<std::byte>(9));
}

TEST(GenericDevice, OutputsBecomeZeroWhenTheWatchdogTakesItOutOfOp) {
  DeviceBench bench(example("MX4"));
  bench.go_to_op();
  const auto outputs = bytes({0x3B, 0x12, 0x08, 'a', 'b', 'c', 0x42, 0xEF, 0xBE});
  for (int i = 0; i < 3; ++i) bench.exchange(outputs, 3);
  bench.pass(200ms);
  EXPECT_EQ(bench.status().state, AlState::kSafeOp);
  EXPECT_EQ(bench.code(), AlStatusCode::kSyncManagerWatchdog);
  EXPECT_EQ(bench.device().dictionary().raw(*bench.device().model().table().find(0x7010, 2)), 0U);
}

TEST(GenericDevice, WrongLengthsAreRefusedPerSyncManager) {
  DeviceBench bench(example("MX4"));
  bench.enter_pre_op();
  bench.map_process_data();
  bench.set_sync_manager(4, 0);  // enabled ones are locked
  bench.set_sync_manager(4, 2);  // the second output sync manager is three bytes long
  bench.request(AlState::kSafeOp);
  EXPECT_EQ(bench.code(), AlStatusCode::kInvalidOutputConfiguration);
  for (const unsigned n : {4U, 5U}) bench.set_sync_manager(n, 0);
  bench.set_sync_manager(4, 3);
  bench.set_sync_manager(5, 4);
  const auto raw = bytes::to_le_bytes(wire::AlControl{AlState::kSafeOp, true, false}.raw());
  bench.write(wire::reg::kAlControl.address, {raw.begin(), raw.end()});
  EXPECT_EQ(bench.code(), AlStatusCode::kInvalidInputConfiguration);
}

/// A device whose EEPROM has sync manager lengths but no PDOs accepts these lengths, or none.
TEST(GenericDevice, WithoutKnownPdosTheLengthsOfTheEepromAreTaken) {
  esi::DeviceDescription device;
  device.type = "Bare";
  device.vendor_id = 1;
  device.product_code = 2;
  device.mailbox.coe = true;  // with an application, which checks the master's settings
  struct Length {
    Use use;
    std::uint16_t bytes;
  };
  for (const auto& length : {Length{Use::kMailboxOut, 128}, Length{Use::kMailboxIn, 128}, Length{Use::kOutputs, 12},
                             Length{Use::kInputs, 20}}) {
    esi::SyncManager manager;
    manager.use = length.use;
    manager.enable = true;
    manager.default_size = length.bytes;
    device.sync_managers.push_back(manager);
  }
  struct Case {
    std::uint16_t outputs;
    std::uint16_t inputs;
    AlStatusCode code;
  };
  for (const auto& c : {Case{12, 20, AlStatusCode::kNoError}, Case{0, 0, AlStatusCode::kNoError},
                        Case{11, 20, AlStatusCode::kInvalidOutputConfiguration},
                        Case{12, 21, AlStatusCode::kInvalidInputConfiguration}}) {
    DeviceBench bench(device);
    bench.enter_pre_op();
    bench.set_sync_manager(2, c.outputs);
    bench.set_sync_manager(3, c.inputs);
    bench.request(AlState::kSafeOp);
    EXPECT_EQ(bench.code(), c.code) << c.outputs << ", " << c.inputs;
    EXPECT_EQ(bench.status().state, c.code == AlStatusCode::kNoError ? AlState::kSafeOp : AlState::kPreOp);
  }
}

TEST(GenericDevice, IsWhatItsEepromSays) {
  GenericOptions options;
  options.serial_number = 4711;
  for (const char* name : {"BC100", "DI8", "DO4", "AI2", "MX4"}) {
    DeviceBench bench(example(name), options);
    const auto expected = example(name);
    EXPECT_EQ(bench.description().vendor_id, 0xE0000DD1U);
    EXPECT_EQ(bench.description().product_code, expected.product_code);
    EXPECT_EQ(bench.description().serial_number, 4711U);
    EXPECT_EQ(bench.description().type, name);
    EXPECT_EQ(bench.description().tx_pdos.size(), expected.tx_pdos.size());
    EXPECT_EQ(bench.slave().esc().pdi_operational(), true) << "the checksum is right";
  }
}

TEST(GenericDevice, RunsFromAnEepromImageAlone) {
  const auto image = esi::encode_sii(esi::make_sii(complete_description(example("MX4"))));
  auto decoded = esi::decode_sii(image);
  ASSERT_TRUE(decoded);
  GenericOptions options;
  options.sii_image = image;
  DeviceBench bench(esi::description_from_sii(*decoded), options);
  bench.go_to_op();
  const auto outputs = bytes({0x3B, 0x12, 0x08, 'a', 'b', 'c', 0x42, 0xEF, 0xBE});
  for (int i = 0; i < 3; ++i) bench.exchange(outputs, 3);
  EXPECT_EQ(bench.exchange(outputs, 3), bytes({0x1D, 0x09, 0x0C, 'a', 'b', 'c', 0x42, 0xEF, 0xBE}));
}

}  // namespace
}  // namespace driveline::slaves::generic

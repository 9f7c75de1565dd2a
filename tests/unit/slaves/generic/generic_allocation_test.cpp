// The cycle of a device must not allocate, free or lock. A separate program, because the guard replaces malloc.
#include "device_bench.hpp"
#include "driveline/rt_guard/rt_guard.hpp"

namespace driveline::slaves::generic {
namespace {

TEST(GenericAllocation, NoneInTenThousandCyclesWithScriptsLoopBackSdoAndFallBack) {
  const auto model = model_of(example("MX4"));
  GenericOptions options;
  options.inputs = {script(*model, "Fast value", {Signal::Shape::kSine, 0.0, 60000.0, 100ms})};
  GenericDevice device(model, options);
  for (const auto to : {AlState::kPreOp, AlState::kSafeOp, AlState::kOp}) {
    ASSERT_EQ(device.transition(to == AlState::kPreOp    ? AlState::kInit
                                : to == AlState::kSafeOp ? AlState::kPreOp
                                                         : AlState::kSafeOp,
                                to),
              AlStatusCode::kNoError);
  }
  auto outputs = bytes({0x3B, 0x12, 0x08, 'a', 'b', 'c'});
  std::vector<std::byte> inputs(6);
  std::vector<std::byte> fast(3);
  auto request = bytes({10, 0, 0, 0, 0, 0x13, 0x00, 0x20, 0x40, 0x00, 0x60, 4, 0, 0, 0, 0});  // upload of a text
  std::array<std::byte, 256> reply{};
  if (!rt::RtGuard::available()) GTEST_SKIP() << "a sanitizer owns malloc; the guard counts nothing here";
  std::size_t answers = 0;
  std::chrono::nanoseconds now{0};
  rt::RtGuard::enter();
  for (unsigned i = 0; i < 10'000; ++i) {
    outputs[3] = static_cast<std::byte>('a' + i % 26);
    device.write_outputs(2, outputs);
    device.advance(now += device.process_data_period());
    device.read_inputs(3, inputs);
    device.read_inputs(5, fast);
    request[5] = static_cast<std::byte>(0x03 | (i % 7 + 1) << 4);
    device.mailbox_request(request);
    if (device.mailbox_reply(reply) != 0) ++answers;
    if (i % 1000 == 900) device.fall_back(AlState::kOp, AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
    if (i % 1000 == 901) static_cast<void>(device.transition(AlState::kSafeOp, AlState::kOp));
  }
  EXPECT_EQ(rt::RtGuard::leave().total(), 0U);
  EXPECT_EQ(answers, 10'000U);
  EXPECT_EQ(inputs[3], outputs[3]);
}

}  // namespace
}  // namespace driveline::slaves::generic

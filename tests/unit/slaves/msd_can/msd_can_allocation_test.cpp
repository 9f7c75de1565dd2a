// A drive on a CAN bus allocates only when it is made and when it is restarted. A separate program, because the guard
// replaces malloc.
#include "can_drive_rig.hpp"
#include "driveline/rt_guard/rt_guard.hpp"

namespace driveline::slaves::msd {
namespace {

/// A master that sends SDOs, PDOs and SYNCs, and remembers nothing.
class BusyMaster : public can::Node {
 public:
  void connected(can::Controller& controller) override { controller_ = &controller; }
  void receive(const Frame& /*frame*/, std::chrono::nanoseconds /*now*/) override { ++received; }
  void advance(std::chrono::nanoseconds now) override {
    next_ = now + 500us;
    const unsigned step = step_++;
    if (step % 4 == 0) {
      setpoint_ += 300;
      controller_->send(Frame::of(0x30C, bytes::to_le_bytes(setpoint_)));
      controller_->send(Frame::of(0x080, {}));
    } else if (step % 4 == 1) {
      const std::uint16_t word = step % 4000 < 3800 ? 0x1F : step % 4000 < 3900 ? 0x80 : 0x07;
      controller_->send(Frame::of(0x20C, bytes::to_le_bytes(word)));
    } else if (step % 4 == 2) {
      controller_->send(Frame::of(0x60C, std::array{std::byte{0x40}, std::byte{0x03}, std::byte{0x20}, std::byte{0},
                                                    std::byte{0}, std::byte{0}, std::byte{0}, std::byte{0}}));
    } else {
      const auto command = static_cast<std::byte>(step % 8 == 3 ? 0x60 : 0x70);
      controller_->send(Frame::of(0x60C, std::array{command, std::byte{0}, std::byte{0}, std::byte{0}, std::byte{0},
                                                    std::byte{0}, std::byte{0}, std::byte{0}}));
    }
  }
  [[nodiscard]] std::chrono::nanoseconds next_wake() const noexcept override { return next_; }
  void begin(std::chrono::nanoseconds at) { next_ = at; }

  std::uint64_t received = 0;

 private:
  can::Controller* controller_ = nullptr;
  std::chrono::nanoseconds next_ = can::kNever;
  unsigned step_ = 0;
  std::uint32_t setpoint_ = 0;
};

TEST(MsdCanAllocation, NoneInTenSecondsOfTrafficWithFaults) {
  if (!rt::RtGuard::available()) GTEST_SKIP() << "a sanitizer owns malloc; the guard counts nothing here";
  CanDriveRig rig;
  BusyMaster busy;
  rig.bus.attach(busy);
  rig.run(5ms);
  ASSERT_EQ(rig.write_real(0x2132, 2.0F), 0U);
  ASSERT_EQ(rig.write(0x1006, 0, 2000, 4), 0U);
  ASSERT_EQ(rig.write(0x60C2, 1, 2, 1), 0U);
  ASSERT_EQ(rig.write(0x6060, 0, 7, 1), 0U);
  rig.map(0x1401, {0x60C1'0120}, 1);
  rig.map(0x1800, {0x6041'0010, 0x6064'0020}, 1);
  rig.map(0x1801, {0x2177'0020, 0x6041'0010});
  rig.operate();
  rig.enable();
  rig.master.received.reserve(200'000);
  rig.master.sent.reserve(1000);
  busy.begin(rig.bus.now() + 1ms);
  rt::RtGuard::enter();
  for (int i = 0; i < 10'000; ++i) {
    rig.bus.advance(rig.bus.now() + 1ms);
    if (i % 1000 == 777) rig.drive.core().raise(Fault::kEncoder);
  }
  EXPECT_EQ(rt::RtGuard::leave().total(), 0U);
  EXPECT_GT(busy.received, 10'000U);
  EXPECT_EQ(rig.value(0x1003), 1U) << "the faults did happen";
}

}  // namespace
}  // namespace driveline::slaves::msd

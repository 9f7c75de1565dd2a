// A device and its bus allocate only when they are made. A separate program, because the guard replaces malloc.
#include "device_rig.hpp"
#include "driveline/rt_guard/rt_guard.hpp"

namespace driveline::slaves::cia301 {
namespace {

/// A master that sends what a device can take, and remembers nothing.
class TirelessMaster : public can::Node {
 public:
  void connected(can::Controller& controller) override { controller_ = &controller; }
  void receive(const Frame& /*frame*/, nanoseconds /*now*/) override { ++received; }
  void advance(nanoseconds now) override {
    next_ = now + 500us;
    const auto send = [&](std::uint32_t identifier, std::string_view payload) {
      Frame frame{{identifier, false}};
      for (std::size_t i = 0; i + 1 < payload.size(); i += 3) {
        const auto digit = [](char c) { return static_cast<unsigned>(c <= '9' ? c - '0' : c - 'A' + 10); };
        frame.data.at(frame.length++) = static_cast<std::byte>(digit(payload[i]) << 4 | digit(payload[i + 1]));
      }
      controller_->send(frame);
    };
    switch (step_++ % 12) {
      case 0:
        return send(0x605, "40 03 20 00 00 00 00 00");
      case 1:
        return send(0x605, "60 00 00 00 00 00 00 00");
      case 2:
        return send(0x605, "21 03 20 00 60 00 00 00");
      case 3:
        return send(0x605, "00 31 32 33 34 35 36 37");
      case 4:
        return send(0x605, "2F 00 16 00 00 00 00 00");
      case 5:
        return send(0x605, "23 10 10 01 73 61 76 65");
      case 6:
        return send(0x205, "34 12");
      case 7:
        return send(0x080, "");
      case 8:
        return send(0x605, "2B 17 10 00 07 00 00 00");
      case 9:
        return send(0x000, step_ % 5 == 0 ? "82 05" : "01 05");
      case 10:
        return send(0x709, "05");
      default:
        static_cast<void>(controller_->send(Frame::remote({0x185, false}, 1)));
    }
  }
  [[nodiscard]] nanoseconds next_wake() const noexcept override { return next_; }

  std::uint64_t received = 0;

 private:
  can::Controller* controller_ = nullptr;
  nanoseconds next_{1'000'000};
  unsigned step_ = 0;
};

class QuietApplication : public Application {
 public:
  [[nodiscard]] SdoResult<void> accept(const EntryRow& /*row*/, std::uint64_t /*raw*/) override { return {}; }
  void written(const EntryRow& /*row*/) override {}
  [[nodiscard]] bool power_stage_on() const noexcept override { return false; }
  [[nodiscard]] std::uint8_t node_id(Reset /*reset*/) override { return 5; }
};

TEST(CanopenAllocation, NoneInTenSecondsOfTraffic) {
  if (!rt::RtGuard::available()) GTEST_SKIP() << "a sanitizer owns malloc; the guard counts nothing here";
  can::Bus bus;
  ObjectDictionary dictionary(sample_table());
  QuietApplication application;
  Device device(dictionary, application, {.block_transfer = true});
  TirelessMaster master;
  bus.attach(master);
  bus.attach(device);
  bus.advance(1ms);
  rt::RtGuard::enter();
  for (int i = 0; i < 10'000; ++i) {
    bus.advance(bus.now() + 1ms);
    if (i % 100 == 7) device.raise({0x4310, 8, {}}, bus.now());
    if (i % 100 == 57) device.clear(0x4310, bus.now());
  }
  EXPECT_EQ(rt::RtGuard::leave().total(), 0U);
  EXPECT_GT(master.received, 10'000U);
}

}  // namespace
}  // namespace driveline::slaves::cia301

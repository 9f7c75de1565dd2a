#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

#include "bench_slave.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/slaves/line/simulated_line.hpp"
#include "driveline/wire/frame.hpp"

namespace driveline::slaves::test {

inline constexpr wire::MacAddress kMac{std::byte{0x00}, std::byte{0x11}, std::byte{0x22},
                                       std::byte{0x33}, std::byte{0x44}, std::byte{0x55}};

/// A line of test devices on a virtual clock, and a master that sends frame by frame.
class LineTest : public ::testing::Test {
 protected:
  void build(std::size_t count, const LineOptions& options = {}, std::optional<Wiring> wiring = std::nullopt,
             const std::vector<SlaveOptions>& slave_options = {}) {
    std::vector<std::unique_ptr<Slave>> slaves;
    devices_.clear();
    for (std::size_t i = 0; i < count; ++i) {
      auto device = std::make_unique<TestDevice>();
      devices_.push_back(device.get());
      device->own_profile.distributed_clock = without_clock != i;
      const auto options_of_slave = i < slave_options.size() ? slave_options[i] : SlaveOptions{};
      slaves.push_back(std::make_unique<Slave>(std::move(device), options_of_slave));
    }
    line_ = std::make_unique<SimulatedLine>(clock_, std::move(slaves), options, std::move(wiring));
  }
  /// Position of the slave without a distributed clock.
  std::optional<std::size_t> without_clock;

  SimulatedLine& line() { return *line_; }
  rt::VirtualClock& clock() { return clock_; }
  TestDevice& device(std::size_t position) { return *devices_[position]; }

  struct Reply {
    std::vector<std::byte> frame;
    std::vector<std::byte> data;
    std::uint16_t working_counter = 0;
    std::uint16_t adp = 0;
    std::uint16_t irq = 0;
    bool circulating = false;
  };

  static std::vector<std::byte> make_frame(Command command, wire::DatagramAddress address,
                                           const std::vector<std::byte>& data) {
    std::vector<std::byte> buffer(port::kMaxFrameBytes);
    wire::FrameBuilder builder(buffer, kMac);
    const auto place = builder.add(command, 0x5A, address, data.size()).value();
    std::copy(data.begin(), data.end(), builder.data(place).begin());
    const auto frame = builder.finish();
    return {frame.begin(), frame.end()};
  }
  static Reply parse(std::span<const std::byte> frame) {
    Reply reply;
    reply.frame.assign(frame.begin(), frame.end());
    auto cursor = wire::DatagramCursor::open(frame);
    EXPECT_TRUE(cursor);
    const auto view = cursor->next();
    EXPECT_TRUE(view);
    reply.data.assign(view->data.begin(), view->data.end());
    reply.working_counter = view->working_counter();
    reply.adp = view->header.address.adp();
    reply.irq = view->header.irq;
    reply.circulating = view->header.circulating;
    return reply;
  }
  /// Sends a frame and waits up to 1 ms for it; nothing: it did not return.
  std::optional<Reply> exchange(std::span<const std::byte> frame, port::Port& out, port::Port& in) {
    EXPECT_EQ(out.send(frame), port::SendStatus::kSent);
    if (!in.wait_readable(clock_.now() + 1ms)) return std::nullopt;
    const auto received = in.receive();
    if (!received) return std::nullopt;
    return parse(received->bytes);
  }
  std::optional<Reply> exchange(Command command, wire::DatagramAddress address, const std::vector<std::byte>& data) {
    return exchange(make_frame(command, address, data), line(), line());
  }
  std::uint16_t count_slaves() {
    const auto reply = exchange(Command::kBrd, wire::DatagramAddress::physical(0, 0), bytes({0}));
    return reply ? reply->working_counter : 0xFFFF;
  }
  /// Reads a register of the slave at `position` directly, without a frame.
  template <typename T>
  T peek(std::size_t position, const wire::Register<T>& r, unsigned n = 0) {
    return line().slave(position).esc().memory().get(r, n);
  }

 private:
  rt::VirtualClock clock_{1s};
  std::unique_ptr<SimulatedLine> line_;
  std::vector<TestDevice*> devices_;
};

}  // namespace driveline::slaves::test

// Propagation delays against a model of a line that knows the true times: cables and controllers with delays, clocks
// with any offset, receive times cut to 32 bits.
#include "driveline/ecat_master/dc/propagation_delay.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "support/must.hpp"

namespace driveline::ecat_master::dc {
namespace {

/// Order in which a frame leaves: 0, processing unit, 3, 1, 2.
constexpr std::array<unsigned, 4> kOrder = {0, 3, 1, 2};

/// A line whose true times are known.
struct Model {
  struct Slave {
    unsigned entry = 0;
    std::array<int, 4> child = {-1, -1, -1, -1};
    std::int64_t cable = 0;  ///< towards the master
    std::uint32_t clock_offset = 0;
    bool clock = true;
    std::array<std::int64_t, 4> received{};
    std::int64_t processed = 0;
    std::int64_t own_extra = 0;  ///< extra delay of its processing unit
  };
  std::vector<Slave> slaves;
  std::int64_t forwarding = 300;
  std::int64_t processing_extra = 0;

  int add(int parent, unsigned port, std::int64_t cable, unsigned entry = 0) {
    const auto number = static_cast<int>(slaves.size());
    slaves.emplace_back();
    slaves.back().entry = entry;
    slaves.back().cable = cable;
    if (parent >= 0) slaves[static_cast<std::size_t>(parent)].child[port] = number;
    return number;
  }

  /// A frame enters at the entry port of `number` at `time`; returns when it leaves there again.
  std::int64_t pass(int number, std::int64_t time) {
    auto& slave = slaves[static_cast<std::size_t>(number)];
    const auto begin = static_cast<std::size_t>(std::find(kOrder.begin(), kOrder.end(), slave.entry) - kOrder.begin());
    std::int64_t at = time;
    slave.received[slave.entry] = time;
    bool through_unit = false;
    auto unit = [&](unsigned port) {
      if (port != 0) return;
      slave.processed = at;
      through_unit = true;
    };
    unit(slave.entry);
    for (std::size_t i = 1; i <= 4; ++i) {
      const unsigned port = kOrder[(begin + i) % 4];
      const int child = port == slave.entry ? -1 : slave.child[port];
      if (child < 0 && i < 4) {
        unit(port);  // closed: past it, and through the unit behind it
        continue;
      }
      at += forwarding + (through_unit ? processing_extra + slave.own_extra : 0);
      through_unit = false;
      if (child < 0) break;
      const auto cable = slaves[static_cast<std::size_t>(child)].cable;
      at = pass(child, at + cable) + cable;
      slaves[static_cast<std::size_t>(number)].received[port] = at;
      unit(port);
    }
    return at;
  }

  [[nodiscard]] std::vector<DelayNode> nodes() const {
    std::vector<DelayNode> result;
    for (const auto& slave : slaves) {
      DelayNode node;
      node.entry_port = static_cast<std::uint8_t>(slave.entry);
      node.has_receive_times = slave.clock;
      node.processing_extra_ns = static_cast<double>(processing_extra + slave.own_extra);
      for (unsigned port = 0; port < 4; ++port) {
        if (slave.child[port] >= 0) node.children[port] = static_cast<std::uint16_t>(slave.child[port]);
        // Ports without a frame keep arbitrary old values.
        node.receive_time_ns[port] = 0xDEADBEEFU * (port + 1);
        if (port == slave.entry || slave.child[port] >= 0) {
          node.receive_time_ns[port] = static_cast<std::uint32_t>(slave.received[port]) + slave.clock_offset;
        }
      }
      result.push_back(node);
    }
    return result;
  }

  [[nodiscard]] std::vector<PropagationDelay> compute() {
    pass(0, 1'000'000);
    const auto delays = propagation_delays(nodes());
    if (!delays) throw std::runtime_error("contradiction at slave " + std::to_string(delays.error().slave));
    return *delays;
  }
  /// True time from the first slave with a clock.
  [[nodiscard]] double truth(std::size_t number) const {
    const auto first = std::find_if(slaves.begin(), slaves.end(), [](const Slave& s) { return s.clock; });
    return static_cast<double>(slaves[number].processed - first->processed);
  }
};

void expect_true(Model& model) {
  const auto delays = model.compute();
  for (std::size_t i = 0; i < delays.size(); ++i) {
    if (!model.slaves[i].clock) continue;
    EXPECT_NEAR(delays[i].from_first_ns, model.truth(i), 0.5) << "slave " << i;
    EXPECT_EQ(delays[i].quality, DelayQuality::kMeasured) << "slave " << i;
  }
}

Model make_line(std::size_t count) {
  Model model;
  for (std::size_t i = 0; i < count; ++i) model.add(static_cast<int>(i) - 1, 1, 5 + 13 * static_cast<int>(i));
  return model;
}

TEST(PropagationDelay, OfALine) {
  for (const std::size_t count : {1U, 2U, 3U, 64U}) {
    auto model = make_line(count);
    expect_true(model);
  }
}

TEST(PropagationDelay, OfALineWhoseProcessingUnitsTakeLonger) {
  auto model = make_line(8);
  model.processing_extra = 40;
  expect_true(model);
}

/// Controllers of different makers in one line, with different delays of their processing units.
TEST(PropagationDelay, OfSlavesWhoseProcessingUnitsDiffer) {
  auto model = make_line(9);
  for (std::size_t i = 0; i < model.slaves.size(); ++i) model.slaves[i].own_extra = static_cast<int>(i * 7 % 41);
  expect_true(model);
}

TEST(PropagationDelay, OfAStarAndOfBranches) {
  Model model;
  const int hub = model.add(-1, 0, 5);
  const int a = model.add(hub, 3, 100);
  model.add(a, 1, 20);
  const int b = model.add(hub, 1, 7);
  const int c = model.add(b, 3, 11);
  model.add(c, 1, 200);
  model.add(b, 1, 19);
  model.add(hub, 2, 500);
  model.processing_extra = 20;
  expect_true(model);
}

TEST(PropagationDelay, OfSlavesThatAreEnteredAtTheirOutput) {
  Model model;
  const int first = model.add(-1, 0, 5);
  const int swapped = model.add(first, 1, 50, 1);
  model.add(swapped, 0, 70);
  expect_true(model);
}

TEST(PropagationDelay, DoesNotMindWhereTheClocksWrapAround) {
  for (const std::uint32_t edge : {0x8000'0000U, 0x0000'0000U}) {
    for (std::int64_t before = -3000; before <= 3000; before += 50) {
      auto model = make_line(4);
      for (auto& slave : model.slaves) slave.clock_offset = edge - 1'000'000U + static_cast<std::uint32_t>(before);
      expect_true(model);
    }
  }
}

TEST(PropagationDelay, ClocksThatCountFasterAreNotFurtherAway) {
  auto model = make_line(64);
  model.pass(0, 1'000'000);
  auto nodes = model.nodes();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    nodes[i].rate = i == 0 ? 1.0 : 1.0 + 1e-4 * (i % 2 == 0 ? 1.0 : -1.0);
    const double span = static_cast<double>(nodes[i].receive_time_ns[1] - nodes[i].receive_time_ns[0]) * nodes[i].rate;
    if (i < 63)
      nodes[i].receive_time_ns[1] = nodes[i].receive_time_ns[0] + static_cast<std::uint32_t>(std::lround(span));
  }
  const auto delays = must(propagation_delays(nodes));
  for (std::size_t i = 0; i < nodes.size(); ++i) EXPECT_NEAR((*delays)[i].from_first_ns, model.truth(i), 0.6) << i;
}

TEST(PropagationDelay, SlavesWithoutReceiveTimesAreCable) {
  auto model = make_line(7);
  for (const std::size_t i : {0U, 2U, 3U, 5U}) model.slaves[i].clock = false;
  expect_true(model);
  EXPECT_EQ(model.compute()[2].quality, DelayQuality::kNone);
}

TEST(PropagationDelay, BehindABranchWithoutReceiveTimesIsEstimated) {
  Model model;
  const int first = model.add(-1, 0, 5);
  const int hub = model.add(first, 1, 25);
  model.slaves[1].clock = false;
  const int a = model.add(hub, 3, 25);
  const int b = model.add(hub, 1, 25);
  model.add(b, 1, 300);
  const auto delays = model.compute();
  for (const int i : {a, b, b + 1}) {
    const auto n = static_cast<std::size_t>(i);
    EXPECT_EQ(delays[n].quality, DelayQuality::kEstimated) << i;
    EXPECT_NEAR(delays[n].from_first_ns, model.truth(n), 0.5) << "equal cables, so the estimate is right; slave " << i;
  }
}

TEST(PropagationDelay, NothingIsKnownBehindABranchRightAtTheMaster) {
  Model model;
  const int hub = model.add(-1, 0, 5);
  model.slaves[0].clock = false;
  model.add(hub, 3, 25);
  const int b = model.add(hub, 1, 25);
  model.add(b, 1, 90);
  const auto delays = model.compute();
  EXPECT_EQ(delays[2].quality, DelayQuality::kAssumed);
  EXPECT_EQ(delays[3].quality, DelayQuality::kAssumed);
  EXPECT_NEAR(delays[3].from_first_ns - delays[2].from_first_ns, model.truth(3) - model.truth(2), 0.5);
}

TEST(PropagationDelay, AContradictionIsNamed) {
  auto model = make_line(3);
  model.pass(0, 0);
  auto nodes = model.nodes();
  nodes[1].receive_time_ns[1] += 100'000;  // more behind slave 1 than around it
  const auto delays = propagation_delays(nodes);
  ASSERT_FALSE(delays);
  EXPECT_EQ(delays.error().slave, 0);
  EXPECT_EQ(delays.error().port, 1);
}

TEST(PropagationDelay, OfNothingIsNothing) {
  EXPECT_TRUE(propagation_delays({})->empty());
  auto model = make_line(3);
  for (auto& slave : model.slaves) slave.clock = false;
  const auto delays = must(propagation_delays(model.nodes()));
  for (const auto& delay : *delays) EXPECT_EQ(delay.quality, DelayQuality::kNone);
}

TEST(PropagationDelay, OfAVeryLongLineWithoutClocksNeedsNoStack) {
  auto model = make_line(4096);
  for (std::size_t i = 1; i < 4095; ++i) model.slaves[i].clock = false;
  expect_true(model);
}

/// A random tree with random entry ports and clocks.
Model any_tree(bool equal_cables, bool all_clocks) {
  Model model;
  model.forwarding = *rc::gen::inRange<std::int64_t>(40, 900);
  model.processing_extra = *rc::gen::inRange<std::int64_t>(0, 50);
  const auto count = *rc::gen::inRange(1, 40);
  const auto cable = *rc::gen::inRange<std::int64_t>(0, 600);
  for (int i = 0; i < count; ++i) {
    std::vector<std::pair<int, unsigned>> free;
    for (int parent = 0; parent < i; ++parent) {
      const auto& slave = model.slaves[static_cast<std::size_t>(parent)];
      for (unsigned port = 0; port < 4; ++port) {
        if (port != slave.entry && slave.child[port] < 0) free.emplace_back(parent, port);
      }
    }
    const auto entry = *rc::gen::weightedElement<unsigned>({{6, 0U}, {1, 1U}, {1, 2U}, {1, 3U}});
    const auto [parent, port] = i == 0 ? std::pair{-1, 0U} : *rc::gen::elementOf(free);
    const auto own_cable = *rc::gen::inRange<std::int64_t>(0, 600);
    const int number = model.add(parent, port, equal_cables ? cable : own_cable, entry);
    auto& slave = model.slaves[static_cast<std::size_t>(number)];
    slave.clock_offset = *rc::gen::arbitrary<std::uint32_t>();
    slave.clock = all_clocks || *rc::gen::weightedElement<bool>({{3, true}, {2, false}});
  }
  return model;
}

TEST(PropagationDelayProperty, AnyTreeOfClocksIsExact) {
  EXPECT_TRUE(rc::check([] {
    auto model = any_tree(false, true);
    const auto delays = model.compute();
    for (std::size_t i = 0; i < delays.size(); ++i) {
      RC_ASSERT(delays[i].quality == DelayQuality::kMeasured);
      RC_ASSERT(std::abs(delays[i].from_first_ns - model.truth(i)) <= 0.5);
    }
  }));
}

TEST(PropagationDelayProperty, WhatIsCalledMeasuredIsExactWhoeverHasNoClock) {
  EXPECT_TRUE(rc::check([] {
    auto model = any_tree(false, false);
    const auto delays = model.compute();
    const auto first = static_cast<std::size_t>(
        std::find_if(model.slaves.begin(), model.slaves.end(), [](const auto& s) { return s.clock; }) -
        model.slaves.begin());
    RC_PRE(first < delays.size());
    RC_PRE(delays[first].quality == DelayQuality::kMeasured);
    for (std::size_t i = 0; i < delays.size(); ++i) {
      RC_ASSERT((delays[i].quality == DelayQuality::kNone) == !model.slaves[i].clock);
      if (delays[i].quality != DelayQuality::kMeasured) continue;
      RC_ASSERT(std::abs(delays[i].from_first_ns - model.truth(i)) <= 0.5);
    }
  }));
}

TEST(PropagationDelayProperty, EqualCablesMakeEveryEstimateExact) {
  EXPECT_TRUE(rc::check([] {
    auto model = any_tree(true, false);
    const auto delays = model.compute();
    for (std::size_t i = 0; i < delays.size(); ++i) {
      if (delays[i].quality == DelayQuality::kNone || delays[i].quality == DelayQuality::kAssumed) continue;
      const auto first = static_cast<std::size_t>(
          std::find_if(model.slaves.begin(), model.slaves.end(), [](const auto& s) { return s.clock; }) -
          model.slaves.begin());
      if (delays[first].quality == DelayQuality::kAssumed) continue;
      RC_ASSERT(std::abs(delays[i].from_first_ns - model.truth(i)) <= 0.5);
    }
  }));
}

}  // namespace
}  // namespace driveline::ecat_master::dc

#include "driveline/bridge/dds_publisher.hpp"

#include <gmock/gmock.h>

#include <future>
#include <map>
#include <stdexcept>
#include <thread>
#include <vector>

#include "driveline/snapshot/drain_thread.hpp"
#include "subscriber.hpp"

namespace driveline::bridge {
namespace {

using namespace std::chrono_literals;
using snapshot::AxisSample;
using snapshot::AxisState;
using snapshot::LineSample;
using test::AxisSubscriber;
using test::StatusSubscriber;
using test::test_domain;
namespace dds = test::dds;
using testing::ElementsAre;

DdsConfig config_with_axes(std::size_t axes) {
  DdsConfig config;
  config.domain_id = test_domain();
  config.line_name = "bench line";
  for (std::size_t i = 0; i < axes; ++i) {
    config.axes.push_back({.name = "axis" + std::to_string(i)});
  }
  config.status_period = 1h;  // everything published during a test is due to a change
  return config;
}

std::unique_ptr<DdsPublisher> created(DdsConfig config) {
  auto publisher = DdsPublisher::create(std::move(config));
  if (!publisher) {
    throw std::runtime_error(describe(publisher.error()));
  }
  return *std::move(publisher);
}

/// A sample whose values all differ.
AxisSample sample_of(std::uint64_t cycle, std::uint16_t axis) {
  const double base = static_cast<double>(cycle) + axis * 1000.0;
  return {.cycle = cycle,
          .time_ns = static_cast<std::int64_t>(cycle) * 125'000 + 3,
          .axis = axis,
          .control_word = 0x000F,
          .status_word = 0x1637,
          .mode = 8,
          .state = AxisState::kOperationEnabled,
          .target_position = base + 0.125,
          .actual_position = base + 0.25,
          .target_velocity = base + 0.375,
          .actual_velocity = -(base + 0.5),
          .target_torque = base + 0.625,
          .actual_torque = base + 0.75,
          .following_error = base + 0.875};
}

void publish(DdsPublisher& publisher, const AxisSample& sample) {
  publisher.axes({&sample, 1});
}

/// Publishes cycle 0 until a best-effort sample has arrived, then discards the received samples.
void connect(DdsPublisher& publisher, AxisSubscriber& subscriber) {
  ASSERT_TRUE(subscriber.wait_for(1, [&] { publish(publisher, sample_of(0, 0)); })) << "discovery failed";
  subscriber.forget();
}

TEST(DdsPublisher, EveryValueOfASampleArrives) {
  DdsConfig config = config_with_axes(2);
  config.axes[1] = {.name = "slide", .kind = AxisKind::kLinear};
  const auto publisher = created(config);
  AxisSubscriber subscriber{test_domain()};
  connect(*publisher, subscriber);

  publish(*publisher, sample_of(4000, 1));
  ASSERT_TRUE(subscriber.wait_for(1));
  const telemetry::AxisTelemetry& got = subscriber.received().front();
  EXPECT_EQ(got.axis(), 1);
  EXPECT_EQ(got.name().to_string(), "slide");
  EXPECT_EQ(got.kind(), telemetry::AXIS_LINEAR);
  EXPECT_EQ(got.cycle(), 4000U);
  EXPECT_EQ(got.time_ns(), 500'000'003);
  EXPECT_EQ(got.control_word(), 0x000F);
  EXPECT_EQ(got.status_word(), 0x1637);
  EXPECT_EQ(got.mode(), 8);
  EXPECT_EQ(got.state(), telemetry::AXIS_OPERATION_ENABLED);
  EXPECT_EQ(got.target_position(), 5000.125);
  EXPECT_EQ(got.actual_position(), 5000.25);
  EXPECT_EQ(got.target_velocity(), 5000.375);
  EXPECT_EQ(got.actual_velocity(), -5000.5);
  EXPECT_EQ(got.target_torque(), 5000.625);
  EXPECT_EQ(got.actual_torque(), 5000.75);
  EXPECT_EQ(got.following_error(), 5000.875);
}

TEST(DdsPublisher, NegativeModesStayNegative) {
  const auto publisher = created(config_with_axes(1));
  AxisSubscriber subscriber{test_domain()};
  connect(*publisher, subscriber);
  AxisSample sample = sample_of(8, 0);
  sample.mode = -3;  // manufacturer specific modes are negative
  publish(*publisher, sample);
  ASSERT_TRUE(subscriber.wait_for(1));
  EXPECT_EQ(subscriber.received().front().mode(), -3);
}

TEST(DdsPublisher, PublishesExactlyTheCyclesItsDecimationDivides) {
  DdsConfig config = config_with_axes(3);
  config.decimation = 8;
  const auto publisher = created(config);
  AxisSubscriber subscriber{test_domain()};
  connect(*publisher, subscriber);

  const std::uint64_t before = publisher->counters().published;
  for (std::uint64_t cycle = 1; cycle <= 80; ++cycle) {
    for (std::uint16_t axis = 0; axis < 3; ++axis) {
      publish(*publisher, sample_of(cycle, axis));
    }
  }
  ASSERT_TRUE(subscriber.wait_for(30));
  std::map<std::uint16_t, std::vector<std::uint64_t>> cycles;
  for (const auto& message : subscriber.received()) {
    cycles[message.axis()].push_back(message.cycle());
  }
  ASSERT_EQ(cycles.size(), 3U);
  for (const auto& [axis, seen] : cycles) {
    EXPECT_THAT(seen, ElementsAre(8, 16, 24, 32, 40, 48, 56, 64, 72, 80)) << "axis " << axis;
  }
  EXPECT_EQ(publisher->counters().published - before, 30U);
  EXPECT_EQ(publisher->counters().dropped, 0U);
}

TEST(DdsPublisher, CarriesMoreAxesThanFastDdsAllowsInstancesByDefault) {
  constexpr std::uint16_t kAxes = 100;
  const auto publisher = created(config_with_axes(kAxes));
  AxisSubscriber subscriber{test_domain()};
  connect(*publisher, subscriber);
  for (std::uint16_t axis = 0; axis < kAxes; ++axis) {
    publish(*publisher, sample_of(16, axis));
  }
  ASSERT_TRUE(subscriber.wait_for(kAxes));
  EXPECT_EQ(subscriber.received().back().axis(), kAxes - 1);
}

TEST(DdsPublisher, RefusesAndCountsSamplesOfUnknownAxes) {
  const auto publisher = created(config_with_axes(2));
  publish(*publisher, sample_of(8, 2));
  publish(*publisher, sample_of(8, 0xFFFF));
  publish(*publisher, sample_of(8, 1));
  publisher->pass_done({});
  EXPECT_EQ(publisher->counters().published, 1U);
  EXPECT_EQ(publisher->counters().dropped, 2U);
}

TEST(DdsPublisher, LateSubscriberGetsTheLastStatus) {
  const auto publisher = created(config_with_axes(2));
  snapshot::LineStatus status;
  status.state = snapshot::LineState::kPreOp;
  publisher->set_line_status(status);
  publisher->pass_done({});
  status = {.state = snapshot::LineState::kOp,
            .cycle_period = 125us,
            .cycles = 40'001,
            .missed_periods = 2,
            .wkc_errors = 3,
            .lost_frames = 4,
            .wake_latency = {.p50 = 5ns, .p99 = 6ns, .max = 7ns},
            .cycle_cost = {.p50 = 8ns, .p99 = 9ns, .max = 10ns},
            .faults = {"axis0: fault 7121h", "slave 1: cable"}};
  publisher->set_line_status(status);
  LineSample cycle;
  cycle.cycle = 40'000;
  cycle.time_ns = 5'000'000'000;
  cycle.dc_locked = true;
  cycle.dc_difference_ns = -17;
  publisher->lines({&cycle, 1});
  publisher->pass_done({.lines_dropped = 1, .axes_dropped = 10});

  StatusSubscriber late{test_domain()};
  ASSERT_TRUE(late.wait_for(1));
  const telemetry::LineStatus got = late.received().front();
  EXPECT_EQ(late.received().size(), 1U) << "only the newest status is kept";
  EXPECT_EQ(got.name().to_string(), "bench line");
  EXPECT_EQ(got.state(), telemetry::LINE_OP);
  EXPECT_EQ(got.axes(), 2);
  EXPECT_EQ(got.cycle_period_ns(), 125'000);
  EXPECT_EQ(got.cycle(), 40'000U);
  EXPECT_EQ(got.time_ns(), 5'000'000'000);
  EXPECT_TRUE(got.dc_locked());
  EXPECT_EQ(got.dc_difference_ns(), -17);
  EXPECT_EQ(got.cycles(), 40'001U);
  EXPECT_EQ(got.missed_periods(), 2U);
  EXPECT_EQ(got.wkc_errors(), 3U);
  EXPECT_EQ(got.lost_frames(), 4U);
  EXPECT_EQ(got.wake_latency().p50_ns(), 5);
  EXPECT_EQ(got.wake_latency().p99_ns(), 6);
  EXPECT_EQ(got.wake_latency().max_ns(), 7);
  EXPECT_EQ(got.cycle_cost().p50_ns(), 8);
  EXPECT_EQ(got.cycle_cost().p99_ns(), 9);
  EXPECT_EQ(got.cycle_cost().max_ns(), 10);
  EXPECT_EQ(got.telemetry_published(), 0U);
  EXPECT_EQ(got.telemetry_dropped(), 11U);
  ASSERT_EQ(got.faults().size(), 2U);
  EXPECT_EQ(got.faults()[0].to_string(), "axis0: fault 7121h");
  EXPECT_EQ(got.faults()[1].to_string(), "slave 1: cable");
}

TEST(DdsPublisher, ChangeOfStateOrFaultsDoesNotWaitForThePeriod) {
  const auto publisher = created(config_with_axes(1));
  StatusSubscriber subscriber{test_domain()};
  const auto pass_with = [&](const snapshot::LineStatus& status) {
    publisher->set_line_status(status);
    publisher->pass_done({});
  };
  pass_with({.state = snapshot::LineState::kOp, .cycles = 1});  // the first pass always publishes
  ASSERT_TRUE(subscriber.wait_for(1));
  pass_with({.state = snapshot::LineState::kOp, .cycles = 2});  // only counters: waits for the period
  pass_with({.state = snapshot::LineState::kSafeOp, .cycles = 3});
  ASSERT_TRUE(subscriber.wait_for(2));
  pass_with({.state = snapshot::LineState::kSafeOp, .cycles = 4, .faults = {"lost slave 3"}});
  ASSERT_TRUE(subscriber.wait_for(3));
  pass_with({.state = snapshot::LineState::kSafeOp, .cycles = 5, .faults = {"lost slave 3"}});
  publisher->finish({});  // the last status is published regardless of the period
  ASSERT_TRUE(subscriber.wait_for(4));
  std::vector<std::uint64_t> cycles;
  for (const auto& status : subscriber.received()) {
    cycles.push_back(status.cycles());
  }
  EXPECT_THAT(cycles, ElementsAre(1, 3, 4, 5));
}

TEST(DdsPublisher, StatusIsRepeatedOncePerPeriod) {
  DdsConfig config = config_with_axes(1);
  config.status_period = 1ms;
  const auto publisher = created(config);
  StatusSubscriber subscriber{test_domain()};
  EXPECT_TRUE(subscriber.wait_for(3, [&] { publisher->pass_done({}); }));
}

TEST(DdsPublisher, KeepsTheNewestFaultsAndCutsLongOnes) {
  const auto publisher = created(config_with_axes(1));
  StatusSubscriber subscriber{test_domain()};
  snapshot::LineStatus status;
  for (int i = 0; i < 20; ++i) {
    status.faults.push_back("fault " + std::to_string(i));
  }
  status.faults.emplace_back(1000, 'x');
  publisher->set_line_status(status);
  publisher->pass_done({});
  ASSERT_TRUE(subscriber.wait_for(1));
  const auto& faults = subscriber.received().front().faults();
  ASSERT_EQ(faults.size(), 16U);
  EXPECT_EQ(faults.front().to_string(), "fault 5");
  EXPECT_EQ(faults.back().to_string(), std::string(255, 'x'));
}

/// Simulates a hanging writer: blocks the drain thread before it calls the publisher.
class Blocker : public snapshot::SampleConsumer {
 public:
  void lines(std::span<const LineSample> /*samples*/) override {}
  void axes(std::span<const AxisSample> /*samples*/) override {
    if (!done_) {
      done_ = true;
      blocked.set_value();
      release.get_future().wait();
    }
  }
  std::promise<void> blocked;
  std::promise<void> release;

 private:
  bool done_ = false;
};

TEST(DdsPublisher, ASlaveIsPublishedWhenItHasChangedAndNowAndThen) {
  auto config = config_with_axes(0);
  config.slaves = 2;
  config.slave_period = 50ms;
  const auto publisher = created(config);
  dds::DataReaderQos qos;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
  qos.history().depth = 100;
  test::Subscriber<telemetry::Slave, telemetry::SlavePubSubType> subscriber{test_domain(), config.slave_topic, qos};
  snapshot::FeedCondition condition;
  condition.slaves.resize(2);
  publisher->set_condition(condition);
  ASSERT_TRUE(subscriber.wait_for(2));
  subscriber.forget();
  condition.slaves[0].read_at_ns = 5;
  publisher->set_condition(condition);
  condition.slaves[1].al_state = 8;
  publisher->set_condition(condition);
  ASSERT_TRUE(subscriber.wait_for(1));
  EXPECT_EQ(subscriber.received().front().position(), 1U) << "that it was read again is no change";
  EXPECT_EQ(subscriber.received().front().state(), telemetry::SLAVE_OP);
  subscriber.forget();
  ASSERT_TRUE(subscriber.wait_for(2, [&] { publisher->pass_done({}); })) << "both, after the period";
  EXPECT_EQ(subscriber.received().front().wall_time_ns(), 5);
}

TEST(DdsPublisher, ALateSubscriberHasEveryAxisHoweverOftenOneOfThemHasChanged) {
  const auto config = config_with_axes(3);
  const auto publisher = created(config);
  for (std::uint16_t axis = 0; axis < 3; ++axis) {
    const auto sample = sample_of(1, axis);
    publisher->axes({&sample, 1});
  }
  publisher->pass_done({});
  for (std::uint16_t change = 0; change < 10; ++change) {
    auto sample = sample_of(2, 1);
    sample.error_code = change;
    publisher->axes({&sample, 1});
    publisher->pass_done({});
  }
  dds::DataReaderQos qos;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
  qos.history().depth = 100;
  test::Subscriber<telemetry::AxisStatus, telemetry::AxisStatusPubSubType> late{test_domain(), config.axis_state_topic,
                                                                                qos};
  ASSERT_TRUE(late.wait_for(3));
  std::map<std::uint16_t, std::uint16_t> codes;
  for (const auto& message : late.received()) codes[message.axis()] = message.error_code();
  EXPECT_EQ(codes, (std::map<std::uint16_t, std::uint16_t>{{0, 0}, {1, 9}, {2, 0}}));
}

TEST(DdsPublisher, ALineThatNobodyTellsOfIsNoticed) {
  auto config = config_with_axes(0);
  config.status_period = 20ms;
  const auto publisher = created(config);
  dds::DataReaderQos qos;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
  qos.history().depth = 100;
  qos.deadline().period = eprosima::fastrtps::Duration_t(2, 0);
  qos.liveliness().kind = dds::MANUAL_BY_TOPIC_LIVELINESS_QOS;
  qos.liveliness().lease_duration = eprosima::fastrtps::Duration_t(2, 0);
  test::Subscriber<telemetry::LineStatus, telemetry::LineStatusPubSubType> watcher{test_domain(), config.status_topic,
                                                                                   qos};
  ASSERT_TRUE(watcher.wait_for(20, [&] { publisher->pass_done({}); }));
  EXPECT_EQ(watcher.deadlines_missed(), 0);
  EXPECT_EQ(watcher.writers_alive(), 1);
  publisher->set_stalled(true);
  const auto limit = std::chrono::steady_clock::now() + 20s;
  while ((watcher.deadlines_missed() == 0 || watcher.writers_alive() > 0) && std::chrono::steady_clock::now() < limit) {
    publisher->pass_done({});
    std::this_thread::sleep_for(5ms);
  }
  EXPECT_GT(watcher.deadlines_missed(), 0);
  EXPECT_EQ(watcher.writers_alive(), 0);
}

TEST(DdsPublisher, FedFromTheRingsItReportsWhatTheRingsDropped) {
  constexpr std::size_t kCapacity = 64;  // a burst of them fits into a socket's receive buffer
  rt::SpscRing<LineSample> lines{kCapacity};
  rt::SpscRing<AxisSample> axes{kCapacity};
  DdsConfig config = config_with_axes(1);
  config.decimation = 1;
  const auto publisher = created(config);
  AxisSubscriber axis_subscriber{test_domain()};
  StatusSubscriber status_subscriber{test_domain()};
  connect(*publisher, axis_subscriber);
  const std::uint64_t before = publisher->counters().published;

  Blocker blocker;
  snapshot::DrainThread drain{lines, axes, {&blocker, publisher.get()}};
  ASSERT_TRUE(drain.start());
  ASSERT_TRUE(axes.try_push(sample_of(1, 0)));
  blocker.blocked.get_future().wait();
  std::uint64_t accepted = 1;
  for (std::uint64_t cycle = 2; cycle <= 1000; ++cycle) {
    accepted += axes.try_push(sample_of(cycle, 0)) ? 1U : 0U;
  }
  ASSERT_EQ(accepted, 1 + kCapacity);
  blocker.release.set_value();
  publisher->set_line_status({.state = snapshot::LineState::kInit, .cycles = 1000});
  drain.stop();

  EXPECT_EQ(publisher->counters().published - before, accepted);
  EXPECT_EQ(publisher->counters().dropped, 1000 - accepted);
  ASSERT_TRUE(axis_subscriber.wait_for(accepted));
  EXPECT_EQ(axis_subscriber.received().back().cycle(), accepted);
  const auto is_last = [&] {
    const auto& statuses = status_subscriber.received();
    return !statuses.empty() && statuses.back().telemetry_published() == before + accepted;
  };
  for (std::size_t seen = 1; !is_last(); ++seen) {
    ASSERT_TRUE(status_subscriber.wait_for(seen));
  }
  EXPECT_EQ(status_subscriber.received().back().telemetry_dropped(), 1000 - accepted);
  EXPECT_EQ(status_subscriber.received().back().state(), telemetry::LINE_INIT);
}

}  // namespace
}  // namespace driveline::bridge

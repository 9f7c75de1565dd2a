// Ethernet frames between the master and the networks of simulated drives.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "drive_line.hpp"
#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/eoe/eoe_client.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "driveline/esi/sii.hpp"
#include "driveline/slaves/ethernet_link.hpp"
#include "edited_line.hpp"
#include "fault_ports.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
using ecat_master::EoePort;
using ecat_master::Master;
using Bytes = std::vector<std::byte>;
using Frames = std::vector<Bytes>;

/// The network behind a drive: returns every frame.
struct Echo final : slaves::EthernetLink {
  bool send(std::span<const std::byte> frame) noexcept override {
    heard.emplace_back(frame.begin(), frame.end());
    return true;
  }
  std::size_t receive(std::span<std::byte> out) noexcept override {
    if (returned == heard.size()) return 0;
    const auto& frame = heard[returned++];
    std::copy(frame.begin(), frame.end(), out.begin());
    return frame.size();
  }
  void set_address(const wire::EoeIpParameters& /*address*/) noexcept override {}
  void set_link(bool /*up*/) noexcept override {}

  Frames heard;
  std::size_t returned = 0;
};

/// Ports to all drives of a line, with an echo behind each.
struct Echoes final : ecat_master::EoeReceiver {
  Echoes(DriveLine& drives, Master& master) : echoes(drives.size()), master_(master) {
    for (std::size_t i = 0; i < drives.size(); ++i) {
      EXPECT_TRUE(drives.slave(i).device().connect_network(&echoes[i]));
      ports.push_back(master.open_eoe(i, *this).value());
    }
  }
  void receive(std::uint16_t position, std::span<const std::byte> frame) override {
    came[position].emplace_back(frame.begin(), frame.end());
  }
  /// Sends a frame with another length and other bytes each time.
  void send() {
    for (auto& port : ports) {
      seed_ = seed_ * 1664525U + 1013904223U;
      Bytes frame(60 + (seed_ >> 8) % 1459);
      for (std::size_t i = 0; i < frame.size(); ++i) frame[i] = static_cast<std::byte>(seed_ >> 16 ^ i * 31);
      if (port->send(frame)) sent[port->position()].push_back(frame);
    }
  }
  /// Steps the mailboxes until all frames have returned, at most for `limit`.
  void await(std::chrono::nanoseconds limit, const rt::Clock& clock) {
    const auto end = clock.now() + limit;
    while (came != sent && clock.now() < end) master_.mailboxes().drive();
  }
  void expect_nothing_lost() {
    EXPECT_EQ(came, sent);
    for (std::size_t i = 0; i < ports.size(); ++i) {
      const auto seen = ports[i]->statistics();
      EXPECT_EQ(echoes[i].heard, sent[static_cast<std::uint16_t>(i)]);
      EXPECT_EQ(seen.lost + seen.malformed + seen.stray + seen.given_up, 0U) << i;
      EXPECT_EQ(seen.frames_out, seen.frames_in);
      EXPECT_EQ(seen.fragments_out, seen.fragments_in);
    }
  }

  std::vector<std::shared_ptr<EoePort>> ports;
  std::map<std::uint16_t, Frames> sent;
  std::map<std::uint16_t, Frames> came;
  std::vector<Echo> echoes;

 private:
  Master& master_;
  std::uint32_t seed_ = 1;
};

TEST(EoeOfALine, CarriesFramesBothWaysBeforeTheCycle) {
  DriveLine drives(3);
  PreOpMaster master(drives.line(), drives.clock);
  Echoes echoes(drives, master);
  for (int i = 0; i < 50; ++i) echoes.send();
  echoes.await(std::chrono::seconds{5}, drives.clock);
  echoes.expect_nothing_lost();
}

TEST(EoeOfALine, DisturbsNeitherTheMotionNorTheSdos) {
  DriveLine drives(3);
  FollowingOperation operation(drives, RunOptions{.repeat = true});
  Echoes echoes(drives, operation.master());
  const auto missed = operation.statistics().missed_periods;
  nanoseconds longest{0};
  for (std::uint32_t i = 0; i < 50; ++i) {
    echoes.send();
    const auto begin = drives.clock.now();
    ASSERT_EQ(sentence(CoeClient(*operation.master().mailbox(1)).upload_as<std::uint32_t>(0x1018, 2)), "");
    longest = std::max(longest, drives.clock.now() - begin);
  }
  echoes.await(std::chrono::seconds{5}, drives.clock);
  echoes.expect_nothing_lost();
  EXPECT_LT(longest, milliseconds{5}) << "an SDO passes the frames that wait";
  EXPECT_EQ(operation.statistics().lost_frames, 0U);
  EXPECT_EQ(operation.statistics().wkc_errors, 0U);
  EXPECT_EQ(operation.statistics().stale_frames, 0U);
  EXPECT_EQ(operation.statistics().missed_periods, missed);
  EXPECT_EQ(operation.motion().failure().cause, motion::MotionFailure::Cause::kNone);
}

TEST(EoeOfALine, UsesAlmostEveryCycleForAFragment) {
  DriveLine drives(1);
  IdleOperation operation(drives);
  Echoes echoes(drives, operation.master());
  for (int i = 0; i < 40; ++i) echoes.send();
  const auto before = operation.master().core()->cycles();
  echoes.await(std::chrono::seconds{5}, drives.clock);
  echoes.expect_nothing_lost();
  const auto fragments = echoes.ports[0]->statistics().fragments_out;
  const auto cycles = operation.master().core()->cycles() - before;
  EXPECT_LE(cycles, fragments + fragments / 10) << fragments << " fragments each way";
}

TEST(EoeOfALine, LetsAnSdoWaitForNoMoreThanTheFragmentsOnTheWire) {
  DriveLine drives(1);
  IdleOperation operation(drives);
  Echoes echoes(drives, operation.master());
  const auto upload = [&] {
    const auto before = operation.master().core()->cycles();
    EXPECT_EQ(sentence(CoeClient(*operation.master().mailbox(0)).upload_as<std::uint32_t>(0x1018, 2)), "");
    return operation.master().core()->cycles() - before;
  };
  const auto alone = upload();
  for (int i = 0; i < 60; ++i) echoes.send();
  for (int i = 0; i < 20; ++i) {
    for (int step = 0; step < i; ++step) operation.master().mailboxes().step();
    // One fragment in flight in each direction, and one in each direction before request and answer.
    EXPECT_LE(upload(), alone + 4) << i;
  }
  echoes.await(std::chrono::seconds{5}, drives.clock);
  echoes.expect_nothing_lost();
}

struct EoeLoss : testing::TestWithParam<LossyPort::Direction> {};

TEST_P(EoeLoss, OfOneFrameInAHundredLosesNoFragment) {
  std::uint64_t repeated = 0;
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    DriveLine drives(2);
    bool armed = false;
    Chance chance(100, seed);
    LossyPort port(drives.line(), GetParam(), [&](auto, auto) { return armed && chance(); });
    IdleOperation operation(drives, port);
    Echoes echoes(drives, operation.master());
    armed = true;
    for (int round = 0; round < 4; ++round) {
      for (int i = 0; i < 25; ++i) echoes.send();
      echoes.await(std::chrono::seconds{20}, drives.clock);
    }
    echoes.expect_nothing_lost();
    EXPECT_GT(port.lost(), 5U);
    repeated += operation.master().mailboxes().statistics(0).repeated;
  }
  EXPECT_GT(repeated, 0U);
}

TEST_P(EoeLoss, BeforeTheCycleLosesNoFragment) {
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    DriveLine drives(2);
    bool armed = false;
    Chance chance(20, seed);
    LossyPort port(drives.line(), GetParam(), [&](auto, auto) { return armed && chance(); });
    PreOpMaster master(port, drives.clock);
    Echoes echoes(drives, master);
    armed = true;
    for (int i = 0; i < 50; ++i) echoes.send();
    echoes.await(std::chrono::seconds{20}, drives.clock);
    echoes.expect_nothing_lost();
    EXPECT_GT(port.lost(), 5U);
  }
}

INSTANTIATE_TEST_SUITE_P(Ways, EoeLoss, testing::Values(LossyPort::Direction::kOut, LossyPort::Direction::kBack),
                         [](const auto& test) { return test.param == LossyPort::Direction::kOut ? "Out" : "Back"; });

TEST(EoeOfALine, TheAddressOfADriveIsSetAndReadWhileFramesPass) {
  DriveLine drives(1);
  IdleOperation operation(drives);
  Echoes echoes(drives, operation.master());
  for (int i = 0; i < 20; ++i) echoes.send();
  ecat_master::EoeClient client(operation.master().mailboxes(), 0);
  const wire::EoeIpParameters wanted{.ip = wire::IpV4Address{192, 168, 39, 77},
                                     .subnet_mask = wire::IpV4Address{255, 255, 255, 0}};
  ASSERT_EQ(sentence(client.set_ip(wanted)), "");
  const auto has = client.get_ip();
  ASSERT_EQ(sentence(has), "");
  EXPECT_EQ(has->ip, wanted.ip);
  echoes.await(std::chrono::seconds{5}, drives.clock);
  echoes.expect_nothing_lost();
}

TEST(EoeOfALine, APortComesBackWithItsSlave) {
  DriveLine drives(2);
  IdleOperation operation(drives);
  Echoes echoes(drives, operation.master());
  ecat_master::LineSupervisor supervisor(operation.master());
  drives.line().set_power(1, false);
  operation.run(milliseconds{100});
  supervisor.poll();
  echoes.send();
  drives.line().set_power(1, true);
  for (int i = 0; i < 400 && !supervisor.all_operational(); ++i) {
    operation.run(milliseconds{5});
    supervisor.poll();
  }
  ASSERT_TRUE(supervisor.all_operational());
  EXPECT_TRUE(echoes.ports[1]->up());
  echoes.sent.clear();
  echoes.came.clear();
  echoes.send();
  echoes.await(std::chrono::seconds{5}, drives.clock);
  EXPECT_EQ(echoes.came, echoes.sent);
}

TEST(EoeOfALine, ASlaveWithoutEoeHasNoPort) {
  EditedLine drives(1, [](std::size_t, slaves::DeviceProfile& profile) {
    auto image = esi::decode_sii(profile.sii_image).value();
    image.mailbox_protocols &= static_cast<std::uint16_t>(~esi::sii_mailbox::kEoe);
    profile.sii_image = esi::encode_sii(image);
  });
  PreOpMaster master(drives.line(), drives.clock);
  EXPECT_FALSE(master.supports_eoe(0));
  struct Nobody final : ecat_master::EoeReceiver {
    void receive(std::uint16_t /*position*/, std::span<const std::byte> /*frame*/) override {}
  } nobody;
  EXPECT_EQ(sentence(master.open_eoe(0, nobody)), "slave 0: does not support EoE according to its description");
}

}  // namespace
}  // namespace driveline::bus_test

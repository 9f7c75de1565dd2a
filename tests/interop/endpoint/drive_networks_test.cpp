// Simulated drives with their end points, without a master: EoE messages in, EoE messages out.
#include "driveline/runtime/endpoints/drive_networks.hpp"

#include <gmock/gmock.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <thread>
#include <vector>

#include "driveline/rt/clock.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"
#include "driveline/wire/eoe_frames.hpp"
#include "driveline/wire/mailbox.hpp"

namespace driveline::runtime {
namespace {

using namespace std::chrono_literals;
using slaves::msd::MsdDrive;

/// Whether this machine allows a process a network namespace of its own; tried in a child process.
bool has_namespaces() {
  const auto child = ::fork();
  if (child == 0) ::_exit(::unshare(CLONE_NEWNET) == 0 || ::unshare(CLONE_NEWUSER | CLONE_NEWNET) == 0 ? 0 : 1);
  int status = 1;
  return ::waitpid(child, &status, 0) == child && status == 0;
}

class DriveNetworksTest : public testing::Test {
 protected:
  static constexpr std::size_t kDrives = 2;

  void SetUp() override {
    if (!has_namespaces()) GTEST_SKIP() << "SKIPPED: no network namespaces: neither root nor user namespaces";
    std::vector<std::unique_ptr<slaves::Slave>> made;
    for (std::size_t i = 0; i < kDrives; ++i) {
      slaves::msd::MsdParameters parameters;
      parameters.serial_number = static_cast<std::uint32_t>(1 + i);
      auto drive = std::make_unique<MsdDrive>(parameters);
      static_cast<void>(drive->transition(wire::AlState::kInit, wire::AlState::kPreOp));
      drives_.push_back(drive.get());
      made.push_back(std::make_unique<slaves::Slave>(std::move(drive)));
    }
    line_ = std::make_unique<slaves::SimulatedLine>(clock_, std::move(made));
    DriveNetworks::Settings settings;
    settings.program = DRIVELINE_ENDPOINT;
    settings.first_pause = 20ms;
    auto networks = DriveNetworks::start(*line_, settings);
    ASSERT_TRUE(networks) << describe(networks.error());
    networks_ = std::move(*networks);
  }

  /// Asks "Who has 192.168.39.5?", the factory address of all drives; returns the MAC address in the answer.
  std::vector<std::byte> ask_who_has(std::size_t drive, std::chrono::seconds patience = 30s) {
    std::vector<std::byte> mail(512);
    std::vector<unsigned> bytes = {4 + 60, 0, 0, 0, 0, 0x02, 0x00, 0x01, 0x80, 0x10};
    for (int i = 0; i < 6; ++i) bytes.push_back(0xFF);
    for (const int byte : {2, 0, 0, 0, 0,   9,   0x08, 0x06, 0, 1, 8, 0, 6, 4, 0,   1,   2,  0,
                           0, 0, 0, 9, 192, 168, 39,   1,    0, 0, 0, 0, 0, 0, 192, 168, 39, 5}) {
      bytes.push_back(static_cast<unsigned>(byte));
    }
    for (std::size_t i = 0; i < bytes.size(); ++i) mail[i] = static_cast<std::byte>(bytes[i]);
    const auto limit = std::chrono::steady_clock::now() + patience;
    while (std::chrono::steady_clock::now() < limit) {
      drives_[drive]->mailbox_request(mail);
      for (int i = 0; i < 50; ++i) {
        std::vector<std::byte> out(512);
        const auto length = drives_[drive]->mailbox_reply(out);
        // After mailbox and EoE header: an ARP response; its sender is at offset 22 of the frame.
        constexpr std::size_t kFrame = 10;
        if (length >= kFrame + 42 && out[kFrame + 13] == std::byte{6} && out[kFrame + 21] == std::byte{2}) {
          return {out.begin() + kFrame + 22, out.begin() + kFrame + 28};
        }
        std::this_thread::sleep_for(2ms);
      }
    }
    return {};
  }

  rt::VirtualClock clock_;
  std::vector<MsdDrive*> drives_;
  std::unique_ptr<slaves::SimulatedLine> line_;
  std::unique_ptr<DriveNetworks> networks_;
};

TEST_F(DriveNetworksTest, EveryDriveAnswersWithItsOwnAddress) {
  for (std::size_t i = 0; i < kDrives; ++i) {
    const auto& mac = *drives_[i]->eoe().address().mac;
    EXPECT_EQ(ask_who_has(i), std::vector<std::byte>(mac.begin(), mac.end())) << i;
  }
  const auto figures = networks_->figures();
  ASSERT_EQ(figures.size(), kDrives);
  for (const auto& drive : figures) {
    EXPECT_TRUE(drive.running);
    EXPECT_GE(drive.from_master, 1U);
    EXPECT_GE(drive.to_master, 1U);
    EXPECT_EQ(drive.dropped, 0U);
    EXPECT_EQ(drive.failure, "");
  }
}

TEST_F(DriveNetworksTest, ADeadEndPointIsStartedAgainAndTheOthersGoOn) {
  ASSERT_FALSE(ask_who_has(0).empty());
  const auto before = networks_->figures();
  ASSERT_EQ(::kill(before[0].process, SIGKILL), 0);
  EXPECT_FALSE(ask_who_has(1).empty());
  const auto limit = std::chrono::steady_clock::now() + 30s;
  auto now = networks_->figures()[0];
  while ((now.restarts == 0 || !now.running) && std::chrono::steady_clock::now() < limit) {
    std::this_thread::sleep_for(5ms);
    now = networks_->figures()[0];
  }
  std::vector<std::byte> left(512);  // answers of the first drive
  while (drives_[0]->mailbox_reply(left) != 0) continue;
  EXPECT_FALSE(ask_who_has(0).empty()) << "with address and link, which it was told anew";
  const auto after = networks_->figures();
  EXPECT_GE(after[0].restarts, 1U);
  EXPECT_NE(after[0].process, before[0].process);
  EXPECT_EQ(after[1].process, before[1].process);
}

TEST_F(DriveNetworksTest, EndsItsProcesses) {
  const auto figures = networks_->figures();
  networks_.reset();
  for (const auto& drive : figures) EXPECT_NE(::kill(drive.process, 0), 0);
}

TEST(DriveNetworksStart, TellsWhatDidNotStart) {
  rt::VirtualClock clock;
  std::vector<std::unique_ptr<slaves::Slave>> made;
  made.push_back(std::make_unique<slaves::Slave>(std::make_unique<MsdDrive>()));
  slaves::SimulatedLine line(clock, std::move(made));
  DriveNetworks::Settings settings;
  settings.program = "/nowhere/driveline-endpoint";
  EXPECT_THAT(describe(DriveNetworks::start(line, settings).error()),
              testing::HasSubstr("/nowhere/driveline-endpoint: cannot be started: No such file"));
  settings.program = "/bin/false";
  EXPECT_THAT(describe(DriveNetworks::start(line, settings).error()),
              testing::HasSubstr("network of slave 0: its end point ended immediately"));
}

}  // namespace
}  // namespace driveline::runtime

// Every failed state change reports its facts: slave, requested and actual state, AL status code and its text.
#include <gmock/gmock.h>

#include "drive_line.hpp"
#include "driveline/ecat_master/configuration/configuration_check.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "fault_ports.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using wire::AlState;
using wire::AlStatusCode;

/// Every code of the standard, one of a vendor, and an unknown one.
std::vector<AlStatusCode> all_codes() {
  std::vector<AlStatusCode> codes;
  for (const auto& row : wire::kAlStatusCodeTexts) codes.push_back(row.code);
  codes.push_back(static_cast<AlStatusCode>(0x8123));
  codes.push_back(static_cast<AlStatusCode>(0x0777));
  return codes;
}

std::string code_text(AlStatusCode code) {
  char text[16];
  std::snprintf(text, sizeof text, "0x%04X", static_cast<unsigned>(code));
  const auto meaning = code == AlStatusCode::kNoError ? std::string_view("the slave gives no reason") : to_text(code);
  return "AL status code " + std::string(text) + " (" + std::string(meaning) + ")";
}

/// A sequence of state changes by the master, and the state that slave 1 refuses in it.
struct Way {
  const char* name;
  AlState refused;
  const char* begins;  ///< start of the sentence
  std::function<std::string(DriveLine&, LineOperation&, const std::function<void()>& refuse)> go;
};

class RefusedOnTheWay : public testing::TestWithParam<Way> {};

TEST_P(RefusedOnTheWay, IsTheSlaveBothStatesAndTheCode) {
  const auto& way = GetParam();
  for (const auto code : all_codes()) {
    DriveLine drives(3);
    LineOperation operation(drives);
    const auto text = way.go(drives, operation, [&] { drives.slave(1).al().refuse(way.refused, code); });
    EXPECT_THAT(text, testing::HasSubstr("slave 1: " + std::string(way.begins) + ", " + code_text(code)));
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, RefusedOnTheWay,
    testing::Values(Way{"ToPreOp", AlState::kPreOp, "requested PREOP, is in INIT + error",
                        [](DriveLine&, LineOperation& operation, const std::function<void()>& refuse) {
                          refuse();
                          return sentence(operation.to_safe_op());
                        }},
                    Way{"ToSafeOp", AlState::kSafeOp, "requested SAFEOP, is in PREOP + error",
                        [](DriveLine&, LineOperation& operation, const std::function<void()>& refuse) {
                          refuse();
                          return sentence(operation.to_safe_op());
                        }},
                    Way{"ToOp", AlState::kOp, "requested OP, is in SAFEOP + error",
                        [](DriveLine&, LineOperation& operation, const std::function<void()>& refuse) {
                          refuse();
                          return sentence(operation.to_op());
                        }},
                    Way{"DownToSafeOp", AlState::kSafeOp, "requested SAFEOP, is in OP + error",
                        [](DriveLine&, LineOperation& operation, const std::function<void()>& refuse) {
                          if (auto done = operation.to_op(); !done) return sentence(done);
                          refuse();
                          return sentence(operation.master().shut_down());
                        }},
                    Way{"BackToOp", AlState::kOp, "requested OP, is in SAFEOP + error",
                        [](DriveLine& drives, LineOperation& operation, const std::function<void()>& refuse) {
                          if (auto done = operation.to_op(); !done) return sentence(done);
                          ecat_master::LineSupervisor supervisor(operation.master());
                          refuse();
                          drives.line().set_power(1, false);
                          operation.run(milliseconds{20});
                          supervisor.poll();
                          drives.line().set_power(1, true);
                          for (int i = 0; i < 200; ++i) {
                            operation.run(milliseconds{2});
                            supervisor.poll();
                          }
                          std::string all;
                          for (const auto& event : supervisor.history()) all += what_happened(event) + "\n";
                          return all;
                        }}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(RefusedTransition, ThatJustDoesNotHappenHasTheSameFacts) {
  DriveLine drives(2);
  LineOperation operation(drives, RunOptions{.state_timeout = milliseconds{300}});
  drives.slave(1).al().set_transition_delay(std::chrono::seconds{60});
  EXPECT_EQ(sentence(operation.to_safe_op()),
            "slave 1: requested PREOP, is in INIT and did not change within 3000 ms, AL status code 0x0000 (no error)");
}

TEST(RefusedTransition, ToBootHasTheSameFacts) {
  DriveLine drives(2);
  ScannedMaster master(drives.line(), drives.clock);
  drives.slave(1).al().refuse(AlState::kBootstrap, wire::AlStatusCode::kBootstrapNotSupported);
  EXPECT_EQ(sentence(enter_bootstrap(master.mailboxes(), master.slaves()[1].info)),
            "slave 1: requested BOOT, is in INIT + error, AL status code 0x0013 (bootstrap not supported)");
}

/// Runs `act` when sync manager 2 of the first slave is being set up.
ChangingPort::Change at_sync_manager_2(const std::function<void(std::span<std::byte>)>& act) {
  return [act](std::span<std::byte> frame) {
    const auto first = first_datagram(frame);
    if (first.command != wire::Command::kFpwr || first.adp != 0x1001 || first.ado != 0x0810) return;
    // Only for the write as sent: the data start after the headers of Ethernet, frame and datagram.
    if (first.data[6] != std::byte{0}) act(frame.subspan(26, first.data.size()));
  };
}

std::string everything(LineOperation& operation) {
  auto& master = operation.master();
  if (auto done = master.scan(); !done) return sentence(done);
  const auto done = master.configure(operation.plans());
  return done ? std::string() : describe_with_findings(master.bus(), master.slaves(), master.image(), done.error());
}

TEST(RefusedTransition, NamesASyncManagerThatNobodyHasSetUp) {
  DriveLine drives(2);
  ChangingPort port(drives.line(), at_sync_manager_2([&](std::span<std::byte>) {
                      const std::array<std::byte, 8> stray{std::byte{0}, std::byte{0x1F}, std::byte{4},
                                                           std::byte{0}, std::byte{0x20}, std::byte{0},
                                                           std::byte{1}, std::byte{0}};
                      drives.slave(0).esc().sync_managers().write_registers(0x0838, stray);
                    }),
                    {});
  LineOperation operation(drives, port);
  EXPECT_EQ(everything(operation),
            "slave 0: requested SAFEOP, is in PREOP + error, AL status code 0x0017 (invalid sync manager "
            "configuration); sync "
            "manager 7: activation is on instead of off");
}

TEST(RefusedTransition, NamesASyncManagerWithoutThreeBuffers) {
  DriveLine drives(2);
  ChangingPort port(drives.line(),
                    at_sync_manager_2([](std::span<std::byte> channel) { channel[4] |= std::byte{0x02}; }), {});
  LineOperation operation(drives, port);
  EXPECT_EQ(
      everything(operation),
      "slave 0: requested SAFEOP, is in PREOP + error, AL status code 0x0029 (free run needs three-buffer mode); sync "
      "manager 2: control byte is 0x66 instead of 0x64");
}

/// The lengths match the PDOs, but the address does not.
TEST(RefusedTransition, NamesASyncManagerInAnotherPlace) {
  DriveLine drives(2);
  ChangingPort port(drives.line(),
                    at_sync_manager_2([](std::span<std::byte> channel) { channel[1] = std::byte{0x1D}; }), {});
  LineOperation operation(drives, port);
  EXPECT_THAT(
      everything(operation),
      testing::StartsWith("slave 0: requested SAFEOP, is in PREOP + error, AL status code 0x001D (invalid output "
                          "configuration); sync manager 2: start address is 0x1D00 instead of 0x1"));
}

}  // namespace
}  // namespace driveline::bus_test

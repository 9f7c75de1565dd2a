#include "driveline/ecat_master/state_machine.hpp"

#include <gmock/gmock.h>

#include <map>

namespace driveline::ecat_master {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using wire::AlState;
using wire::AlStatusCode;

const facts::StateRefused& refusal(const Result<void>& result) {
  return std::get<facts::StateRefused>(result.error().facts);
}

/// Slaves that consist of their AL registers, and react with a delay. Every exchange takes 10 us.
class AlRegisters final : public DatagramExchange {
 public:
  struct Slave {
    AlState state = AlState::kInit;
    bool error = false;
    AlStatusCode code = AlStatusCode::kNoError;
    bool dead = false;
    std::chrono::nanoseconds delay{0};  ///< from a request to its effect
    bool never_clears = false;          ///< keeps its error after an acknowledge
    AlStatusCode refuses = AlStatusCode::kNoError;
    std::vector<std::uint16_t> written{};
    bool reads_eeprom = false;        ///< the application refuses a higher state without the EEPROM interface
    std::vector<std::byte> owners{};  ///< values written to register 0x0500
  };
  explicit AlRegisters(std::uint16_t count) : slaves(count) {
    for (std::uint16_t i = 0; i < count; ++i) refs.push_back({i, static_cast<std::uint16_t>(0x1001 + i)});
  }

  std::vector<Slave> slaves;
  std::vector<SlaveRef> refs;

  Result<void> exchange(std::span<Request> requests) override {
    now_ += microseconds{10};
    settle();
    for (auto& request : requests) {
      request.answered = true;
      auto& slave = slaves.at(request.address.adp() - 0x1001U);
      request.working_counter = slave.dead ? 0 : 1;
      if (slave.dead) continue;
      if (request.command == wire::Command::kFpwr && request.address.ado() == 0x0500) {
        slave.owners.push_back(request.data[0]);
      } else if (request.command == wire::Command::kFpwr) {
        slave.written.push_back(bytes::load_le<std::uint16_t>(request.data));
        pending_.emplace(now_ + slave.delay, &slave);
      } else {
        const auto status = wire::AlStatus{slave.state, slave.error, false}.raw();
        bytes::store_le<std::uint16_t>(request.data, status);
        if (request.data.size() == 6) {
          bytes::store_le<std::uint16_t>(request.data.subspan(4), static_cast<std::uint16_t>(slave.code));
        }
      }
    }
    settle();
    return {};
  }
  void pause(std::chrono::nanoseconds duration) override { now_ += duration; }
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept override { return now_; }

 private:
  void settle() {
    while (!pending_.empty() && pending_.begin()->first <= now_) {
      auto& slave = *pending_.begin()->second;
      pending_.erase(pending_.begin());
      const auto control = wire::AlControl::from_raw(slave.written.back());
      if (control.acknowledge && !slave.never_clears) slave.error = false;
      if (slave.error) continue;
      slave.code = AlStatusCode::kNoError;
      if (control.state > slave.state && slave.refuses != AlStatusCode::kNoError) {
        slave.error = true;
        slave.code = slave.refuses;
      } else if (control.state > slave.state && slave.reads_eeprom && slave.owners.empty()) {
        slave.error = true;
        slave.code = AlStatusCode::kEepromNoAccess;
      } else {
        slave.state = control.state;
      }
    }
  }

  std::multimap<std::chrono::nanoseconds, Slave*> pending_;
  std::chrono::nanoseconds now_{0};
};

struct Bench {
  explicit Bench(std::uint16_t count) : registers(count), bus(registers) {}
  Result<void> change(AlState target) { return change_state(bus, registers.refs, target, milliseconds{100}); }
  Result<void> lower(AlState target) { return lower_state(bus, registers.refs, target, milliseconds{100}); }
  AlRegisters registers;
  Bus bus;
};

TEST(ChangeState, AsksAllAtOnceAndWaitsForTheSlowest) {
  Bench bench(3);
  bench.registers.slaves[1].delay = milliseconds{40};
  ASSERT_TRUE(bench.change(AlState::kPreOp));
  EXPECT_EQ(bench.registers.slaves[1].state, AlState::kPreOp);
  EXPECT_GE(bench.registers.now(), milliseconds{40});
  for (const auto& slave : bench.registers.slaves) EXPECT_THAT(slave.written, testing::ElementsAre(0x0002));
}

TEST(ChangeState, AcknowledgesErrorsInTheStateTheSlaveIsIn) {
  Bench bench(2);
  bench.registers.slaves[1] = {AlState::kSafeOp, true, AlStatusCode::kSyncManagerWatchdog};
  ASSERT_TRUE(bench.change(AlState::kPreOp));
  EXPECT_THAT(bench.registers.slaves[0].written, testing::ElementsAre(0x0002));
  EXPECT_THAT(bench.registers.slaves[1].written, testing::ElementsAre(0x0014, 0x0002));
}

TEST(ChangeState, DoesNotTakeAnOldErrorForARefusal) {
  Bench bench(1);
  bench.registers.slaves[0] = {AlState::kSafeOp, true, AlStatusCode::kSyncManagerWatchdog};
  bench.registers.slaves[0].delay = milliseconds{5};
  EXPECT_TRUE(bench.change(AlState::kPreOp));
}

TEST(ChangeState, NamesAnErrorThatDoesNotGoAway) {
  Bench bench(2);
  bench.registers.slaves[1] = {AlState::kPreOp, true, AlStatusCode::kPllError};
  bench.registers.slaves[1].never_clears = true;
  const auto done = bench.change(AlState::kSafeOp);
  ASSERT_FALSE(done);
  EXPECT_TRUE(done.error().is<facts::StateRefused>());
  EXPECT_EQ(done.error().slave, 1);
  EXPECT_EQ(refusal(done).code, wire::AlStatusCode::kPllError);
  EXPECT_LT(bench.registers.now(), milliseconds{200});
}

TEST(ChangeState, GivesTheEepromToAnApplicationThatRefusesWithoutIt) {
  Bench bench(2);
  bench.registers.slaves[1].reads_eeprom = true;
  bench.registers.slaves[1].delay = milliseconds{7};
  ASSERT_TRUE(bench.change(AlState::kPreOp));
  EXPECT_EQ(bench.registers.slaves[1].state, AlState::kPreOp);
  EXPECT_THAT(bench.registers.slaves[1].owners, testing::ElementsAre(std::byte{1}));
  EXPECT_THAT(bench.registers.slaves[1].written, testing::ElementsAre(0x0002, 0x0011, 0x0002));
  EXPECT_TRUE(bench.registers.slaves[0].owners.empty());
  EXPECT_THAT(bench.registers.slaves[0].written, testing::ElementsAre(0x0002));
}

TEST(ChangeState, NamesASlaveThatCannotReadItsEepromEither) {
  Bench bench(1);
  bench.registers.slaves[0].refuses = AlStatusCode::kEepromNoAccess;
  const auto done = bench.change(AlState::kPreOp);
  ASSERT_FALSE(done);
  EXPECT_EQ(refusal(done).code, AlStatusCode::kEepromNoAccess);
  EXPECT_THAT(bench.registers.slaves[0].owners, testing::ElementsAre(std::byte{1})) << "once";
}

TEST(ChangeState, NamesTheSlaveThatRefuses) {
  Bench bench(3);
  bench.registers.slaves[2].refuses = AlStatusCode::kInvalidMailboxConfigurationPreOp;
  const auto done = bench.change(AlState::kPreOp);
  ASSERT_FALSE(done);
  EXPECT_TRUE(done.error().is<facts::StateRefused>());
  EXPECT_EQ(done.error().slave, 2);
  EXPECT_EQ(refusal(done).requested, AlState::kPreOp);
  EXPECT_EQ(refusal(done).actual, AlState::kInit);
  EXPECT_EQ(refusal(done).code, wire::AlStatusCode::kInvalidMailboxConfigurationPreOp);
  EXPECT_EQ(bench.registers.slaves[0].state, AlState::kPreOp) << "the others stay where they have got";
}

TEST(ChangeState, NamesTheSlaveThatIsLate) {
  Bench bench(3);
  bench.registers.slaves[1].delay = milliseconds{101};
  bench.registers.slaves[2].delay = milliseconds{101};
  const auto done = bench.change(AlState::kPreOp);
  ASSERT_FALSE(done);
  EXPECT_TRUE(done.error().is<facts::StateTimeout>());
  EXPECT_EQ(done.error().slave, 1);
  EXPECT_EQ(std::get<facts::StateTimeout>(done.error().facts).timeout, std::chrono::milliseconds{100});
}

TEST(ChangeState, OfNobodyIsDone) {
  Bench bench(0);
  EXPECT_TRUE(bench.change(AlState::kPreOp));
}

TEST(ChangeStates, NobodyWaitsForAnotherAndEachHasItsResult) {
  Bench bench(4);
  bench.registers.slaves[0].delay = milliseconds{50};
  bench.registers.slaves[1].refuses = AlStatusCode::kPllError;
  bench.registers.slaves[2].dead = true;
  std::vector<StateTarget> targets;
  for (const auto& slave : bench.registers.refs) targets.push_back({slave, milliseconds{20}});
  targets[3].timeout = milliseconds{100};
  bench.registers.slaves[3].delay = milliseconds{80};
  const auto results = change_states(bench.bus, targets, AlState::kPreOp);
  ASSERT_EQ(results.size(), 4U);
  EXPECT_TRUE(results[0].error().is<facts::StateTimeout>()) << "its own limit counts";
  EXPECT_EQ(std::get<facts::StateTimeout>(results[0].error().facts).timeout, std::chrono::milliseconds{20});
  EXPECT_TRUE(results[1].error().is<facts::StateRefused>());
  EXPECT_TRUE(results[2].error().is<facts::WorkingCounter>());
  EXPECT_TRUE(results[3]);
  EXPECT_EQ(first_failure(results).error().slave, 1) << "a refusal says more than silence";
}

TEST(StateTimeouts, DependOnTheWay) {
  const StateTimeouts timeouts;
  EXPECT_EQ(timeouts.limit(AlState::kPreOp, false), milliseconds{3000});
  EXPECT_EQ(timeouts.limit(AlState::kSafeOp, false), milliseconds{10'000});
  EXPECT_EQ(timeouts.limit(AlState::kSafeOp, true), milliseconds{200});
  EXPECT_EQ(timeouts.limit(AlState::kInit, true), milliseconds{5000});
}

TEST(LowerState, LeavesThoseBelowWhereTheyAre) {
  Bench bench(4);
  bench.registers.slaves[0].state = AlState::kOp;
  bench.registers.slaves[1].state = AlState::kSafeOp;
  bench.registers.slaves[2].state = AlState::kPreOp;
  ASSERT_TRUE(bench.lower(AlState::kSafeOp));
  EXPECT_EQ(bench.registers.slaves[0].state, AlState::kSafeOp);
  for (const auto i : {1U, 2U, 3U}) EXPECT_THAT(bench.registers.slaves[i].written, testing::IsEmpty());
  ASSERT_TRUE(bench.lower(AlState::kInit));
  for (const auto& slave : bench.registers.slaves) EXPECT_EQ(slave.state, AlState::kInit);
}

TEST(LowerState, GoesOnWithoutADeadSlaveAndNamesIt) {
  Bench bench(3);
  for (auto& slave : bench.registers.slaves) slave.state = AlState::kOp;
  bench.registers.slaves[1].dead = true;
  const auto done = bench.lower(AlState::kInit);
  ASSERT_FALSE(done);
  EXPECT_TRUE(done.error().is<facts::WorkingCounter>());
  EXPECT_EQ(done.error().slave, 1);
  EXPECT_EQ(bench.registers.slaves[0].state, AlState::kInit);
  EXPECT_EQ(bench.registers.slaves[2].state, AlState::kInit);
}

}  // namespace
}  // namespace driveline::ecat_master

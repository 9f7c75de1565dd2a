// Services that each transition of the EtherCAT state machine starts and stops: mailbox, inputs, outputs (MSD manual
// 9.2).
#include "bench_slave.hpp"

namespace driveline::slaves::test {
namespace {

class StateServices : public BenchSlave {
 protected:
  struct Services {
    bool mailbox = false;
    bool inputs = false;
    bool outputs = false;
    friend bool operator==(const Services&, const Services&) = default;
  };
  Services running() {
    Services services;
    const auto before = device().output_count;
    services.mailbox = write(kMailboxOutAddress, std::vector<std::byte>(kMailboxLength)) == 1;
    services.inputs = read(kInputsAddress, 6).working_counter == 1;
    write(kOutputsAddress, bytes({1, 2, 3, 4}));
    pass(1ms);
    services.outputs = device().output_count > before;
    return services;
  }
};

TEST_F(StateServices, EveryTransitionStartsAndStopsWhatTheManualSays) {
  using enum AlState;
  const Services none{};
  const Services mailbox{true, false, false};
  const Services inputs{true, true, false};
  const Services all{true, true, true};
  struct Row {
    AlState from, to;
    Services before, after;
  };
  for (const auto& row :
       {Row{kOp, kInit, all, none}, Row{kInit, kPreOp, none, mailbox}, Row{kPreOp, kInit, mailbox, none},
        Row{kOp, kPreOp, all, mailbox}, Row{kPreOp, kSafeOp, mailbox, inputs}, Row{kSafeOp, kPreOp, inputs, mailbox},
        Row{kSafeOp, kOp, inputs, all}, Row{kOp, kSafeOp, all, inputs}, Row{kSafeOp, kInit, inputs, none}}) {
    SCOPED_TRACE(std::string(to_text(row.from)) + " to " + std::string(to_text(row.to)));
    rebuild();
    go_to(row.from);
    if (row.from < kSafeOp) configure_process_data();
    if (row.from == kInit) configure_mailboxes();
    EXPECT_EQ(running(), row.before);
    request(row.to);
    pass(1ms);
    EXPECT_EQ(to_text(status().state), to_text(row.to));
    EXPECT_EQ(running(), row.after);
  }
}

}  // namespace
}  // namespace driveline::slaves::test

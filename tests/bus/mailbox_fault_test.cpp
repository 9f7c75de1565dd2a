#include <gmock/gmock.h>

#include <deque>

#include "drive_line.hpp"
#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "edited_line.hpp"
#include "fault_ports.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
using ecat_master::Master;
using Bytes = std::vector<std::byte>;

/// A line in PREOP whose first drive sends mailbox messages made by the test.
struct TalkingLine {
  TalkingLine() : drives(3), master(drives.line(), drives.clock) {
    EXPECT_EQ(sentence(master.scan()), "");
    EXPECT_EQ(sentence(master.enter_pre_op()), "");
  }
  EditedDevice& device() { return drives.device(0); }
  CoeClient coe(std::uint16_t slave = 0) { return CoeClient(master.mailboxes(), slave); }
  ecat_master::Result<std::uint32_t> product(std::uint16_t slave = 0) {
    return coe(slave).upload_as<std::uint32_t>(0x1018, 2);
  }
  EditedLine drives;
  Master master;
};

/// A mailbox message without a counter, so that it is never taken for a repetition.
Bytes mail(std::uint8_t type, std::initializer_list<unsigned> service) {
  Bytes bytes{static_cast<std::byte>(service.size()),
              std::byte{0},
              std::byte{0},
              std::byte{0},
              std::byte{0},
              static_cast<std::byte>(type)};
  for (const auto byte : service) bytes.push_back(static_cast<std::byte>(byte));
  return bytes;
}

const Bytes kEmergency = mail(3, {0x00, 0x10, 0x20, 0x32, 5, 1, 2, 3, 4, 5});
const Bytes kEoeFragment = mail(2, {0x00, 0x00, 0x00, 0x00, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF});
const Bytes kMailboxError = mail(0, {1, 0, 2, 0});
const Bytes kOtherSdoAnswer = mail(3, {0x00, 0x30, 0x43, 0x18, 0x10, 0x03, 1, 2, 3, 4});
const Bytes kTxPdo = mail(3, {0x00, 0x40, 1, 2, 3, 4});
const Bytes kVendorProtocol = mail(15, {1, 2, 3});
const Bytes kUnknownProtocol = mail(9, {});

TEST(AheadOfAnSdoAnswer, NothingConfusesTheTransfer) {
  const std::pair<const char*, Bytes> ahead[] = {
      {"an emergency", kEmergency},
      {"an EoE fragment", kEoeFragment},
      {"a mailbox error", kMailboxError},
      {"the answer to another request", kOtherSdoAnswer},
      {"a PDO by mailbox", kTxPdo},
      {"a vendor's protocol", kVendorProtocol},
      {"an unknown protocol", kUnknownProtocol},
  };
  for (const auto& [what, bytes] : ahead) {
    TalkingLine line;
    line.device().says_first = {bytes, bytes};
    const auto product = line.product();
    ASSERT_EQ(sentence(product), "") << what;
    EXPECT_EQ(*product, slaves::msd::kProductCode) << what;
    EXPECT_EQ(line.product().value(), slaves::msd::kProductCode) << "and the next one after " << what;
  }
}

TEST(AheadOfAnSdoAnswer, AllOfItAtOnce) {
  TalkingLine line;
  line.device().says_first = {kEmergency,      kEoeFragment, kMailboxError,    kOtherSdoAnswer,
                              kVendorProtocol, kEmergency,   kUnknownProtocol, kTxPdo};
  EXPECT_EQ(line.product().value(), slaves::msd::kProductCode);
  EXPECT_EQ(line.master.emergencies().take(0).size(), 2U);
  EXPECT_GE(line.master.mailboxes().statistics(0).unclaimed, 6U);
}

TEST(AheadOfAnSdoAnswer, InTheMidstOfSegments) {
  TalkingLine line;
  int answers = 0;
  line.device().changes_answer = [&](std::span<std::byte>, std::size_t length) {
    if (++answers == 1) line.device().says_first = {kEmergency, kEoeFragment};
    return length;
  };
  // Longer than a mailbox: the parameter name object takes up to 100 characters, the EEPROM's object list more.
  const auto all = line.coe().object_list();
  ASSERT_EQ(sentence(all), "");
  EXPECT_GT(all->size(), 50U);
}

TEST(UnknownProtocol, IsRefusedOnceWithTheCodeOfTheStandard) {
  TalkingLine line;
  std::vector<Bytes> replies;
  line.device().hears = [&](std::span<const std::byte> mailbox) {
    if (std::to_integer<unsigned>(mailbox[5] & std::byte{0x0F}) != 0) return;
    replies.emplace_back(mailbox.begin(), mailbox.begin() + 10);
    replies.back()[5] &= std::byte{0x0F};
  };
  line.device().says_first = {kEoeFragment, kVendorProtocol, kEoeFragment, kEmergency};
  ASSERT_EQ(sentence(line.product()), "");
  ASSERT_EQ(sentence(line.product()), "") << "the refusals are on their way";
  EXPECT_THAT(replies, testing::ElementsAre(kMailboxError, kMailboxError)) << "once for EoE, once for VoE";
  EXPECT_EQ(line.master.mailboxes().statistics(0).refused, 3U);
  EXPECT_EQ(line.master.emergencies().take(0).size(), 1U) << "CoE is known";
}

TEST(UnknownProtocol, ASlaveThatAnswersTheRefusalLosesNothing) {
  TalkingLine line;
  line.device().hears = [&](std::span<const std::byte> mailbox) {
    if ((mailbox[5] & std::byte{0x0F}) == std::byte{0}) line.device().says_first = {kMailboxError};
  };
  line.device().says_first = {kEoeFragment};
  for (int i = 0; i < 5; ++i) EXPECT_EQ(sentence(line.product()), "") << i;
}

TEST(MailboxError, InsteadOfTheAnswerIsTheResult) {
  TalkingLine line;
  line.device().changes_answer = [](std::span<std::byte> out, std::size_t) {
    std::copy(kMailboxError.begin(), kMailboxError.end(), out.begin());
    return kMailboxError.size();
  };
  const auto begin = line.drives.clock.now();
  EXPECT_EQ(sentence(line.product()),
            "slave 0: answered object 1018h:02 with mailbox error 0x0002 (unsupported protocol)");
  EXPECT_LT(line.drives.clock.now() - begin, milliseconds{200}) << "not the full time limit";
}

TEST(MalformedAnswer, IsNamedAndTheNextTransferWorks) {
  using Change = std::function<std::size_t(std::span<std::byte>, std::size_t)>;
  const std::pair<const char*, Change> changes[] = {
      {"length beyond the mailbox",
       [](std::span<std::byte> out, std::size_t length) {
         out[0] = std::byte{0xFF};
         out[1] = std::byte{0xFF};
         return length;
       }},
      {"no service data",
       [](std::span<std::byte> out, std::size_t) {
         out[0] = out[1] = std::byte{0};
         return std::size_t{6};
       }},
      {"cut in the SDO header",
       [](std::span<std::byte> out, std::size_t) {
         out[0] = std::byte{5};
         return std::size_t{11};
       }},
      {"another command specifier",
       [](std::span<std::byte> out, std::size_t length) {
         out[8] = std::byte{0xE0};
         return length;
       }},
      {"a normal answer of four gigabytes",
       [](std::span<std::byte> out, std::size_t length) {
         out[8] = std::byte{0x41};
         for (std::size_t i = 12; i < 16; ++i) out[i] = std::byte{0xFF};
         return length;
       }},
      {"all ones",
       [](std::span<std::byte> out, std::size_t) {
         std::fill(out.begin(), out.end(), std::byte{0xFF});
         return out.size();
       }},
  };
  for (const auto& [what, change] : changes) {
    TalkingLine line;
    line.device().changes_answer = change;
    const auto begin = line.drives.clock.now();
    const auto product = line.product();
    ASSERT_FALSE(product) << what;
    EXPECT_EQ(product.error().slave, 0) << what;
    EXPECT_THAT(sentence(product), testing::HasSubstr("1018h:02")) << what;
    EXPECT_LT(line.drives.clock.now() - begin, std::chrono::seconds{3}) << what;
    line.device().changes_answer = {};
    EXPECT_EQ(sentence(line.product()), "") << "after " << what;
    EXPECT_EQ(sentence(line.product(2)), "") << "another slave, " << what;
  }
}

TEST(RandomAnswers, NeverCrashOrHangTheMaster) {
  std::uint32_t state = 1;
  auto random = [&state] { return state = state * 1664525U + 1013904223U; };
  TalkingLine line;
  line.device().changes_answer = [&](std::span<std::byte> out, std::size_t length) {
    for (int i = 0; i < 3; ++i) out[(random() >> 8) % length] = static_cast<std::byte>(random() >> 24);
    return length;
  };
  for (int i = 0; i < 20; ++i) {
    const auto begin = line.drives.clock.now();
    static_cast<void>(line.coe().upload(0x1008, 0).has_value());
    static_cast<void>(line.coe().entry_description(0x6065, 0).has_value());
    EXPECT_LT(line.drives.clock.now() - begin, std::chrono::seconds{6});
  }
  line.device().changes_answer = {};
  EXPECT_EQ(sentence(line.product(1)), "");
}

TEST(LateAnswer, IsWaitedForAndWhenItIsTooLateNotTakenForAnother) {
  // Answers are held back; a request sent meanwhile gets its own answer afterwards.
  TalkingLine line;
  std::vector<Bytes> held;
  bool holding = true;
  line.device().changes_answer = [&](std::span<std::byte> out, std::size_t length) -> std::size_t {
    if (!holding) return length;
    held.emplace_back(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(length));
    return 0;
  };
  EXPECT_EQ(sentence(line.coe().upload(0x1018, 1)), "slave 0: no mailbox reply for object 1018h:01 within 2000 ms");
  holding = false;
  line.device().says_first = held;
  const auto product = line.product();
  ASSERT_EQ(sentence(product), "");
  EXPECT_EQ(*product, slaves::msd::kProductCode);
}

/// A wire with two masters: each of them also receives the frames of the other.
class SharedWire {
 public:
  class End final : public PassingPort {
   public:
    End(port::Port& line, SharedWire& wire) : PassingPort(line), wire_(wire) {}
    [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override { return wire_.next(*this); }
    bool wait_readable(nanoseconds deadline) noexcept override {
      return next_ < wire_.heard_.size() || inner_.wait_readable(deadline);
    }

   private:
    friend class SharedWire;
    SharedWire& wire_;
    std::size_t next_ = 0;
  };

  explicit SharedWire(port::Port& line) : line_(line), a(line, *this), b(line, *this) {}

 private:
  friend class End;
  std::optional<port::ReceivedFrame> next(End& end) {
    while (const auto frame = line_.receive()) heard_.emplace_back(frame->bytes.begin(), frame->bytes.end());
    if (end.next_ == heard_.size()) return std::nullopt;
    return port::ReceivedFrame{heard_[end.next_++], {}};
  }

  port::Port& line_;
  std::deque<Bytes> heard_;

 public:
  End a;
  End b;
};

TEST(TwoMastersOnOneWire, EachTakesItsOwnFramesOnly) {
  EditedLine drives(3);
  SharedWire wire(drives.line());
  Master first(wire.a, drives.clock);
  Master second(wire.b, drives.clock);
  ASSERT_EQ(sentence(first.scan()), "");
  ASSERT_EQ(sentence(first.enter_pre_op()), "");
  EXPECT_EQ(describe_traffic(first.exchange_statistics()), "");
  const auto reports = second.peek_states();
  ASSERT_EQ(sentence(reports), "");
  EXPECT_EQ(reports->size(), 3U);
  EXPECT_EQ((*reports)[0].status.state, wire::AlState::kPreOp) << "an onlooker changes nothing";
  ASSERT_EQ(sentence(CoeClient(first.mailboxes(), 0).upload(0x1018, 1)), "");
  EXPECT_GT(second.exchange_statistics().frames_foreign, 0U);
  EXPECT_THAT(describe_traffic(second.exchange_statistics()),
              testing::MatchesRegex("another EtherCAT master is on the wire: [0-9]+ of its frames were received, the "
                                    "last one from ([0-9A-F]{2}:){5}[0-9A-F]{2}; two masters disturb each other"));
}

TEST(TwoMastersOnOneWire, ThatOneCyclesIsToldWithWhatTheOtherDoes) {
  DriveLine drives(3);
  SharedWire wire(drives.line());
  IdleOperation operation(drives, wire.a);
  ecat_master::LineSupervisor supervisor(operation.master());
  Master second(wire.b, drives.clock);
  const auto live = [&] {
    for (int i = 0; i < 20; ++i) {
      operation.run(milliseconds{1});
      supervisor.poll();
    }
  };
  live();
  ASSERT_EQ(supervisor.events(), 0U) << describe(supervisor.history().front());
  // It only reads.
  ASSERT_EQ(sentence(second.peek_states()), "");
  live();
  ASSERT_EQ(supervisor.events(), 1U);
  EXPECT_THAT(
      what_happened(supervisor.history()[0]),
      testing::MatchesRegex("another EtherCAT master is on the wire: [0-9]+ of its frames were received, the last one "
                            "from ([0-9A-F]{2}:){5}[0-9A-F]{2}, among them APRD to AL status \\(0x0130\\); two "
                            "masters disturb each other"));
  // It sends all slaves to INIT.
  const auto init = bytes::to_le_bytes(wire::AlControl{wire::AlState::kInit, false, false}.raw());
  ASSERT_TRUE(second.bus().broadcast_write(wire::reg::kAlControl.address, init));
  operation.run(milliseconds{2});
  supervisor.poll();
  std::string all;
  for (const auto& event : supervisor.history()) all += what_happened(event) + "\n";
  EXPECT_THAT(all, testing::ContainsRegex("among them BWR to AL control \\(0x0120\\); two masters disturb each other\n"
                                          "slave 0: left OP, is in INIT"));
  // Each sentence is reported only once.
  ASSERT_TRUE(second.bus().broadcast_write(wire::reg::kAlControl.address, init));
  live();
  EXPECT_EQ(std::count_if(supervisor.history().begin(), supervisor.history().end(),
                          [](const auto& e) { return e.kind == ecat_master::LineEvent::Kind::kOtherMaster; }),
            2);
}

TEST(TwoMastersOnOneWire, AToolOfThisProgramIsNobodyToSpeakOfUntilItChangesStates) {
  DriveLine drives(3);
  SharedWire wire(drives.line());
  IdleOperation operation(drives, wire.a);
  ecat_master::LineSupervisor supervisor(operation.master());
  Master tool(wire.b, drives.clock, {.exchange = {.guest = true}});
  const auto live = [&] {
    for (int i = 0; i < 20; ++i) {
      operation.run(milliseconds{1});
      supervisor.poll();
    }
  };
  live();
  ASSERT_EQ(sentence(tool.peek_states()), "");
  const std::array divider{std::byte{0xC2}, std::byte{0x09}};
  ASSERT_TRUE(tool.bus().broadcast_write(wire::reg::kWatchdogDivider.address, divider));
  live();
  EXPECT_EQ(supervisor.events(), 0U);
  EXPECT_EQ(operation.master().core()->foreign_frames(), 0U);
  EXPECT_EQ(operation.master().core()->other_master().frames, 0U);
  // The tool is distinguished like any second master.
  EXPECT_GT(tool.exchange_statistics().frames_of_masters, 0U) << "it hears the master";
  // State changes of the line are reported, whichever program sends them.
  const auto init = bytes::to_le_bytes(wire::AlControl{wire::AlState::kInit, false, false}.raw());
  ASSERT_TRUE(tool.bus().broadcast_write(wire::reg::kAlControl.address, init));
  operation.run(milliseconds{2});
  supervisor.poll();
  ASSERT_GT(supervisor.events(), 0U);
  EXPECT_THAT(what_happened(supervisor.history()[0]), testing::HasSubstr("among them BWR to AL control (0x0120)"));
}

TEST(TwoMastersOnOneWire, AMasterThatComesFindsOutWhoseTheLineIs) {
  constexpr auto kTimeout = milliseconds{150};
  DriveLine drives(3);
  SharedWire wire(drives.line());
  Master second(wire.b, drives.clock);
  const auto nobodys = second.find_owner(kTimeout);
  ASSERT_EQ(sentence(nobodys), "");
  EXPECT_FALSE(nobodys->in_op);
  IdleOperation operation(drives, wire.a);
  operation.run(milliseconds{5});
  Master third(wire.b, drives.clock);
  const auto driven = third.find_owner(kTimeout);
  ASSERT_EQ(sentence(driven), "");
  EXPECT_EQ(driven->in_op, 0);
  EXPECT_TRUE(driven->heard);
  EXPECT_TRUE(drives.all_in(wire::AlState::kOp)) << "looking changes nothing";
  // The first master is silent from now on, and the watchdogs of its drives expire.
  Master fourth(wire.b, drives.clock);
  const auto left = fourth.find_owner(kTimeout);
  ASSERT_EQ(sentence(left), "");
  EXPECT_FALSE(left->in_op);
}

TEST(TwoMastersOnOneWire, ALineThatWasLeftInOpIsNobodys) {
  DriveLine drives(3);
  SharedWire wire(drives.line());
  IdleOperation operation(drives, wire.a);
  Master other(wire.b, drives.clock);
  // Drives without watchdog, and a silent first master.
  ASSERT_TRUE(other.bus().broadcast_write(wire::reg::kWatchdogTimeProcessData.address, std::array<std::byte, 2>{}));
  Master second(wire.b, drives.clock);
  const auto left = second.find_owner(milliseconds{150});
  ASSERT_EQ(sentence(left), "");
  EXPECT_EQ(left->in_op, 0);
  EXPECT_FALSE(left->heard);
}

/// Inserts foreign frames between those of the line.
class NoisyPort final : public PassingPort {
 public:
  using PassingPort::PassingPort;
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override {
    if (++calls_ % 2 == 0) return inner_.receive();
    noise_.assign(14 + (calls_ * 7) % 200, std::byte{static_cast<unsigned char>(calls_)});
    const auto kind = (calls_ / 2) % 4;
    if (kind >= 1) noise_[12] = std::byte{0x88};
    if (kind >= 1) noise_[13] = std::byte{0xA4};
    // A frame of an unknown sender; a frame with this instance but a number never sent; an empty frame.
    if (kind >= 2) std::fill(noise_.begin() + 6, noise_.begin() + 12, std::byte{0});
    if (kind == 3) noise_.resize(14);
    ++frames;
    return port::ReceivedFrame{noise_, {}};
  }
  bool wait_readable(nanoseconds deadline) noexcept override { return inner_.wait_readable(deadline); }
  std::size_t frames = 0;

 private:
  std::size_t calls_ = 0;
  Bytes noise_;
};

TEST(ForeignTraffic, BetweenAllFramesChangesNothing) {
  DriveLine drives(3);
  NoisyPort port(drives.line());
  IdleOperation operation(drives, port);
  operation.run(milliseconds{50});
  EXPECT_TRUE(drives.all_in(wire::AlState::kOp));
  EXPECT_EQ(operation.statistics().wkc_errors, 0U);
  EXPECT_EQ(operation.statistics().lost_frames, 0U);
  EXPECT_GT(port.frames, 400U);
  EXPECT_THAT(describe_traffic(operation.master().exchange_statistics()),
              testing::HasSubstr("frames of unknown origin were received"));
  EXPECT_EQ(sentence(operation.master().shut_down()), "");
}

}  // namespace
}  // namespace driveline::bus_test

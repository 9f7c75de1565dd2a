// Texts for parameter 551 of the MC7000: every line that is taken is a record in range, and no program can hold the
// drive.

#include <cstdlib>
#include <string>

#include "driveline/slaves/mc7000/sequence_control.hpp"
#include "fuzz_target.hpp"

namespace driveline::fuzz {
namespace {

using namespace slaves::mc7000;  // NOLINT(google-build-using-namespace): the file has nothing else
using namespace std::chrono_literals;

/// An axis that is where it is told to be after two looks.
class QuickDrive final : public SequenceDrive {
 public:
  [[nodiscard]] MotionState motion() const noexcept override {
    return {.moving = looks_ > 0, .in_position = looks_ == 0};
  }
  [[nodiscard]] bool referenced() const noexcept override { return referenced_; }
  void start_reference_run() noexcept override {
    referenced_ = true;
    looks_ = 2;
  }
  [[nodiscard]] PosModLocation start_move(std::int32_t /*position*/, std::int32_t speed) noexcept override {
    if (speed <= 0) std::abort();
    looks_ = 2;
    return PosModLocation::kNone;
  }
  void release_feed(bool /*released*/) noexcept override {}
  void jog(int /*direction*/) noexcept override {}
  void stop() noexcept override { looks_ = 0; }
  [[nodiscard]] std::optional<bool> input(ConditionSource /*source*/, std::uint8_t number) const noexcept override {
    if (number >= 16) return std::nullopt;
    return number % 2 == 1;
  }
  void set_output(std::uint8_t /*number*/, bool /*state*/) noexcept override {}
  void tx_pdo_event(std::uint8_t tx_pdo) noexcept override {
    if (tx_pdo != 1 && tx_pdo != 2) std::abort();
    ++events_;
  }

  void advance() noexcept {
    if (looks_ > 0) --looks_;
    if (events_ > 1) std::abort();  // one TxPDO per step
    events_ = 0;
  }

 private:
  bool referenced_ = false;
  int looks_ = 0;
  int events_ = 0;
};

void check(const Record& record) {
  if (record.number > kMaxRecord || record.target > kMaxRecord || record.field >= kFields) std::abort();
  for (const auto& operand : {record.value, record.speed}) {
    if (operand.variable && (operand.value < 0 || operand.value >= static_cast<int>(kFields))) std::abort();
  }
}

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  QuickDrive drive;
  SequenceControl control(drive, 250us);
  std::string line;
  const auto end_line = [&] {
    const auto parsed = parse_line(line);
    if (!parsed && text_of(parsed.error()).empty()) std::abort();
    if (parsed && std::holds_alternative<Record>(*parsed)) check(std::get<Record>(*parsed));
    const bool taken = control.command(line).has_value();
    if (taken && !parsed) std::abort();
    line.clear();
  };
  for (const auto byte : input) {
    if (static_cast<char>(byte) == '\n') {
      end_line();
    } else {
      line += static_cast<char>(byte);
    }
  }
  end_line();
  constexpr std::uint16_t kAutomatic = 0x085F;
  constexpr std::uint16_t kStart = 0x087F;
  for (int step = 0; step < 300; ++step) {
    control.step(step < 50 ? kAutomatic : kStart, true);
    drive.advance();
  }
  const auto state = control.state();
  if (state == SequenceState::kManual || state == SequenceState::kReady) std::abort();
  if ((state == SequenceState::kFault) != (control.fault() != PosModLocation::kNone)) std::abort();
}

std::vector<Bytes> seeds() {
  // MC7000 manual, lines 924, 1299-1307, 1610-1612.
  constexpr std::string_view kTexts[] = {
      "%P00 (Commissioning)\nN010 SET H10=5000\nN020 SET H11=655360\nN030 SET H12=0\nN040 SET H20=2\nN100 GO 0\n"
      "N110 WAIT (IE01=1)\nN120 GO W A H11 H10\nN130 WAIT H20\nN140 WAIT (IE02=0)\nN150 GO W A H12 H10\n"
      "N160 WAIT H20\nN200 JMP N110\nEND\n",
      "%P00\nN010 SET H98=655360;\nN100 GO 0;\nN110 JMP (M90=1) N110;\nN120 GO W A H98 V5000;\nN140 JMP (M90=0) "
      "N120;\nEND",
      "%P00\nN010 GO 0\nN020 GO W A0 V1000\nN030 SET H01 = 1\nN040 SET M99 = 1\nN045 WAIT 2\nN080 GO A-200000 V1000\n"
      "N100 SET M98 = 1\nN110 WAIT (IS03=1)\nN120 JMP N020\nEND\n",
      "%P07\nN1 WAIT 3\nEND\n%P00\nN010 SET M01=1\nN020 SET M01=0\nN030 JMP N010\nEND\n%CLP07\n%SAV\n"};
  std::vector<Bytes> inputs;
  for (const auto text : kTexts) {
    inputs.emplace_back();
    for (const char c : text) inputs.back().push_back(static_cast<std::byte>(c));
  }
  return inputs;
}

}  // namespace driveline::fuzz

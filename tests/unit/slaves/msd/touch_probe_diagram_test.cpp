// The timing diagrams of the touch probe (MSD manual Figures 14.1, 14.2), cycle by cycle with the process data of a
// moving drive; for every signal that can be configured, because their "timing is corresponding".
#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

/// A line of a diagram: the commands and machine signals in a bus cycle, and the inputs at its end.
struct DiagramRow {
  unsigned function = 0;  ///< 60B8h
  bool level = false;     ///< level of the input; zero pulse: whether it is passed in this cycle
  unsigned status = 0;    ///< 60B9h
  int taken = 0;          ///< line whose edge position the object holds; 0: none yet
  const char* says = "";
};

/// A drive at constant speed with 60B8h in an RxPDO, 60B9h-60BDh in TxPDOs.
class ProbeDiagram {
 public:
  explicit ProbeDiagram(unsigned variant) {
    rig_.set({{0x206A, 0, 15, 2}, {0x206B, 0, 15, 2}});
    EXPECT_EQ(rig_.write(0x28ED, 0, variant, 2), 0U);
    rig_.map(0x1600, {0x60B80010, 0x60400010});
    rig_.map(0x1601, {0x60600008, 0x60FF0020});
    rig_.map(0x1A00, {0x60B90010, 0x60BA0020});
    rig_.map(0x1A01, {0x60BB0020, 0x60BC0020});
    rig_.map(0x1A02, {0x60BD0020});
    rig_.set({{0x60C2, 1, 125, 1}, {0x60C2, 2, 0xFA, 1}, real_value(0x2132, 0, 0.125F)});
    EXPECT_EQ(rig_.to(AlState::kPreOp, AlState::kSafeOp), AlStatusCode::kNoError);
    EXPECT_EQ(rig_.to(AlState::kSafeOp, AlState::kOp), AlStatusCode::kNoError);
    for (const unsigned word : {0x00U, 0x06U, 0x07U, 0x0FU}) {
      control_ = word;
      for (int i = 0; i < 4; ++i) cycle(0);
    }
    for (int i = 0; i < 800; ++i) cycle(0);
    EXPECT_EQ(rig_.drive.state(), PowerState::kOperationEnabled);
    EXPECT_GT(std::abs(rig_.drive.velocity_rad_s()), 10.0);
  }

  /// `source`: 1, 2 the inputs, 0 the zero pulse. `object`: index in 60BAh-60BDh.
  void follow(unsigned source, unsigned object, const std::vector<DiagramRow>& rows) {
    std::vector<double> edges(rows.size() + 1, 0.0);
    bool level = false;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const DiagramRow& row = rows[i];
      SCOPED_TRACE(testing::Message() << "line " << i + 1 << ": " << row.says);
      edges[i + 1] = source == 0 ? pulse(row) : change(source, row, row.level != level);
      if (source != 0) level = row.level;
      EXPECT_EQ(status_, row.status);
      if (row.taken == 0) {
        EXPECT_EQ(value_[object], 0);
      } else {
        EXPECT_NEAR(value_[object], edges[static_cast<std::size_t>(row.taken)], source == 0 ? 0.0 : 3.0);
      }
      for (unsigned other = 0; other < 4; ++other) {
        EXPECT_TRUE(other == object || value_[other] == 0) << "another object: " << other;
      }
    }
    // The other sources must have no effect.
    const unsigned status = status_;
    if (source != 1) change(1, {rows.back().function, true}, true);
    if (source != 2) change(2, {rows.back().function, true}, true);
    EXPECT_EQ(status_, status);
  }

 private:
  static constexpr auto kInto = 37us;  ///< time in the bus cycle at which inputs change

  double change(unsigned source, const DiagramRow& row, bool edge) {
    const double from = rig_.drive.position_rad();
    const Input input = source == 1 ? Input::kIsd05 : Input::kIsd06;
    EXPECT_TRUE(!edge || rig_.drive.schedule_input(input, row.level, rig_.now + kInto));
    cycle(row.function);
    const double share = 37.0 / 125.0;
    return (from + share * (rig_.drive.position_rad() - from)) * kIncrementsPerRadian;
  }
  /// With the zero pulse: runs cycles up to the one that passes it. Without: runs a cycle that does not pass it.
  double pulse(const DiagramRow& row) {
    const auto turn = [this] { return std::floor(rig_.drive.position_rad() / (2.0 * std::numbers::pi)); };
    const double before = turn();
    cycle(row.function);
    while (row.level && turn() == before) cycle(row.function);
    EXPECT_EQ(turn() != before, row.level) << "the diagram needs the pulse in the line that has it";
    return std::max(turn(), before) * 1048576.0;
  }
  void cycle(unsigned function) {
    std::array<std::byte, 9> out{};
    const std::span bytes(out);
    bytes::store_le(bytes, static_cast<std::uint16_t>(function));
    bytes::store_le(bytes.subspan(2), static_cast<std::uint16_t>(control_));
    bytes::store_le(bytes.subspan(4), std::int8_t{9});
    bytes::store_le(bytes.subspan(5), std::int32_t{20'000'000});
    rig_.device.write_outputs(2, out);
    rig_.now += 125us;
    rig_.device.advance(rig_.now);
    std::array<std::byte, 18> in{};
    rig_.device.read_inputs(3, in);
    const std::span<const std::byte> read(in);
    status_ = bytes::load_le<std::uint16_t>(read);
    for (std::size_t i = 0; i < 4; ++i) value_[i] = bytes::load_le<std::int32_t>(read.subspan(2 + 4 * i));
  }

  DriveRig rig_;
  unsigned control_ = 0;
  unsigned status_ = 0;
  std::array<std::int32_t, 4> value_{};
};

constexpr unsigned kCia402 = 1;

/// One of the signals of Table 14.2, with its bits.
struct Signal402 {
  unsigned source = 1;    ///< 1, 2: ISD05, ISD06; 0: zero pulse
  unsigned shift = 0;     ///< 0 probe 1, 8 probe 2
  bool negative = false;  ///< edge
  const char* name = "";
  [[nodiscard]] unsigned activate() const { return 1U << shift; }
  [[nodiscard]] unsigned continuous() const { return 2U << shift; }
  [[nodiscard]] unsigned zero() const { return source == 0 ? 4U << shift : 0U; }
  [[nodiscard]] unsigned edge() const { return (negative ? 0x20U : 0x10U) << shift; }
  [[nodiscard]] unsigned stored() const { return (negative ? 4U : 2U) << shift; }
  [[nodiscard]] unsigned toggle() const { return (negative ? 0x80U : 0x40U) << shift; }
  [[nodiscard]] unsigned object() const { return (shift == 0 ? 0U : 2U) + (negative ? 1U : 0U); }
};

class TouchProbeDiagram402 : public testing::TestWithParam<Signal402> {};

TEST_P(TouchProbeDiagram402, SingleTriggerMode) {
  const Signal402 s = GetParam();
  const unsigned on = s.activate() | s.zero();
  const unsigned armed = on | s.edge();
  const unsigned active = s.activate();
  const unsigned taken = active | s.stored();
  // `a` makes the relevant edge; the zero pulse has no other.
  const bool a = !s.negative || s.source == 0;
  const bool b = s.source != 0 && !a;
  std::vector<DiagramRow> rows = {
      {0, b, 0, 0, "nothing is activated"},
      {on, b, active, 0, "activated: the status says so at once"},
      {on, a, active, 0, "no edge is selected"},
      {on, b, active, 0, "and none the other way"},
      {armed, b, active, 0, "armed: nothing before the edge"},
      {armed, a, taken, 6, "the edge: value and status in the same cycle"},
      {armed, b, taken, 6, "the other edge does not count"},
      {armed, a, taken, 6, "a second edge does not count in single trigger mode"},
      {armed, b, taken, 6, "and the status stays"},
      {on, b, active, 6, "the edge deselected: the status bit falls, the value stays"},
      {on, a, active, 6, "an edge while nothing is selected"},
      {on, b, active, 6, ""},
      {armed, b, active, 6, "selected again: armed again, nothing by itself"},
      {armed, a, taken, 14, "the next edge overwrites the value"},
      {s.zero(), b, 0, 14, "deactivated: all status bits fall, the value stays"},
      {s.zero() | s.edge(), a, 0, 14, "not activated"},
      {armed, b, active, 14, "activated again with the edge selected: armed"},
      {armed, a, taken, 18, "its edge"},
      {0, b, 0, 18, "off"},
  };
  ProbeDiagram(kCia402).follow(s.source, s.object(), rows);
}

TEST_P(TouchProbeDiagram402, ContinuousTriggerMode) {
  const Signal402 s = GetParam();
  const unsigned armed = s.activate() | s.continuous() | s.zero() | s.edge();
  const unsigned active = s.activate();
  const unsigned odd = active | s.stored() | s.toggle();
  const unsigned even = active | s.stored();
  const bool a = !s.negative || s.source == 0;
  const bool b = s.source != 0 && !a;
  std::vector<DiagramRow> rows = {
      {0, b, 0, 0, "nothing is activated"},
      {armed, b, active, 0, "armed"},
      {armed, a, odd, 3, "first edge: stored, and the toggle bit changes"},
      {armed, b, odd, 3, "the other edge changes nothing"},
      {armed, a, even, 5, "second edge: a new value, the toggle bit changes back, stored stays"},
      {armed, b, even, 5, ""},
      {armed, a, odd, 7, "third edge"},
      {armed, b, odd, 7, ""},
      {armed & ~s.edge(), b, active, 7, "the edge deselected: both bits fall"},
      {armed & ~s.edge(), a, active, 7, "and edges do nothing"},
      {armed & ~s.edge(), b, active, 7, ""},
      {armed, b, active, 7, "selected again"},
      {armed, a, odd, 13, "the toggle bit begins anew"},
      {0, b, 0, 13, "off"},
  };
  ProbeDiagram(kCia402).follow(s.source, s.object(), rows);
}

INSTANTIATE_TEST_SUITE_P(
    Signals, TouchProbeDiagram402,
    testing::Values(Signal402{1, 0, false, "Isd05Positive"}, Signal402{1, 0, true, "Isd05Negative"},
                    Signal402{2, 8, false, "Isd06Positive"}, Signal402{2, 8, true, "Isd06Negative"},
                    Signal402{0, 0, false, "ZeroPulseOfProbe1"}, Signal402{0, 8, false, "ZeroPulseOfProbe2"}),
    [](const auto& test) { return std::string(test.param.name); });

/// One of the five latches of Tables 14.5 and 14.6.
struct VendorLatch {
  unsigned source = 1;
  unsigned bit = 0;  ///< bit in 60B8h and 60B9h; the code that reads it is one higher
  bool negative = false;
  const char* name = "";
};

class TouchProbeDiagramVendor : public testing::TestWithParam<std::tuple<unsigned, VendorLatch>> {};

TEST_P(TouchProbeDiagramVendor, LatchReadAndAcknowledge) {
  const auto [variant, latch] = GetParam();
  constexpr unsigned kBeck2 = 2;
  constexpr unsigned kLatchC = 4;
  const unsigned enable = 1U << latch.bit;
  const unsigned read = (latch.bit + 1) << 8;
  const unsigned object = variant == kBeck2 || latch.bit == kLatchC ? 0 : latch.bit;
  const bool a = !latch.negative || latch.source == 0;
  const bool b = latch.source != 0 && !a;
  std::vector<DiagramRow> rows = {
      {0, b, 0, 0, "nothing is enabled"},
      {0, a, 0, 0, "an edge without enable"},
      {0, b, 0, 0, ""},
      {read, b, 0, 0, "reading what is not valid is not acknowledged"},
      {enable, b, 0, 0, "enabled: nothing before the edge"},
      {enable, a, enable, 0, "the edge: valid, but the value is shown when it is asked for"},
      {enable, b, enable, 0, ""},
      {enable, a, enable, 0, "a second edge does not count"},
      {enable | read, b, enable | read, 6, "asked for: acknowledged, and the object has the value of the first edge"},
      {enable | read, a, enable | read, 6, "while it is shown edges do nothing"},
      {enable, b, enable, 6, "the request ends: so does the acknowledgement, the value stays"},
      {0, b, 0, 6, "enable reset: no longer valid"},
      {read, b, 0, 6, "and not acknowledged"},
      {enable, b, 0, 6, "set again: a new measurement"},
      {enable, a, enable, 6, "its edge"},
      {enable | read, b, enable | read, 15, "the new value"},
      {0, b, 0, 15, "off"},
  };
  ProbeDiagram(variant).follow(latch.source, object, rows);
}

INSTANTIATE_TEST_SUITE_P(Latches, TouchProbeDiagramVendor,
                         testing::Combine(testing::Values(2U, 3U),
                                          testing::Values(VendorLatch{1, 0, false, "Latch1Positive"},
                                                          VendorLatch{1, 1, true, "Latch1Negative"},
                                                          VendorLatch{2, 2, false, "Latch2Positive"},
                                                          VendorLatch{2, 3, true, "Latch2Negative"},
                                                          VendorLatch{0, 4, false, "LatchC"})),
                         [](const auto& test) {
                           return std::string(std::get<0>(test.param) == 2 ? "Beck2" : "Specific") +
                                  std::get<1>(test.param).name;
                         });

}  // namespace
}  // namespace driveline::slaves::msd

// The page of a drive for given values; keys and terminal output.
#include <gmock/gmock.h>

#include "driveline/slaves/msd/core/variant.hpp"
#include "terminal.hpp"
#include "text/drive_page.hpp"
#include "text/seven_segments.hpp"

namespace driveline::cli {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using Object = DriveObject;

std::vector<std::byte> little_endian(std::uint32_t value, std::size_t size) {
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i < size; ++i) bytes.push_back(static_cast<std::byte>(value >> 8 * i));
  return bytes;
}

void set(DriveView& view, Object object, std::uint32_t value, std::size_t size) {
  view.values.set(object, little_endian(value, size));
}
void set(DriveView& view, Object object, std::string_view text) {
  std::vector<std::byte> bytes;
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  view.values.set(object, bytes);
}

/// A moving drive in OP, with the objects of CiA 402 only.
DriveView standard_drive() {
  DriveView view;
  view.position = 2;
  view.slaves = 3;
  view.al.status.state = wire::AlState::kOp;
  view.dl.ports[0] = {true, false, true};
  set(view, Object::kDeviceType, 0x00020192, 4);
  set(view, Object::kDeviceName, "Some drive");
  set(view, Object::kVendor, 0x17, 4);
  set(view, Object::kProduct, 0x1234, 4);
  set(view, Object::kControlWord, 0x000F, 2);
  set(view, Object::kStatusWord, 0x1237, 2);
  set(view, Object::kMode, 8, 1);
  set(view, Object::kModeDisplay, 8, 1);
  set(view, Object::kPositionActual, static_cast<std::uint32_t>(-500), 4);
  set(view, Object::kTargetPosition, static_cast<std::uint32_t>(-480), 4);
  set(view, Object::kTorqueActual, static_cast<std::uint16_t>(-250), 2);
  set(view, Object::kErrorCode, 0, 2);
  return view;
}

/// A simulated MSD with a fault and more objects.
DriveView faulty_msd() {
  DriveView view = standard_drive();
  view.al = {{wire::AlState::kSafeOp, true}, wire::AlStatusCode::kSyncManagerWatchdog};
  set(view, Object::kVendor, 0x28, 4);
  set(view, Object::kProduct, slaves::msd::facts(slaves::msd::Variant::kMsd).product_code, 4);
  set(view, Object::kDeviceName, "MSD Servo Drive");
  set(view, Object::kSoftwareVersion, "124.30-00");
  set(view, Object::kSerial, 7, 4);
  set(view, Object::kAlias, std::string_view("x\0\0\0", 4));
  set(view, Object::kStatusWord, 0x0298, 2);
  set(view, Object::kErrorCode, 0xFF00, 2);
  set(view, Object::kLastError, 0x010EFF00, 4);
  set(view, Object::kFaultText, "EtherCAT watchdog");
  set(view, Object::kWarnings, 0x4, 4);
  set(view, Object::kWarningText, "motor nearly too hot");
  set(view, Object::kDigitalInputs, 0x000C0002, 4);
  set(view, Object::kInputState, 0x00000003, 4);
  set(view, Object::kRatedTorque, 2400, 4);
  set(view, Object::kFeed, 1000, 4);
  set(view, Object::kFeedRevolutions, 1, 4);
  set(view, Object::kDcLink, 560000, 4);
  set(view, Object::kReferenceCycle, 0x3E000000, 4);  // 0.125
  return view;
}

TEST(DrivePage, OfADriveThatHasOnlyTheObjectsOfTheStandard) {
  EXPECT_EQ(drive_page(standard_drive(), 0ns),
            R"(slave 2 of 3   Some drive

  +-----------+   EtherCAT  OP   RUN (*)   X15 L/A (*)   X16 L/A ( )
  |       _   |   drive     Operation enabled   control 0x000F status 0x1237
  |      |_   |   mode      8 cyclic synchronous position
  |       _|. |   fault     none
  +-----------+   warnings  none

                     actual                     demand                     target
  position           -500                                                  -480
  torque, 0.1 %      -250


)");
}

TEST(DrivePage, OfAnMsdWithFaultWarningInputsAndUnits) {
  EXPECT_EQ(drive_page(faulty_msd(), 1s),
            R"(slave 2 of 3   x   MSD Servo Drive   firmware 124.30-00   serial 7

  +-----------+   EtherCAT  SAFEOP + error 0x001B (sync manager watchdog)   RUN ( )   X15 L/A (*)   X16 L/A ( )
  |           |   drive     Fault   control 0x000F status 0x0298
  |   |  |_|  |   mode      8 cyclic synchronous position
  |   |    |  |   fault     0xFF00 (of the manufacturer): EtherCAT watchdog
  +-----------+   warnings  0x00000004: motor nearly too hot

                     actual                     demand                     target
  position           -500 (-0.500 rev)                                     -480 (-0.480 rev)
  torque, 0.1 %      -250 (-0.600 Nm)
  DC link            560.0 V

  inputs 60FDh       0x000C0002  positive limit safe stop ENPO
  terminals 2079h    0x00000003  ENPO ISD00

  rated torque 6076h         2400 mNm          feed 6092h:01              1000 units
  per 6092h:02               1 rev             setpoint cycle P 306       0.125 ms
)");
}

TEST(DrivePage, FlashesLikeTheDrive) {
  const auto digits = [](const DriveView& view, std::chrono::nanoseconds time) {
    const auto page = drive_page(view, time);
    const auto row = page.find('|', page.find("+-----------+") + 13);
    return page.substr(row, page.find("+-----------+", row) - row);
  };
  const auto faulty = faulty_msd();
  EXPECT_NE(digits(faulty, 0s), digits(faulty, 1s)) << "Er, then 14";
  EXPECT_NE(digits(faulty, 1s), digits(faulty, 2s)) << "then 01";
  EXPECT_EQ(digits(faulty, 0s), digits(faulty, 3s));
  // No object of another maker's drive tells the fault number.
  auto other = faulty;
  set(other, Object::kProduct, 0x1234, 4);
  for (const auto time : {0s, 1s, 2s}) EXPECT_EQ(digits(other, time), digits(faulty, 0s)) << "Er stands";
  auto stopped = standard_drive();
  set(stopped, Object::kStatusWord, 0x0250, 2);
  set(stopped, Object::kInputState, 0x01, 4);
  EXPECT_NE(digits(stopped, 0ms), digits(stopped, 500ms)) << "S flashes while STO is active";
  set(stopped, Object::kInputState, 0x81, 4);
  EXPECT_EQ(digits(stopped, 0ms), digits(stopped, 500ms));
}

TEST(DrivePage, SaysWhoElseIsThereAndThatValuesAreOld) {
  auto view = standard_drive();
  EXPECT_THAT(drive_page(view, 0ns), Not(HasSubstr("Another master")));
  view.other_master = true;
  view.trouble = "slave 2 does not answer";
  const auto page = drive_page(view, 0ns);
  EXPECT_THAT(page, HasSubstr("Another master works with this line: only the mailbox of the drive is used"));
  view.al.status.state = wire::AlState::kPreOp;
  EXPECT_THAT(drive_page(view, 0ns),
              HasSubstr("A master has taken this line out of INIT and may be active: only the mailbox"));
  EXPECT_THAT(page, HasSubstr("Previous values: slave 2 does not answer\n"));
}

TEST(DrivePage, JuniorHasItsBicolourLed) {
  auto view = faulty_msd();
  set(view, Object::kProduct, slaves::msd::facts(slaves::msd::Variant::kServoOneJunior).product_code, 4);
  EXPECT_THAT(drive_page(view, 0ms), HasSubstr("H1 green (*) red (*)"));
  EXPECT_THAT(drive_page(view, 300ms), HasSubstr("H1 green ( ) red ( )"));
  EXPECT_THAT(drive_page(view, 500ms), HasSubstr("H1 green ( ) red (*)")) << "double flash: watchdog";
}

TEST(DrivePage, WrongLengthsAndNoNumbersAreLeftOut) {
  auto view = standard_drive();
  set(view, Object::kPositionActual, 1, 2);
  set(view, Object::kTargetPosition, 1, 3);
  set(view, Object::kTorqueActual, 1, 4);
  set(view, Object::kDeviceName, "\x1b[2Jboo\n");
  const auto page = drive_page(view, 0ns);
  EXPECT_THAT(page, Not(HasSubstr("position  ")));
  EXPECT_THAT(page, HasSubstr("?[2Jboo?")) << "no control characters of a device reach the terminal";
  set(view, Object::kReferenceCycle, 0x7FC00000, 4);  // NaN
  EXPECT_FALSE(drive_json(view)["objects"].contains("setpoint_cycle_ms"));
}

TEST(DriveJson, HasNumbersTextsAndWhatTheyMean) {
  const auto document = drive_json(faulty_msd());
  EXPECT_EQ(document["slave"], 2);
  EXPECT_EQ(document["al_state"], "SAFEOP");
  EXPECT_EQ(document["al_error"], true);
  EXPECT_EQ(document["al_status_code"], 0x1B);
  EXPECT_EQ(document["state"], "Fault");
  EXPECT_EQ(document["mode_name"], "cyclic synchronous position");
  EXPECT_EQ(document["display"], "Er");
  EXPECT_EQ(document["objects"]["position_actual"], -500);
  EXPECT_EQ(document["objects"]["fault_text"], "EtherCAT watchdog");
  EXPECT_EQ(document["objects"]["setpoint_cycle_ms"], 0.125);
  EXPECT_FALSE(document["objects"].contains("velocity_actual")) << "the drive did not tell it";
}

TEST(ErrorClass, OfTheCodesOfCia402) {
  EXPECT_EQ(error_class(0), "");
  EXPECT_EQ(error_class(0x2310), "current");
  EXPECT_EQ(error_class(0x3210), "voltage");
  EXPECT_EQ(error_class(0x8611), "monitoring");
  EXPECT_EQ(error_class(0xFF00), "of the manufacturer");
}

TEST(SevenSegments, EveryDigit) {
  const auto drawn_digit = [](char symbol, bool point) { return draw_display({{' ', false}, {symbol, point}}); };
  EXPECT_THAT(drawn_digit('0', false), ElementsAre("      _  ", "     | | ", "     |_| "));
  EXPECT_THAT(drawn_digit('1', false), ElementsAre("         ", "       | ", "       | "));
  EXPECT_THAT(drawn_digit('2', true), ElementsAre("      _  ", "      _| ", "     |_ ."));
  EXPECT_THAT(drawn_digit('4', false), ElementsAre("         ", "     |_| ", "       | "));
  EXPECT_THAT(drawn_digit('7', false), ElementsAre("      _  ", "       | ", "       | "));
  EXPECT_THAT(drawn_digit('8', true), ElementsAre("      _  ", "     |_| ", "     |_|."));
  EXPECT_THAT(draw_display({{'E', false}, {'r', true}}), ElementsAre(" _       ", "|_    _  ", "|_   |  ."));
  EXPECT_THAT(draw_display({{'S', true}, {'?', false}}), ElementsAre(" _       ", "|_    ?  ", " _|.     "));
}

TEST(Keys, AsTerminalsSendThem) {
  for (const auto* quit : {"q", "Q", "\x03", "\x1b", "xq"}) EXPECT_EQ(key_of(quit), Key::kQuit) << quit;
  for (const auto* next : {"n", "N", "\t", "\x1b[C", "\x1b[B", "\x1bOC"}) EXPECT_EQ(key_of(next), Key::kNext) << next;
  for (const auto* reset : {"r", "R"}) EXPECT_EQ(key_of(reset), Key::kReset) << reset;
  for (const auto* previous : {"p", "\x1b[D", "\x1b[A"}) EXPECT_EQ(key_of(previous), Key::kPrevious) << previous;
  for (const auto* nothing : {"", "x", " ", "\x1b[5~", "\x1b[1;5F"}) EXPECT_EQ(key_of(nothing), Key::kNone) << nothing;
  EXPECT_EQ(key_of("\x1b[5~n"), Key::kNext) << "a key that means nothing, and one that does";
}

TEST(TerminalPageText, IsCutToTheTerminal) {
  EXPECT_EQ(drawn("one\ntwo\n", 5, 80), "\x1b[Hone\x1b[K\r\ntwo\x1b[K\x1b[J");
  EXPECT_EQ(drawn("one\ntwo\nthree\n", 2, 2), "\x1b[Hon\x1b[K\r\ntw\x1b[K\x1b[J") << "nothing scrolls";
  EXPECT_EQ(drawn("", 5, 80), "\x1b[H\x1b[J");
  EXPECT_EQ(drawn("a\x1b[2Jb", 5, 80), "\x1b[Ha\\x1B[2Jb\x1b[K\x1b[J") << "what a drive says is no order";
}

}  // namespace
}  // namespace driveline::cli

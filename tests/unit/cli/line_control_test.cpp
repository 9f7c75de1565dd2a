// The control socket of a running line: default path, requests to axes, questions to the line.
#include "commands/line_control.hpp"

#include <gmock/gmock.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <variant>

#include "commands/control_path.hpp"
#include "driveline/runtime/event.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::cli {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;
using testing::HasSubstr;

/// A test with its own folder for sockets.
class ControlTest : public test::TemporaryDirectory {
 protected:
  void SetUp() override {
    TemporaryDirectory::SetUp();
    if (const char* before = ::getenv("XDG_RUNTIME_DIR")) before_ = before;
    ::setenv("XDG_RUNTIME_DIR", directory.c_str(), 1);
  }
  void TearDown() override {
    if (before_.empty()) {
      ::unsetenv("XDG_RUNTIME_DIR");
    } else {
      ::setenv("XDG_RUNTIME_DIR", before_.c_str(), 1);
    }
    TemporaryDirectory::TearDown();
  }
  static unsigned mode_of(const std::filesystem::path& path) {
    struct stat found = {};
    EXPECT_EQ(::stat(path.c_str(), &found), 0) << path;
    return found.st_mode & 0777U;
  }

 private:
  std::string before_;
};

TEST_F(ControlTest, SocketOfALineIsNamedAfterItInAFolderOfTheUserAlone) {
  ASSERT_TRUE(make_control_folder());
  ASSERT_TRUE(make_control_folder()) << "it may be there";
  EXPECT_EQ(mode_of(directory / "driveline"), 0700U);
  EXPECT_EQ(control_path("cell 3/a"), directory / "driveline" / "cell%203%2Fa.socket");
  EXPECT_EQ(control_path("..").filename(), "%2E..socket");
  const auto path = control_path("cell").string();
  const auto input = must(CommandInput::open(path, CommandInput::Sources::kSocket));
  EXPECT_EQ(mode_of(path), 0600U);
}

TEST_F(ControlTest, FolderThatOthersCanReachIsRefused) {
  std::filesystem::create_directory(directory / "driveline");
  ::chmod((directory / "driveline").c_str(), 0755);
  const auto made = make_control_folder();
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().text, HasSubstr("a folder that only this user can access"));
}

TEST_F(ControlTest, TheOnlyLineThatRunsNeedsNoName) {
  EXPECT_EQ(running_control(""), "");
  const auto nobody = find_control("", "");
  ASSERT_FALSE(nobody);
  EXPECT_THAT(nobody.error().text, HasSubstr("no line runs"));
  ASSERT_TRUE(make_control_folder());
  write(control_path("dead"), "");
  const auto a = CommandInput::open(control_path("a"), CommandInput::Sources::kSocket);
  EXPECT_EQ(find_control("", "").value(), control_path("a"));
  EXPECT_EQ(running_control(""), control_path("a"));
  const auto b = CommandInput::open(control_path("b"), CommandInput::Sources::kSocket);
  const auto two = find_control("", "");
  ASSERT_FALSE(two);
  EXPECT_THAT(two.error().text, HasSubstr("several lines run"));
  EXPECT_EQ(running_control(""), "");
  write(directory / "line.toml", "[line]\nname = \"b\"\n[[slave]]\nname = \"x\"\n");
  EXPECT_EQ(find_control("", directory / "line.toml").value(), control_path("b"));
  EXPECT_EQ(find_control("here", directory / "line.toml").value(), "here");
  write(directory / "other.toml", "[line]\nname = \"c\"\n[[slave]]\nname = \"x\"\n");
  EXPECT_THAT(find_control("", directory / "other.toml").error().text, HasSubstr("line \"c\" does not run"));
  EXPECT_EQ(running_control(directory / "other.toml"), "");
}

class LineControlTest : public ControlTest {
 protected:
  LineControlTest() {
    std::vector<motion::Axis> made;
    made.emplace_back(configs[0], motion::ImagePlace{}, motion::axis_pdo_configuration());
    single.emplace(std::move(made), motion::SingleAxes::Settings{});
  }
  static motion::AxisConfig axis_in_degrees() {
    motion::AxisConfig axis;
    axis.name = "x";
    axis.unit = trajectory::find_position_unit("deg");
    return axis;
  }
  void SetUp() override {
    ControlTest::SetUp();
    path = (directory / "line.socket").string();
    auto input = must(CommandInput::open(path, CommandInput::Sources::kSocket));
    control.emplace(std::move(*input), axis_requests, groups);
    axis_requests.open(*single);
  }
  CommandConnection connect() const {
    auto connection = CommandConnection::open(path, "run");
    EXPECT_TRUE(connection) << connection.error().text;
    return std::move(*connection);
  }
  static json ask(CommandConnection& connection, std::string_view words) {
    const auto answer = connection.ask(words);
    EXPECT_TRUE(answer) << answer.error().text;
    return json::parse(answer.value_or("{}"), nullptr, false);
  }
  /// Waits until the condition holds, because the other thread fulfils it at some time.
  template <typename Holds>
  static void wait_until(Holds holds) {
    for (int i = 0; i < 3000 && !holds(); ++i) std::this_thread::sleep_for(milliseconds{10});
    EXPECT_TRUE(holds());
  }

  std::string path;
  std::vector<motion::AxisConfig> configs{axis_in_degrees()};
  rt::VirtualClock clock;
  runtime::AxisRequests axis_requests{configs, clock, [] {}};
  std::vector<runtime::AxisGroupConfig> no_groups;
  runtime::GroupRequests groups{no_groups, axis_requests};
  std::optional<motion::SingleAxes> single;
  std::optional<LineControl> control;
};

TEST_F(LineControlTest, RequestsAreTakenRefusedAndTold) {
  auto client = connect();
  const auto moved = ask(client, "axis x move 90deg velocity=30deg/s");
  EXPECT_EQ(moved.at("axes").at(0).at("name"), "x");
  EXPECT_THAT(moved.at("axes").at(0).at("owner").get<std::string>(),
              HasSubstr("(process " + std::to_string(getpid()) + ", user " + std::to_string(geteuid()) + ")"));
  const auto wrong = ask(client, "axis x mvoe 90deg");
  EXPECT_EQ(wrong.at("error"), "axis x: unknown request \"mvoe\"; did you mean move?");
  EXPECT_EQ(wrong.at("status"), 2);
  EXPECT_EQ(ask(client, "axis x").at("status"), 2);
  const auto progress = ask(client, "axis progress");
  EXPECT_EQ(progress.at("axes").at(0).at("phase"), "waiting");
  EXPECT_FALSE(progress.at("axes").at(0).at("over"));
  EXPECT_EQ(ask(client, "axis all status").at("axes").at(0).at("state"), "Disabled");
  auto other = connect();
  const auto refused = ask(other, "axis x move 10deg");
  EXPECT_EQ(refused.at("status"), 1);
  EXPECT_THAT(refused.at("error").get<std::string>(), HasSubstr("axis x: is commanded by control socket"));
  EXPECT_FALSE(ask(other, "axis x halt").contains("error"));
  EXPECT_FALSE(ask(other, "axis x move 10deg take-over").contains("error"));
  const auto events = axis_requests.take_events();
  EXPECT_EQ(std::count_if(events.begin(), events.end(),
                          [](const auto& event) { return event.template is<runtime::events::AxisRequested>(); }),
            4)
      << "each request that was understood";
}

TEST_F(LineControlTest, WhoGoesLosesHisAxesUnlessHeHasDetached) {
  {
    auto client = connect();
    static_cast<void>(ask(client, "axis x jog 1deg/s"));
    EXPECT_NE(axis_requests.status(0).owner, "");
  }
  wait_until([&] { return axis_requests.status(0).owner.empty(); });
  {
    auto client = connect();
    static_cast<void>(ask(client, "axis x move 1deg"));
    static_cast<void>(ask(client, "axis detach"));
  }
  auto other = connect();
  // The answer to a later connection proves that the end of the first one has been noticed.
  static_cast<void>(ask(other, "axis x status"));
  clock.advance(std::chrono::seconds{10});
  EXPECT_THAT(ask(other, "axis x move 2deg").value("error", ""), HasSubstr("is commanded by"));
}

TEST_F(LineControlTest, AxisIsGivenBackWhenThatIsSaid) {
  auto client = connect();
  static_cast<void>(ask(client, "axis x move 1deg"));
  EXPECT_EQ(ask(client, "axis x release").at("axes").at(0).at("owner"), "");
}

TEST_F(LineControlTest, QuestionsAreAnsweredByTheLineAndHoldUpNoStop) {
  std::string answer;
  std::thread asks([&] { answer = send_command(path, "diag", "run").value_or("nothing"); });
  auto client = connect();
  EXPECT_FALSE(ask(client, "axis x halt").contains("error"));
  bool asked = false;
  wait_until([&] {
    control->answer_questions([&](std::string_view question) {
      asked = true;
      return std::string(question) + "!";
    });
    return asked;
  });
  asks.join();
  EXPECT_EQ(answer, "diag!");
  auto second = connect();
  EXPECT_THAT(ask(second, "group plotter enable").at("error").get<std::string>(),
              HasSubstr("the line has no groups of axes"));
  EXPECT_THAT(send_command(path, "quit", "run").value_or(""), HasSubstr("\"quit\" is not a command of a running line"));
  EXPECT_THAT(send_command(path, "fault list", "run").value_or(""),
              HasSubstr("error: the slaves of this line are on an interface"));
}

}  // namespace
}  // namespace driveline::cli

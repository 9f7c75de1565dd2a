// Which samples `driveline record` counts and leaves out, and how it treats existing files.
#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "gaps.hpp"
#include "mcap_ros2.hpp"
#include "options.hpp"
#include "recorded.hpp"
#include "recording.hpp"
#include "recording_file.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::bridge::clients {
namespace {

using testing::HasSubstr;

class ClientFiles : public test::TemporaryDirectory {
 protected:
  [[nodiscard]] std::string path(const char* name) const { return directory / name; }
  [[nodiscard]] std::string content(const char* name) const { return read(directory / name); }
  void write(const char* name, const std::string& text) const { TemporaryDirectory::write(directory / name, text); }
};

/// An event with that number in CDR, little endian; the rest of it is missing.
std::vector<std::uint8_t> event_of(std::uint64_t number) {
  std::vector<std::uint8_t> bytes(4 + sizeof(number));
  bytes[1] = 1;
  std::memcpy(bytes.data() + 4, &number, sizeof(number));
  return bytes;
}

TEST(Gaps, CountWhatIsMissingWithoutRememberingEveryStep) {
  const auto* const topic = find_topic("driveline/v1/event");
  ASSERT_NE(topic, nullptr);
  Gaps gaps(*topic);
  std::uint64_t number = 0;
  std::uint64_t missing = 0;
  gaps.add(event_of(number));
  for (std::uint64_t step = 1; step < 2000; ++step) {
    number += step;
    missing += step - 1;
    gaps.add(event_of(number));
  }
  EXPECT_EQ(gaps.missing(), missing) << "more different steps than are remembered";
  gaps.add(event_of(3));
  gaps.add(event_of(4));
  EXPECT_EQ(gaps.missing(), missing) << "its writer has begun anew";
}

TEST_F(ClientFiles, ASampleThatCannotBeDecodedIsLeftOutOfATable) {
  const auto* const topic = find_topic("driveline/v1/event");
  auto made = must(create_recording(path("events.csv"), false, {topic}));
  auto& recording = **made;
  ASSERT_TRUE(recording.take_place());
  const auto bad = event_of(1);
  auto good = event_of(2);
  const std::uint8_t rest[] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 'a', 0};
  good.insert(good.end(), std::begin(rest), std::end(rest));
  testing::internal::CaptureStderr();
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(recording.add({topic, bad, 1, 1}));
  EXPECT_TRUE(recording.add({topic, good, 2, 2}));
  EXPECT_TRUE(recording.finish());
  EXPECT_EQ(recording.written()[0], 1U);
  made->reset();
  const auto told = testing::internal::GetCapturedStderr();
  EXPECT_THAT(told, HasSubstr("driveline record: driveline/v1/event: a sample is skipped: "));
  EXPECT_THAT(told, HasSubstr("driveline record: 3 samples were skipped\n"));
  EXPECT_EQ(std::count(told.begin(), told.end(), '\n'), 2);
  const auto table = content("events.csv");
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 2) << table;
}

TEST(DisplayUnits, AreThoseOfTheirAxesAndOtherwiseRadAndM) {
  const std::vector<const char*> words{"top", "--unit", "a=b=deg", "--unit", "z=um"};
  const auto options = must(read_options(static_cast<int>(words.size()), words.data()));
  const auto& units = options->units;
  EXPECT_EQ(units.of("a=b", false).name, "deg");
  EXPECT_DOUBLE_EQ(1.5707963267948966 / units.of("a=b", false).si, 90.0);
  EXPECT_DOUBLE_EQ(0.25 / units.of("z", true).si, 250'000.0);
  EXPECT_EQ(units.of("z", false).name, "rad") << "a unit of the other kind";
  EXPECT_EQ(units.of("y", true).name, "m");
  for (const auto* const wrong : {"deg", "=deg", "x=feet", "x="}) {
    const std::vector<const char*> bad{"top", "--unit", wrong};
    const auto refused = read_options(static_cast<int>(bad.size()), bad.data());
    ASSERT_FALSE(refused) << wrong;
    EXPECT_EQ(refused.error().status, 2);
  }
}

TEST_F(ClientFiles, AnOldRecordingIsThereUntilThereIsSomethingToRecord) {
  write("run.mcap", "precious");
  const auto refused = RecordingFile::create(path("run.mcap"), false);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().status, 2);
  {
    auto file = must(RecordingFile::create(path("run.mcap"), true));
    ASSERT_TRUE(file->add({1, 2, 3}, 0));
    EXPECT_EQ(content("run.mcap"), "precious");
    EXPECT_THAT(RecordingFile::create(path("run.mcap"), true).error().text, HasSubstr("another recorder"));
    EXPECT_TRUE(std::filesystem::exists(directory / "run.mcap.part")) << "it is that of the first recorder";
  }
  EXPECT_FALSE(std::filesystem::exists(directory / "run.mcap.part")) << "it was never of use";
  auto file = must(RecordingFile::create(path("run.mcap"), true));
  ASSERT_TRUE(file->add({'n', 'e', 'w'}, 0));
  ASSERT_TRUE(file->take_place());
  EXPECT_EQ(content("run.mcap"), "new");
  EXPECT_FALSE(std::filesystem::exists(directory / "run.mcap.part"));
  ASSERT_TRUE(file->finish({'!'}));
  EXPECT_EQ(content("run.mcap"), "new!");
}

TEST(RecordingForRos2, TopicsOfRos2HaveTheNamesThatNodesKnow) {
  for (const auto& topic : topics()) {
    const auto name = mcap::recorded_name(topic);
    if (topic.name == "rt/joint_states") {
      EXPECT_EQ(name, "/joint_states");
    } else if (topic.name != "rt/diagnostics") {
      EXPECT_EQ(name, topic.name);
    }
    EXPECT_EQ(mcap::find_recorded(name), &topic);
    EXPECT_EQ(mcap::find_recorded(topic.name), &topic) << "older recordings have the DDS names";
  }
  EXPECT_EQ(mcap::find_recorded("/tf"), nullptr);
}

TEST(RecordingForRos2, QosIsWrittenAsItsOwnRecorderDoes) {
  // metadata.yaml of a recording of /turtle1/cmd_vel by ROS 2 Humble with Fast DDS, reliable and volatile.
  const std::string published =
      "- history: 3\n  depth: 0\n  reliability: 1\n  durability: 2\n  deadline:\n    sec: 9223372036\n    nsec: "
      "854775807\n  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n  liveliness: 1\n  "
      "liveliness_lease_duration:\n"
      "    sec: 9223372036\n    nsec: 854775807\n  avoid_ros_namespace_conventions: false";
  EXPECT_EQ(mcap::offered_qos_profiles(*find_topic("rt/joint_states")), published);
  const auto status = mcap::offered_qos_profiles(*find_topic("driveline/line_status"));
  EXPECT_THAT(status, HasSubstr("reliability: 1\n  durability: 1\n")) << "reliable, transient local";
  EXPECT_THAT(status, HasSubstr("avoid_ros_namespace_conventions: true"));
  EXPECT_THAT(mcap::offered_qos_profiles(*find_topic("driveline/axis_telemetry")),
              HasSubstr("reliability: 2\n  durability: 2\n"));
}

TEST_F(ClientFiles, ARecordingOfATopicOfRos2IsReadBack) {
  const auto* const joints = find_topic("rt/joint_states");
  auto made = must(create_recording(path("run.mcap"), false, {joints}));
  const std::vector<std::uint8_t> bytes{0, 1, 0, 0, 7};
  ASSERT_TRUE((*made)->take_place());
  ASSERT_TRUE((*made)->add({joints, bytes, 2'000'000'005, 2'000'000'003}));
  ASSERT_TRUE((*made)->finish());
  EXPECT_THAT(content("run.mcap"),
              testing::AllOf(HasSubstr("/joint_states"), testing::Not(HasSubstr("rt/joint_states"))));
  std::size_t found = 0;
  ASSERT_TRUE(read_recording(path("run.mcap"), [&](const Recorded& each) {
    ++found;
    EXPECT_EQ(each.topic, joints);
    EXPECT_EQ(each.received_ns, 2'000'000'005);
  }));
  EXPECT_EQ(found, 1U);
}

TEST_F(ClientFiles, ALinkToARecordingStays) {
  write("target.mcap", "old");
  std::filesystem::create_symlink("target.mcap", directory / "run.mcap");
  auto file = must(RecordingFile::create(path("run.mcap"), true));
  ASSERT_TRUE(file->take_place());
  ASSERT_TRUE(file->finish({'n', 'e', 'w'}));
  EXPECT_TRUE(std::filesystem::is_symlink(directory / "run.mcap"));
  EXPECT_EQ(content("target.mcap"), "new");
  EXPECT_FALSE(std::filesystem::exists(directory / "target.mcap.part"));
}

TEST_F(ClientFiles, AFileThatHasComeMeanwhileIsNotOverwritten) {
  auto file = must(RecordingFile::create(path("run.mcap"), false));
  write("run.mcap", "precious");
  const auto taken = file->take_place();
  ASSERT_FALSE(taken);
  EXPECT_THAT(taken.error().text, HasSubstr("exists; --force overwrites it"));
  EXPECT_EQ(content("run.mcap"), "precious");
}

}  // namespace
}  // namespace driveline::bridge::clients

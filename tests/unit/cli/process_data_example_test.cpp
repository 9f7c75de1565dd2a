// examples/process_data.toml from the file to the terminals: copied data arrive, groups keep their own cycle, and the
// outputs of a group whose frames are lost become zero.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "driveline/runtime/record/exchange_group_watch.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "driveline/slaves/generic/generic_device.hpp"
#include "support/must.hpp"
#include "text/image_view.hpp"

namespace driveline::cli {
namespace {

using ecat_master::Master;
using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::HasSubstr;

const auto kExample = std::filesystem::path(DRIVELINE_EXAMPLES_DIR) / "process_data.toml";

/// A line like the example's, in process on virtual time.
class ProcessDataExample : public testing::Test {
 protected:
  static constexpr std::size_t kOutputs = 2, kMixed = 4;

  /// Loads the example with `more` after its [[copy]] tables.
  void load(const std::string& more = "", const std::string& layout = "overlapped") {
    std::ifstream stream(kExample);
    std::ostringstream text;
    text << stream.rdbuf();
    auto lines = text.str();
    lines.replace(lines.find("layout = \"overlapped\""), 21, "layout = \"" + layout + "\"");
    lines.insert(lines.find("[[slave]]"), more + "\n");
    auto parsed = must(runtime::parse_line_config(lines, kExample));
    config = std::move(*parsed);
    line = runtime::make_simulated_line(config, clock);
    master = std::make_unique<Master>(*line, clock, runtime::master_settings(config));
    ASSERT_TRUE(master->scan());
    ASSERT_EQ(failure_text(master->configure(runtime::make_slave_plans(config))), "");
  }
  static std::vector<std::string> told(const std::vector<runtime::EventFacts>& changes) {
    std::vector<std::string> sentences;
    for (const auto& change : changes) sentences.push_back(describe(runtime::Event{change}));
    return sentences;
  }
  std::string refusal() {
    const auto named = runtime::name_process_data(config, *master);
    return named ? "" : describe(named.error());
  }
  void start() {
    auto named = must(runtime::name_process_data(config, *master));
    ecat_master::CyclicCore::Settings settings;
    settings.period = config.period;
    settings.copies = named->copies;
    ASSERT_TRUE(master->start_cycle(nullptr, {}, settings, [this](ecat_master::CyclicCore& core) {
      return std::make_unique<motion::InlineRunner>(core, clock);
    }));
    ASSERT_EQ(failure_text(master->go_operational()), "");
  }
  std::uint64_t object(std::size_t slave, std::uint16_t index, std::uint8_t subindex) {
    const auto& device = dynamic_cast<slaves::generic::GenericDevice&>(line->slave(slave).device());
    return device.dictionary().raw(*device.model().table().find(index, subindex));
  }

  rt::VirtualClock clock;
  runtime::LineConfig config;
  std::unique_ptr<slaves::SimulatedLine> line;
  std::unique_ptr<Master> master;
};

TEST_F(ProcessDataExample, HandsInputsToOutputsOfOtherSlavesInEveryLayout) {
  for (const auto* layout : {"overlapped", "sequential", "lrd_lwr"}) {
    SCOPED_TRACE(layout);
    load("", layout);
    start();
    // Channel 1 toggles every quarter of a second, channel 2 stays on, channels 3 and 4 are copied nowhere.
    std::set<std::uint64_t> lamp;
    for (int i = 0; i < 20; ++i) {
      master->pass(milliseconds{50});
      lamp.insert(object(kOutputs, 0x7000, 1));
    }
    EXPECT_THAT(lamp, ElementsAre(0U, 1U));
    EXPECT_EQ(object(kOutputs, 0x7010, 1), 1U);
    EXPECT_EQ(object(kOutputs, 0x7020, 1), 0U);
    EXPECT_EQ(object(kMixed, 0x7000, 3), 1234U) << "out of the group of slow slaves into that of fast ones";
    EXPECT_EQ(master->core()->statistics().wkc_errors, 0U);
    EXPECT_TRUE(master->shut_down());
    master.reset();
  }
}

TEST_F(ProcessDataExample, GroupsKeepTheirOwnTime) {
  load();
  start();
  const auto groups = master->core()->groups();
  ASSERT_EQ(groups.size(), 3U);
  std::array<std::uint64_t, 3> before{};
  for (std::size_t i = 0; i < 3; ++i) before[i] = groups[i].exchanges.value();
  master->pass(milliseconds{100});
  EXPECT_EQ(groups[0].exchanges.value() - before[0], 400U);
  EXPECT_EQ(groups[1].exchanges.value() - before[1], 100U) << "every 4th cycle";
  EXPECT_EQ(groups[2].exchanges.value() - before[2], 10U) << "every 40th cycle";
}

TEST_F(ProcessDataExample, OutputsBecomeZeroWhenTheirFramesStayAwayAndComeBackWithThem) {
  load();
  start();
  runtime::ExchangeGroupWatch watch(config.process_data);
  master->pass(milliseconds{10});
  EXPECT_THAT(watch.poll(*master->core()), testing::IsEmpty());
  ASSERT_EQ(object(kOutputs, 0x7010, 1), 1U);
  // In four cycles the group has one frame and the others have four: more than three exchanges are lost.
  line->drop_frames(20);
  master->pass(milliseconds{6});
  EXPECT_EQ(object(kOutputs, 0x7010, 1), 0U);
  EXPECT_THAT(told(watch.poll(*master->core())),
              ElementsAre("group terminals: outputs zeroed after 3 incomplete exchanges in a row",
                          "group terminals: exchange complete again, outputs released"));
  master->pass(milliseconds{4});
  EXPECT_EQ(object(kOutputs, 0x7010, 1), 1U);
  EXPECT_EQ(watch.zeroings(1), 1U);
  const auto view = runtime::view_image(config, *master, master->core()->groups(), &watch);
  EXPECT_THAT(to_text(view), HasSubstr("outputs zero after 3 bad, 1 time(s)"));
}

TEST_F(ProcessDataExample, ShowsAddressesNamesGroupsDatagramsAndWireTime) {
  load();
  const auto named = must(runtime::name_process_data(config, *master));
  const auto text = image_text(config, *master, *named);
  for (const auto* part :
       {"process data: overlapped, ", "group terminals    every 4 cycles from 0, 2 slave(s)",
        "group slow         every 40 cycles from 2, 1 slave(s)", "inputs.Channel 8/Input", "outputs.lamp",
        "x.Position actual value", "mixed.Select", "LRD", " us of 250.0 us on the wire, ", " us (measured)\n",
        "copy    inputs.6010:01 -> outputs.7010:01, 1 bits"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  // Outputs and inputs of the drive in the same bytes, those of the device without LRW not.
  const auto& places = master->image().places();
  EXPECT_EQ(places[5].output_offset, places[5].input_offset);
  EXPECT_NE(places[kMixed].output_offset, places[kMixed].input_offset);
  const auto document = image_json(config, *master, *named);
  EXPECT_EQ(document["groups"].size(), 3U);
  EXPECT_EQ(document["slaves"][5]["output_address"], document["slaves"][5]["input_address"]);
  unsigned expected = 0;
  for (const auto& datagram : document["datagram_list"]) expected += datagram["working_counter"].get<unsigned>();
  EXPECT_EQ(expected, 10U) << "drive 3, mixed 2, inputs 1, outputs 3, analogue 1";
  EXPECT_EQ(document["wire_time_ns"].get<int>(),
            document["wire_frames_ns"].get<int>() + document["wire_line_ns"].get<int>());
}

TEST_F(ProcessDataExample, RefusesWhatOnlyTheConfiguredLineCanTell) {
  const auto copy = [](const std::string& from, const std::string& to) {
    return "[[copy]]\nfrom = \"" + from + "\"\nto = \"" + to + "\"\n";
  };
  const auto place = [](const char* key) {
    return kExample.string() + ":" + (*key == 'f' ? "45" : "46") + ": [copy 4] " + key + ": ";
  };
  load(copy("inputs.Input", "outputs.7030:01"));
  EXPECT_THAT(refusal(),
              HasSubstr(place("from") + "'inputs.Input' is ambiguous: it may be "
                                        "inputs.6000h:01 (Channel 1/Input), inputs.6010h:01 (Channel 2/Input)"));
  load(copy("inputs.Channel 9/Input", "outputs.7030:01"));
  EXPECT_THAT(refusal(), HasSubstr(place("from") + "there is no process variable 'inputs.Channel 9/Input'; the slave "
                                                   "has inputs.6000h:01 (Channel 1/Input)"));
  load(copy("inputs.6030:01", "outputs.lamp"));
  EXPECT_EQ(refusal(), place("to") + "\"outputs.lamp\" is already written by the copy from \"inputs.Channel 1/Input\"");
  load(copy("analogue.Channel 1/Value", "x.target_torque"));
  EXPECT_EQ(refusal(), place("to") + "x.6071h:00 (Target torque) is written by the axis \"x\"");
  load(copy("analogue.Channel 1/Value", "outputs.7030:01"));
  EXPECT_EQ(refusal(), place("to") +
                           "analogue.6000h:11 (Value) has 16 bits and outputs.7030h:01 (Output) has 1: they "
                           "cannot be copied");
  load(copy("outputs.7030:01", "outputs.7020:01"));
  EXPECT_EQ(refusal(), place("to") + "outputs.7030h:01 (Output) cannot be the source of a copy: it is an output");
}

TEST_F(ProcessDataExample, RefusesNamesOfNothing) {
  load();
  config.slaves[kOutputs].names.push_back({"horn", "7040:01", "line.toml:70: [slave 3.names] horn"});
  EXPECT_THAT(refusal(), HasSubstr("line.toml:70: [slave 3.names] horn: there is no process variable "
                                   "'outputs.7040:01'; the slave has outputs.7000h:01 (Channel 1/Output)"));
  config.slaves[kOutputs].names.back() = {"Lamp", "7010:01", "line.toml:70: [slave 3.names] Lamp"};
  EXPECT_EQ(refusal(), "line.toml:70: [slave 3.names] Lamp: 'Lamp' is already the name of outputs.7000h:01 (Output)");
}

}  // namespace
}  // namespace driveline::cli

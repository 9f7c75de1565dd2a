// The web page of a drive, and its document.
#include "cockpit.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "driveline/slaves/msd/msd_drive.hpp"

namespace driveline::endpoint {
namespace {

using nlohmann::json;
using slaves::DeviceStatus;

/// The state of an MSD that has just been switched on.
CockpitState msd_state() {
  slaves::msd::MsdParameters parameters;
  parameters.name = "X-Axis";
  parameters.serial_number = 4711;
  slaves::msd::MsdDrive drive(parameters);
  for (int i = 0; i <= 40; ++i) drive.advance(i * drive.process_data_period());
  CockpitState state;
  drive.show(state.device);
  state.address.ip = {192, 168, 38, 5};
  state.address.mac = {std::byte{2}, std::byte{0xE0}, {}, {}, std::byte{0x12}, std::byte{0x67}};
  state.link = true;
  state.running = std::chrono::seconds{12};
  return state;
}

TEST(Cockpit, TheDocumentSaysWhatTheDriveShows) {
  const auto document = json::parse(state_json(msd_state()));
  EXPECT_EQ(document["identity"]["maker"], "Moog");
  EXPECT_EQ(document["identity"]["type"], "MSD Servo Drive");
  EXPECT_EQ(document["identity"]["name"], "X-Axis");
  EXPECT_EQ(document["identity"]["firmware"], "124.30-00");
  EXPECT_EQ(document["identity"]["vendor_id"], "0x00000028");
  EXPECT_EQ(document["identity"]["serial_number"], 4711);
  EXPECT_EQ(document["drive"]["state"], "switch on disabled");
  EXPECT_EQ(document["drive"]["mode"], "none");
  EXPECT_EQ(document["drive"]["fault"], false);
  EXPECT_EQ(document["network"]["al_state"], "INIT");
  EXPECT_EQ(document["network"]["ip"], "192.168.38.5");
  EXPECT_EQ(document["network"]["mac"], "02:e0:00:00:12:67");
  EXPECT_EQ(document["network"]["link"], true);
  EXPECT_EQ(document["running_s"], 12);
  EXPECT_EQ(document["values"].size(), 7U);
  EXPECT_EQ(document["values"][5]["name"], "DC link voltage");
  EXPECT_NEAR(document["values"][5]["value"], 560.0, 1.0);
  EXPECT_EQ(document["values"][5]["unit"], "V");
  EXPECT_GE(document["parameters"].size(), 10U);
}

TEST(Cockpit, PageAndDocumentAreSeveralKilobytes) {
  EXPECT_GT(state_json(msd_state()).size(), 2000U);
  EXPECT_GT(cockpit_page().size(), 4000U);
}

TEST(Cockpit, ThePageNeedsNothingFromElsewhereAndReadsTheDocument) {
  EXPECT_THAT(cockpit_page(), testing::HasSubstr("fetch(\"/state.json\""));
  EXPECT_THAT(cockpit_page(), testing::Not(testing::HasSubstr("http://")));
  EXPECT_THAT(cockpit_page(), testing::Not(testing::HasSubstr("https://")));
  // The content comes from outside and must never be interpreted as markup.
  EXPECT_THAT(cockpit_page(), testing::Not(testing::HasSubstr("innerHTML")));
}

TEST(Cockpit, NamesInAnyEncodingAndTooManyValuesMakeAValidDocument) {
  CockpitState state;
  state.device.name = "\xFF\xFE\"\\<b>";
  for (unsigned i = 0; i < DeviceStatus::kMaxValues + 5; ++i) {
    state.device.add(DeviceStatus::Kind::kActual, "a name that is longer than the room that there is", i);
  }
  const auto document = json::parse(state_json(state));
  EXPECT_EQ(document["values"].size(), DeviceStatus::kMaxValues);
  EXPECT_EQ(document["values"][3]["name"].get<std::string>().size(), 32U);
  state.device.value_count = 4'000'000'000U;
  EXPECT_EQ(json::parse(state_json(state))["values"].size(), DeviceStatus::kMaxValues);
}

}  // namespace
}  // namespace driveline::endpoint

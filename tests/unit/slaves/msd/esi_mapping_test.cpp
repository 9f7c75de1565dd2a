// The mappings for the modes of operation that the ESI file proposes (MSD manual 9.1).
#include <algorithm>
#include <map>
#include <set>

#include "drive_rig.hpp"
#include "driveline/esi/esi_file.hpp"
#include "driveline/esi/sii.hpp"
#include "driveline/esi/sii_difference.hpp"
#include "support/must.hpp"

namespace driveline::slaves::msd {
namespace {

const esi::Pdo& pdo_of(const esi::DeviceDescription& device, std::uint16_t index) {
  for (const auto* pdos : {&device.rx_pdos, &device.tx_pdos}) {
    for (const auto& pdo : *pdos) {
      if (pdo.index == index) return pdo;
    }
  }
  throw std::logic_error("no such PDO");
}

std::vector<std::uint32_t> entries_of(const esi::Pdo& pdo) {
  std::vector<std::uint32_t> raw;
  for (const auto& e : pdo.entries) {
    raw.push_back(std::uint32_t{e.index} << 16 | std::uint32_t{e.subindex} << 8 | e.bit_length);
  }
  return raw;
}

TEST(EsiMapping, EveryModeHasTheObjectsItNeeds) {
  const auto device = esi_description();
  const std::map<std::string, std::set<std::uint16_t>> needed = {
      {"DC CSP", {0x6040, 0x6060, 0x607A}},
      {"DC CSP offsets", {0x6040, 0x6060, 0x607A, 0x60B1, 0x60B2}},
      {"DC CSV", {0x6040, 0x6060, 0x60FF}},
      {"DC CST", {0x6040, 0x6060, 0x6071}},
      {"DC IP", {0x6040, 0x6060, 0x60C1}},
      {"Free-Run CSP", {0x6040, 0x6060, 0x607A}},
      {"Free-Run PP", {0x6040, 0x6060, 0x607A, 0x6081}},
      {"Free-Run PV", {0x6040, 0x6060, 0x60FF, 0x6042}}};
  std::set<std::string> seen;
  for (const auto& mode : device.dc_modes) {
    if (mode.assignments.empty()) continue;
    SCOPED_TRACE(mode.name);
    ASSERT_TRUE(needed.contains(mode.name));
    seen.insert(mode.name);
    std::set<std::uint16_t> objects;
    std::size_t bytes = 0;
    for (const auto& assignment : mode.assignments) {
      for (const auto index : assignment.pdos) {
        EXPECT_EQ(pdo_of(device, index).sync_manager, assignment.sync_manager);
        for (const auto& entry : pdo_of(device, index).entries) {
          objects.insert(entry.index);
          bytes += assignment.sync_manager == 2 ? entry.bit_length / 8U : 0U;
        }
      }
    }
    EXPECT_TRUE(
        std::includes(objects.begin(), objects.end(), needed.at(mode.name).begin(), needed.at(mode.name).end()));
    for (const int input : {0x6041, 0x6061, 0x6064, 0x606C, 0x6077, 0x60F4}) {
      EXPECT_TRUE(objects.contains(static_cast<std::uint16_t>(input))) << std::hex << input;
    }
    EXPECT_EQ(mode.assign_activate, mode.name.starts_with("DC") ? 0x0300 : 0);
    EXPECT_LE(bytes, 24U) << "no more than the mode needs";
  }
  EXPECT_EQ(seen.size(), needed.size());
}

TEST(EsiMapping, IsTakenByEveryVariantAndFirmware) {
  for (const auto& facts : kVariants) {
    for (const auto firmware : {facts.firmware, facts.oldest}) {
      SCOPED_TRACE(std::string(facts.key) + " " + firmware.text());
      const auto device = esi_description(facts.variant);
      MsdParameters parameters;
      parameters.variant = facts.variant;
      parameters.firmware = firmware;
      DriveRig rig(parameters);
      std::size_t out = 0;
      for (const auto& pdo : device.rx_pdos) {
        rig.map(pdo.index, entries_of(pdo));
        for (const auto& entry : pdo.entries) out += entry.bit_length / 8U;
      }
      for (const auto& pdo : device.tx_pdos) rig.map(pdo.index, entries_of(pdo));
      EXPECT_EQ(rig.device.process_data_size(2), out);
      EXPECT_EQ(out, 30U);
    }
  }
}

TEST(EsiMapping, NamesAndTypesAreThoseOfTheDictionary) {
  for (const auto& facts : kVariants) {
    const auto device = esi_description(facts.variant);
    for (const auto* pdos : {&device.rx_pdos, &device.tx_pdos}) {
      for (const auto& pdo : *pdos) {
        for (const auto& entry : pdo.entries) {
          const auto* row = dictionary_table(facts.variant).find(entry.index, entry.subindex);
          ASSERT_NE(row, nullptr);
          EXPECT_EQ(entry.name, row->name);
          EXPECT_EQ(entry.type, row->type);
          EXPECT_EQ(entry.bit_length, bit_size(*row));
        }
      }
    }
  }
}

TEST(EsiMapping, TheDriveItselfComesWithEmptyPdos) {
  const MsdDrive drive;
  const auto image = must(esi::decode_sii(drive.profile().sii_image));
  for (const auto& pdo : esi::description_from_sii(*image).rx_pdos) EXPECT_TRUE(pdo.entries.empty());
  const auto planned = esi::make_sii(esi_description());
  EXPECT_TRUE(esi::compare_sii(*image, planned).empty()) << "what the master maps is no difference";
  auto filled = esi_description();
  filled.rx_pdos[0].entries.pop_back();
  EXPECT_FALSE(esi::compare_sii(esi::make_sii(filled), planned).empty()) << "another mapping is";
}

TEST(EsiMapping, ReadsBackFromTheFile) {
  const auto device = esi_description(Variant::kServoOne);
  const auto file = must(esi::read_esi(esi::write_esi({device}), "drive.xml"));
  EXPECT_TRUE(file->notes.empty());
  EXPECT_EQ(file->devices.front().rx_pdos, device.rx_pdos);
  EXPECT_EQ(file->devices.front().tx_pdos, device.tx_pdos);
  EXPECT_EQ(file->devices.front().dc_modes, device.dc_modes);
}

/// Names of the elements directly below the first `parent` in `xml`, without repetition of neighbours.
std::vector<std::string> children(const std::string& xml, const std::string& parent) {
  std::vector<std::string> names;
  int depth = 0;
  for (auto at = xml.find("<" + parent); at != std::string::npos; at = xml.find('<', at + 1)) {
    const auto end = xml.find('>', at);
    if (xml[at + 1] == '!') continue;
    if (xml[at + 1] == '/') {
      if (--depth == 0) break;
      continue;
    }
    const auto name = xml.substr(at + 1, xml.find_first_of(" >/", at + 1) - at - 1);
    if (depth == 1 && (names.empty() || names.back() != name)) names.push_back(name);
    if (xml[end - 1] != '/') ++depth;
  }
  return names;
}

TEST(EsiMapping, ElementsStandInTheOrderOfTheSchema) {
  using testing::ElementsAre;
  const auto xml = esi::write_esi({esi_description()});
  EXPECT_THAT(children(xml, "Device "), ElementsAre("Type", "Name", "GroupType", "Profile", "Fmmu", "Sm", "RxPdo",
                                                    "TxPdo", "Mailbox", "Dc", "Eeprom"));
  EXPECT_THAT(children(xml, "RxPdo "), ElementsAre("Index", "Name", "Entry"));
  EXPECT_THAT(children(xml.substr(xml.find("<RxPdo ")), "Entry"),
              ElementsAre("Index", "SubIndex", "BitLen", "Name", "DataType"));
  EXPECT_THAT(children(xml.substr(xml.find("DC CSP") - 30), "OpMode"),
              ElementsAre("Name", "Desc", "AssignActivate", "CycleTimeSync0", "ShiftTimeSync0", "CycleTimeSync1",
                          "ShiftTimeSync1", "Sm"));
  EXPECT_THAT(children(xml.substr(xml.find("DC CSP")), "Sm "), ElementsAre("Pdo"));
}

}  // namespace
}  // namespace driveline::slaves::msd

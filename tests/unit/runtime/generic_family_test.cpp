// Slaves simulated from a device file: their keys in a line description, and errors in these.
#include "devices/generic/generic_family.hpp"

#include <gmock/gmock.h>

#include "driveline/esi/sii.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "driveline/runtime/setup/process_data_plan.hpp"
#include "driveline/slaves/msd/msd_table.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::runtime {
namespace {

using slaves::Signal;
using testing::HasSubstr;
using testing::StartsWith;

/// Null: the slave does not come from a file.
const FileDevice::Source* source_of(const SlaveConfig& slave) {
  const auto* device = dynamic_cast<const FileDevice*>(slave.device.get());
  return device == nullptr ? nullptr : &device->source();
}

class GenericFamilyTest : public test::TemporaryDirectory {
 protected:
  void SetUp() override {
    TemporaryDirectory::SetUp();
    std::filesystem::copy_file(std::filesystem::path(DRIVELINE_EXAMPLES_DIR) / "terminals.xml",
                               directory / "terminals.xml");
  }
  Result<LineConfig> parse(const std::string& text) const { return parse_line_config(text, directory / "line.toml"); }
  /// A line of a single slave with these keys from line 3 on; the error without the folder.
  std::string error(const std::string& keys) const {
    const auto config = parse("[[slave]]\nname = \"x\"\n" + keys);
    if (config) return "no error";
    std::string text = describe(config.error());
    for (auto at = text.find(directory.string()); at != std::string::npos; at = text.find(directory.string())) {
      text.erase(at, directory.string().size() + 1);
    }
    return text;
  }
  void write_image(const std::string& name, const std::vector<std::byte>& image) const {
    std::string bytes;
    for (const auto byte : image) bytes += static_cast<char>(byte);
    write(directory / name, bytes);
  }
  std::vector<std::byte> image_of(const char* device) const {
    const auto file = esi::read_esi(read(directory / "terminals.xml"), "terminals.xml");
    return esi::encode_sii(esi::make_sii(**file->choose({device, {}, {}})));
  }
};

constexpr auto kAi2 = "esi = \"terminals.xml\"\ndevice = \"AI2\"\n";

TEST_F(GenericFamilyTest, ADeviceOfAnEsiFile) {
  const auto config = must(
      parse("[[slave]]\nname = \"bk\"\nesi = \"terminals.xml\"\ndevice = \"bc100\"\nrevision = 0x10000\n"
            "[[slave]]\nname = \"ai\"\nesi = \"terminals.xml\"\nproduct_code = 0x302\nloop_back = false\n"
            "distributed_clock = false\n"
            "[[slave.input]]\nentry = \"Channel 1/Value\"\nshape = \"sine\"\nlow = -100\nhigh = 100\nperiod_s = 0.5\n"
            "[[slave.input]]\nentry = \"6010:11\"\nvalue = 7\n"
            "[[slave]]\nname = \"drive\"\n"));
  ASSERT_EQ(config->slaves.size(), 3U);
  EXPECT_EQ(source_of(config->slaves[0])->model->description().revision, 0x10000U);
  const auto& source = *source_of(config->slaves[1]);
  EXPECT_EQ(source.model->description().type, "AI2");
  EXPECT_FALSE(source.options.loop_back);
  EXPECT_FALSE(source.options.distributed_clock);
  EXPECT_TRUE(source_of(config->slaves[0])->options.distributed_clock);
  ASSERT_EQ(source.options.inputs.size(), 2U);
  EXPECT_EQ(source.options.inputs[0].signal.shape, Signal::Shape::kSine);
  EXPECT_EQ(source.options.inputs[0].signal.period, std::chrono::milliseconds{500});
  EXPECT_DOUBLE_EQ(source.options.inputs[0].signal.low, -100.0);
  EXPECT_EQ(source.options.inputs[1].input->index, 0x6010);
  EXPECT_DOUBLE_EQ(source.options.inputs[1].signal.low, 7.0);
  EXPECT_EQ(source_of(config->slaves[2]), nullptr);
}

TEST_F(GenericFamilyTest, AnEepromImage) {
  write_image("mx4.bin", image_of("MX4"));
  const auto config = must(parse("[[slave]]\nname = \"x\"\nsii = \"mx4.bin\"\n"));
  EXPECT_EQ(source_of(config->slaves[0])->model->description().product_code, 0x440U);
  EXPECT_EQ(source_of(config->slaves[0])->options.sii_image.size(), 4096U);
}

TEST_F(GenericFamilyTest, SlavesOfOneDeviceShareItsModel) {
  const auto config = must(parse(std::string("[[slave]]\nname = \"a\"\n") + kAi2 + "[[slave]]\nname = \"b\"\n" + kAi2));
  EXPECT_EQ(source_of(config->slaves[0])->model, source_of(config->slaves[1])->model);
}

TEST_F(GenericFamilyTest, ThePlanExpectsTheIdentityOfTheDevice) {
  const auto config = must(parse(std::string("[[slave]]\nname = \"a\"\n") + kAi2));
  const auto plans = make_slave_plans(*config);
  EXPECT_EQ(plans.at(0).vendor_id, 0xE0000DD1U);
  EXPECT_EQ(plans.at(0).product_code, 0x302U);
}

TEST_F(GenericFamilyTest, TheSameFileTellsTheMasterHowToConfigureIt) {
  const auto config = must(parse(std::string("[[slave]]\nname = \"a\"\n") + kAi2 + "[[slave]]\nname = \"x\"\n"));
  const auto plans = make_slave_plans(*config);
  ASSERT_NE(plans.at(0).esi, nullptr);
  EXPECT_EQ(plans[0].esi->type, "AI2");
  EXPECT_EQ(plans.at(1).esi, nullptr);
}

TEST_F(GenericFamilyTest, AModelBesideTheFileIsWhatIsSimulated) {
  write(directory / "drive.xml", esi::write_esi({slaves::msd::device_description()}));
  write(directory / "p.csv", "time[s],x[rad]\n0,0\n1,1\n");
  const auto config =
      must(parse("[[slave]]\nname = \"x\"\nmodel = \"msd\"\nesi = \"drive.xml\"\nrevision = \">= 1\"\n[[axis]]\nname = "
                 "\"x\"\n[path]\nfile = \"p.csv\"\n"));
  EXPECT_EQ(source_of(config->slaves[0]), nullptr);
  const auto plan = make_slave_plans(*config).at(0);
  ASSERT_NE(plan.esi, nullptr);
  EXPECT_EQ(plan.vendor_id, slaves::msd::kVendorId);
  EXPECT_EQ(plan.pdos.outputs.size(), 3U) << "those of the axis";
}

TEST_F(GenericFamilyTest, PdosThatTheDeviceDoesNotAllowAreRefused) {
  const auto pdos = [&](const std::string& rest) { return error(kAi2 + rest); };
  EXPECT_EQ(pdos("[[slave.pdo]]\nindex = 0x1A00\n[[slave.pdo]]\nindex = 0x1A01\n"),
            "line.toml:5: [slave 1] pdo: PDO 1A00h excludes PDO 1A01h");
  EXPECT_EQ(pdos("[[slave.pdo]]\nindex = 0x1A02\nentries = [\"0x6010:17:16\"]\n"),
            "line.toml:5: [slave 1] pdo: PDO 1A02h is fixed: its entries cannot be changed");
  EXPECT_EQ(pdos("[[slave.pdo]]\nindex = 0x1A07\nentries = [\"0x6010:17:16\"]\n"),
            "line.toml:5: [slave 1] pdo: the device has no PDO 1A07h in this direction");
  const auto config = must(parse("[[slave]]\nname = \"x\"\n" + std::string(kAi2) + "[[slave.pdo]]\nindex = 0x1A01\n"));
  EXPECT_EQ(config->slaves[0].plan.pdos->inputs.at(0).objects.size(), 1U) << "entries out of the file";
}

TEST_F(GenericFamilyTest, FilesForAllSlavesOfTheBus) {
  const auto one = "[[slave]]\nname = \"x\"\n";
  auto config = must(parse(std::string(one) + "[bus]\nesi = [\"terminals.xml\"]\n"));
  ASSERT_NE(config->esi_library, nullptr);
  EXPECT_NE(config->esi_library->find(0xE0000DD1, 0x302, 0x10000), nullptr);
  const auto settings = master_settings(*config);
  ecat_master::SlaveInfo found;
  found.description.vendor_id = 0xE0000DD1;
  found.description.product_code = 0x302;
  found.description.revision = 0x10001;
  ASSERT_TRUE(settings.describe);
  EXPECT_EQ(settings.describe(found)->type, "AI2");
  std::filesystem::create_directory(directory / "esi");
  EXPECT_THAT(failure_text(parse(std::string(one) + "[bus]\n\nesi = [\"esi\"]\n")),
              HasSubstr("line.toml:5: [bus] esi: there is no .xml file in "));
  std::filesystem::copy_file(directory / "terminals.xml", directory / "esi" / "t.xml");
  config = parse(std::string(one) + "[bus]\nesi = [\"esi\"]\n");
  ASSERT_TRUE(config) << describe(config.error());
  EXPECT_EQ(config->esi_library->size(), 7U);
  EXPECT_THAT(describe(parse(std::string(one) + "[bus]\nesi = [\"no.xml\"]\n").error()),
              HasSubstr("line.toml:4: [bus] esi: "));
}

TEST_F(GenericFamilyTest, AnInputOfNoBitsIsRefused) {
  auto text = read(directory / "terminals.xml");
  for (auto at = text.find("<BitLen>1<"); at != std::string::npos; at = text.find("<BitLen>1<")) text[at + 8] = '0';
  write(directory / "terminals.xml", text);
  EXPECT_EQ(
      error("esi = \"terminals.xml\"\ndevice = \"DI8\"\n[[slave.input]]\nentry = \"Channel 1/Input\"\nvalue = 1\n"),
      "line.toml:6: [slave 1.input 1] entry: \"Channel 1/Input\" is no input of the device; the device has no inputs");
}

TEST_F(GenericFamilyTest, FilesThatNeverEndAreRefused) {
  EXPECT_EQ(error("esi = \"/dev/zero\"\n"), "line.toml:3: [slave 1] esi: /dev/zero: is larger than 128 MiB");
  EXPECT_EQ(error("sii = \"/dev/zero\"\n"), "line.toml:3: [slave 1] sii: /dev/zero: is larger than 128 MiB");
}

TEST_F(GenericFamilyTest, WrongFiles) {
  EXPECT_EQ(error("esi = \"no.xml\"\n"),
            "line.toml:3: [slave 1] esi: no.xml: cannot be read: No such file or directory");
  EXPECT_EQ(error("sii = \".\"\n"), "line.toml:3: [slave 1] sii: .: cannot be read: Is a directory");
  write(directory / "bad.xml", "<EtherCATInfo>\n<Vendor><Id>x</Id></Vendor></EtherCATInfo>");
  EXPECT_EQ(error("esi = \"bad.xml\"\n"),
            "line.toml:3: [slave 1] esi: bad.xml:2: EtherCATInfo/Vendor/Id: 'x', expected a number from 0 to "
            "4294967295 as 16, #x10 or 0x10");
  write(directory / "short.bin", "ab");
  EXPECT_THAT(error("sii = \"short.bin\"\n"), StartsWith("line.toml:3: [slave 1] sii: short.bin: "));
  auto image = image_of("DI8");
  image[14] ^= std::byte{1};
  write_image("wrong.bin", image);
  EXPECT_THAT(error("sii = \"wrong.bin\"\n"),
              HasSubstr("wrong.bin: the checksum of the configuration area is wrong, 0x"));
}

TEST_F(GenericFamilyTest, WrongChoices) {
  EXPECT_THAT(error("esi = \"terminals.xml\"\ndevice = \"EL9999\"\n"),
              StartsWith("line.toml:4: [slave 1] device: terminals.xml: there is no device \"EL9999\", but \"AI2\" "
                         "(0x00000302, revision 0x00010000), \"BC100\" (0x00000100, revision 0x00010000, 0x00020000)"));
  EXPECT_THAT(error("esi = \"terminals.xml\"\n"),
              StartsWith("line.toml:3: [slave 1] esi: terminals.xml: the file has several devices; choose one"));
  EXPECT_EQ(error("esi = \"terminals.xml\"\nsii = \"x.bin\"\n"),
            "line.toml:4: [slave 1] sii: is set together with esi: a device has one source");
  EXPECT_EQ(error(std::string(kAi2) + "model = \"msd\"\n"), "no error") << "the file is for the master alone then";
  EXPECT_EQ(error(std::string(kAi2) + "firmware = \"4.15-02\"\n"),
            "line.toml:5: [slave 1] firmware: belongs to the simulated drive and cannot be used with esi");
  EXPECT_EQ(error(std::string(kAi2) + "[slave.plant]\ninertia_kg_m2 = 1.0\n"),
            "line.toml:5: [slave 1] plant: belongs to the simulated drive and cannot be used with esi");
  EXPECT_THAT(error(std::string(kAi2) + "colour = 1\n"), HasSubstr("colour: unknown key, expected one of: "));
  EXPECT_THAT(error("device = \"AI2\"\n"), HasSubstr("device: unknown key"));
}

TEST_F(GenericFamilyTest, WrongInputs) {
  const auto input = [this](const std::string& keys) { return error(std::string(kAi2) + "[[slave.input]]\n" + keys); };
  EXPECT_THAT(input("entry = \"Vlaue\"\nvalue = 1\n"),
              StartsWith("line.toml:6: [slave 1.input 1] entry: \"Vlaue\" is no input of the device; there are "
                         "\"Channel 1/Underrange\" (6000:01)"));
  EXPECT_EQ(input("entry = \"Channel 1/Limit\"\nvalue = 4\n"),
            "line.toml:6: [slave 1.input 1] entry: 4 does not fit the 2 bits of the entry, 0 to 3 do");
  EXPECT_THAT(input("value = 4\n"), HasSubstr("entry: is missing"));
  EXPECT_THAT(input("entry = \"Toggle\"\n"), HasSubstr("value: is missing"));
  EXPECT_THAT(input("entry = \"Toggle\"\nshape = \"square\"\n"), HasSubstr("shape: is \"square\""));
  EXPECT_THAT(input("entry = \"Toggle\"\nshape = \"toggle\"\n"), HasSubstr("period_s: is missing"));
  EXPECT_THAT(input("entry = \"Toggle\"\nvalue = 1\nlow = 0\n"), HasSubstr("low: unknown key"));
}

TEST_F(GenericFamilyTest, AnAxisNeedsADrive) {
  const auto config = parse(std::string("[[slave]]\nname = \"ai\"\n") + kAi2 + "[[axis]]\nname = \"ai\"\n");
  ASSERT_FALSE(config);
  EXPECT_THAT(describe(config.error()), HasSubstr("\"ai\" is a device of terminals.xml, an axis needs a drive"));
}

TEST(MixedExample, IsALineOfDevicesAndDrives) {
  const auto config = must(load_line_config(std::filesystem::path(DRIVELINE_EXAMPLES_DIR) / "mixed.toml"));
  ASSERT_EQ(config->slaves.size(), 7U);
  EXPECT_EQ(std::count_if(config->slaves.begin(), config->slaves.end(),
                          [](const auto& s) { return source_of(s) != nullptr; }),
            5);
  rt::VirtualClock clock;
  const auto line = make_simulated_line(*config, clock);
  ASSERT_EQ(line->size(), 7U);
  EXPECT_TRUE(line->slave(2).esc().device_emulation());
  EXPECT_FALSE(line->slave(5).esc().device_emulation());
  // KickCAT sets up one sync manager per direction; a device with more of them refuses SAFEOP with 0x001D.
  for (std::size_t i = 0; i < line->size(); ++i) {
    const auto& managers = line->slave(i).device().profile().sync_managers;
    for (const auto use : {slaves::SyncManagerLayout::Use::kOutputs, slaves::SyncManagerLayout::Use::kInputs}) {
      EXPECT_LE(std::count_if(managers.begin(), managers.end(), [use](const auto& one) { return one.use == use; }), 1)
          << "slave " << i;
    }
  }
}

}  // namespace
}  // namespace driveline::runtime

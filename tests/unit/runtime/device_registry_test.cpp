// The families that a line description can name, and the handling of unknown keys.
#include "driveline/runtime/devices/device_registry.hpp"

#include <gmock/gmock.h>

#include "acme/acme_family.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/line.hpp"
#include "driveline/slaves/msd/core/variant.hpp"
#include "support/must.hpp"

namespace driveline::runtime {
namespace {

/// A family whose device cannot be created.
class BrokenFamily final : public DeviceFamily {
 public:
  explicit BrokenFamily(std::string_view key) : key_(key) {}
  [[nodiscard]] std::string_view key() const noexcept override { return key_; }
  [[nodiscard]] std::vector<std::string_view> own_keys() const override { return {}; }
  [[nodiscard]] std::shared_ptr<const SlaveDevice> read(const DeviceTable& /*table*/) const override { return nullptr; }

 private:
  std::string_view key_;
};

DeviceRegistry with_acme() {
  DeviceRegistry devices;
  if (!devices.add(std::make_shared<acme::AcmeFamily>())) throw std::logic_error("acme is refused");
  return devices;
}

TEST(DeviceRegistry, BeginsWithTheFamiliesOfTheLibrary) {
  const DeviceRegistry devices;
  EXPECT_EQ(devices.known_keys(), "\"msd\", \"servoone\", \"servoone_junior\", \"generic\", \"eds\"");
  ASSERT_NE(devices.find("servoone"), nullptr);
  EXPECT_EQ(devices.find("servoone")->key(), "servoone");
  EXPECT_EQ(devices.find("acme"), nullptr);
  EXPECT_EQ(standard_device()->identity().product_code, slaves::msd::kProductCode);
}

TEST(DeviceRegistry, AKeyIsRegisteredOnce) {
  auto devices = with_acme();
  const auto twice = devices.add(std::make_shared<acme::AcmeFamily>());
  ASSERT_FALSE(twice);
  EXPECT_EQ(twice.error().kind, ErrorKind::kCall);
  EXPECT_EQ(describe(twice.error()),
            "the family of devices \"acme\" already exists, known are \"msd\", \"servoone\", \"servoone_junior\", "
            "\"generic\", \"eds\", \"acme\"");
  EXPECT_EQ(devices.add(std::make_shared<BrokenFamily>("msd")).error().kind, ErrorKind::kCall) << "nor a built-in one";
  EXPECT_EQ(devices.add(std::make_shared<BrokenFamily>("")).error().kind, ErrorKind::kCall);
  EXPECT_EQ(devices.add(nullptr).error().kind, ErrorKind::kCall);
  EXPECT_EQ(devices.families().size(), 6U) << "as it was";
  EXPECT_EQ(DeviceRegistry().find("acme"), nullptr) << "nor do others know it";
}

TEST(DeviceRegistry, KnowsWhatIsSimulatedByTheKeyAlone) {
  const auto devices = with_acme();
  for (const auto& variant : slaves::msd::kVariants) {
    const DeviceIdentity identity{slaves::msd::kVendorId, variant.product_code};
    const auto* family = devices.find_simulated(identity, variant.revision);
    ASSERT_NE(family, nullptr) << variant.key;
    EXPECT_EQ(family->key(), variant.key);
    EXPECT_EQ(devices.find_simulated(identity, variant.revision + 1), nullptr) << "in another revision";
    EXPECT_EQ(devices.find_simulated({2, variant.product_code}, variant.revision), nullptr) << "of another vendor";
  }
  EXPECT_TRUE(devices.has_rules_for({acme::kVendorId, 0x1234}));
  EXPECT_FALSE(DeviceRegistry().has_rules_for({acme::kVendorId, 0x1234}));
}

TEST(DeviceRegistry, UnknownModelIsAnErrorWithPlaceAndKnownKeys) {
  const auto unknown = parse_line_config("[[slave]]\nname = \"x\"\nmodel = \"acne\"\n", "cell.toml", with_acme());
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().kind, ErrorKind::kFile);
  EXPECT_EQ(unknown.error().file, "cell.toml");
  EXPECT_EQ(unknown.error().line, 3U);
  EXPECT_EQ(describe(unknown.error()),
            "cell.toml:3: [slave 1] model: is \"acne\", known are \"msd\", \"servoone\", \"servoone_junior\", "
            "\"generic\", \"eds\", \"acme\"");
  EXPECT_FALSE(parse_line_config("[[slave]]\nname = \"x\"\nmodel = \"acme\"\n", "cell.toml")) << "nobody added it";
}

TEST(DeviceRegistry, KeysOfAFamilyAreReadAndCheckedLikeOthers) {
  const auto error = [](const std::string& keys) {
    const auto config = parse_line_config("[[slave]]\nname = \"x\"\n" + keys, "cell.toml", with_acme());
    return config ? std::string("no error") : describe(config.error());
  };
  EXPECT_EQ(error("model = \"acme\"\nstart_increments = 7\n"), "no error");
  EXPECT_EQ(error("model = \"acme\"\nstart_increments = 2000000\n"),
            "cell.toml:4: [slave 1] start_increments: is 2000000, -1000000 to 1000000 is expected");
  EXPECT_EQ(error("model = \"acme\"\nstart_increments = \"7\"\n"),
            "cell.toml:4: [slave 1] start_increments: is a string, an integer is expected");
  EXPECT_THAT(error("model = \"acme\"\nplant = { inertia_kg_m2 = 1 }\n"),
              testing::StartsWith("cell.toml:4: [slave 1] plant: unknown key, expected one of: alias, "));
  EXPECT_THAT(error("start_increments = 7\n"),
              testing::StartsWith("cell.toml:3: [slave 1] start_increments: unknown key"))
      << "of a drive that has none";
  EXPECT_EQ(error("model = \"acme\"\nsii = \"x.bin\"\n"),
            "cell.toml:3: [slave 1] model: belongs to the simulated drive and cannot be used with sii");
}

TEST(DeviceRegistry, AGenericDeviceNeedsItsFile) {
  const auto config = parse_line_config("[[slave]]\nname = \"x\"\nmodel = \"generic\"\n", "cell.toml");
  ASSERT_FALSE(config);
  EXPECT_EQ(describe(config.error()),
            "cell.toml:3: [slave 1] model: is \"generic\": esi or sii, the file of the device, is expected as well");
}

TEST(DeviceRegistry, AFamilyThatMakesNothingIsAnErrorOfTheFile) {
  DeviceRegistry devices;
  ASSERT_TRUE(devices.add(std::make_shared<BrokenFamily>("broken")));
  EXPECT_EQ(failure_text(parse_line_config("[[slave]]\nname = \"x\"\nmodel = \"broken\"\n", "cell.toml", devices)),
            "cell.toml:3: [slave 1] model: the family \"broken\" created no device from it");
}

}  // namespace
}  // namespace driveline::runtime

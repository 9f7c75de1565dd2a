// A line configured as by an ESI-based master: from the ESI file alone.
#include <gtest/gtest.h>

#include "drive_line.hpp"
#include "driveline/esi/esi_file.hpp"
#include "started_line.hpp"

namespace driveline::bus_test {
namespace {

using slaves::msd::Variant;
using wire::AlState;

/// PDOs of the sync manager's direction that the mode assigns, with their contents in the file.
std::vector<motion::PdoMapping> mappings(const std::vector<esi::Pdo>& pdos, const esi::DcOpMode& mode) {
  std::vector<motion::PdoMapping> result;
  for (const auto& assignment : mode.assignments) {
    for (const auto index : assignment.pdos) {
      for (const auto& pdo : pdos) {
        if (pdo.index != index) continue;
        motion::PdoMapping& mapping = result.emplace_back();
        mapping.index = index;
        for (const auto& entry : pdo.entries) {
          mapping.objects.push_back({entry.index, entry.subindex, entry.bit_length});
        }
      }
    }
  }
  return result;
}

struct Tool {
  Variant variant;
  const char* op_mode;
  motion::cia402::Mode mode;
};

class EsiConfiguration : public testing::TestWithParam<Tool> {
 protected:
  void SetUp() override {
    const std::string text = esi::write_esi({slaves::msd::esi_description(GetParam().variant)});
    auto file = esi::read_esi(text, "drive.xml");
    ASSERT_TRUE(file) << esi::to_text(file.error());
    file_ = std::move(*file);
    for (const auto& mode : file_.devices.front().dc_modes) {
      if (mode.name == GetParam().op_mode) op_mode_ = &mode;
    }
    ASSERT_NE(op_mode_, nullptr);
  }

  esi::EsiFile file_;
  const esi::DcOpMode* op_mode_ = nullptr;
};

TEST_P(EsiConfiguration, TakesTheDrivesToOpAndLetsThemFollowAPath) {
  const auto& device = file_.devices.front();
  DriveLine drives(2, {}, {}, std::nullopt, GetParam().variant);
  RunOptions options;
  options.variant = GetParam().variant;
  options.mode = GetParam().mode;
  ScannedOperation operation(drives, options);
  auto plans = operation.plans();
  for (auto& plan : plans) {
    plan.vendor_id = device.vendor_id;
    plan.product_code = device.product_code;
    plan.pdos.outputs = mappings(device.rx_pdos, *op_mode_);
    plan.pdos.inputs = mappings(device.tx_pdos, *op_mode_);
  }
  ASSERT_EQ(sentence(operation.master().configure(plans)), "");
  ASSERT_TRUE(drives.all_in(AlState::kSafeOp));
  operation.start_cycle();
  ASSERT_EQ(sentence(operation.master().go_operational()), "");
  operation.motion().request_start();
  ASSERT_TRUE(operation.run_until(motion::MotionPhase::kFollowing, std::chrono::seconds{2}));
  ASSERT_TRUE(operation.run_until(motion::MotionPhase::kHolding, std::chrono::seconds{2}));
  for (std::size_t i = 0; i < drives.size(); ++i) {
    EXPECT_EQ(drives.drive(i).fault(), std::nullopt);
    EXPECT_EQ(drives.slave(i).device().process_data_size(2) % 2, 0U) << "every firmware takes it";
  }
  double travelled = 0.0;
  double error = 0.0;
  for (const auto& sample : operation.axis_samples) {
    if (sample.axis != 0) continue;
    travelled = std::max(travelled, sample.actual_position);
    error = std::max(error, std::abs(sample.following_error));
  }
  EXPECT_NEAR(travelled, 1.1, 0.1) << "the peak of the path";
  EXPECT_LT(error, 0.6);
}

INSTANTIATE_TEST_SUITE_P(Modes, EsiConfiguration,
                         testing::Values(Tool{Variant::kMsd, "DC CSP", motion::cia402::Mode::kCyclicPosition},
                                         Tool{Variant::kMsd, "DC CSP offsets", motion::cia402::Mode::kCyclicPosition},
                                         Tool{Variant::kMsd, "Free-Run CSP", motion::cia402::Mode::kCyclicPosition},
                                         Tool{Variant::kMsd, "DC CSV", motion::cia402::Mode::kCyclicVelocity},
                                         Tool{Variant::kMsd, "DC CST", motion::cia402::Mode::kCyclicTorque},
                                         Tool{Variant::kServoOne, "DC CSP", motion::cia402::Mode::kCyclicPosition},
                                         Tool{Variant::kServoOneJunior, "DC CSP",
                                              motion::cia402::Mode::kCyclicPosition}),
                         [](const auto& tested) {
                           std::string name =
                               std::string(slaves::msd::facts(tested.param.variant).key) + "_" + tested.param.op_mode;
                           for (char& c : name) c = c == ' ' || c == '-' ? '_' : c;
                           return name;
                         });

}  // namespace
}  // namespace driveline::bus_test

// A second make of drives: a folder (acme/) and one registration. Tested from outside, in the drive and over the bus.
#include <gmock/gmock.h>

#include <numbers>

#include "acme/acme_family.hpp"
#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/line.hpp"
#include "failure_of.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::runtime {
namespace {

class SecondFamily : public test::TemporaryDirectory {
 protected:
  [[nodiscard]] Result<std::unique_ptr<Line>> open(const std::string& text) {
    write(directory / "line.toml", text);
    write(directory / "path.csv", "time[s],x[rev]\n0,0\n0.3,2\n0.4,2\n");
    Line::Options options;
    options.virtual_time = true;
    options.adjust = [this](LineConfig& read) -> Result<void> {
      read.output.directory = directory / "out";
      return {};
    };
    const auto added = options.devices.add(
        std::make_shared<acme::AcmeFamily>([this](acme::AcmeDrive& drive) { drives.push_back(&drive); }));
    if (!added) return tl::unexpected(added.error());
    return Line::from_file(directory / "line.toml", options);
  }

  std::vector<acme::AcmeDrive*> drives;  ///< in the order of creation; they live as long as the line
};

constexpr auto kAxes =
    "[line]\ncycle_us = 1000\n[[axis]]\nname = \"x\"\n[path]\nfile = \"path.csv\"\nrelative = true\n";

TEST_F(SecondFamily, RunsBesideTheFirstAndIsToldWhatItsMakeWants) {
  const auto line =
      must(open(std::string(kAxes) + "[[slave]]\nname = \"other\"\nmodel = \"msd\"\n"
                                     "[[slave]]\nname = \"x\"\nmodel = \"acme\"\nstart_increments = 1234\n"));
  ASSERT_EQ(drives.size(), 1U);
  EXPECT_EQ(drives[0]->object(acme::kSetpointTime, 0), 0U) << "before anybody has told it";
  const auto report = must((*line)->run());
  EXPECT_EQ(failure_of(*report), "");
  EXPECT_EQ(report->state, "OP");
  EXPECT_EQ(drives[0]->object(acme::kSetpointTime, 0), 1000U) << "us";
  EXPECT_EQ(drives[0]->object(0x60C2, 1), 1U);
  EXPECT_EQ(drives[0]->object(0x6064, 0), 1234U + 2U * 65536U)
      << "two revolutions of its own scale, from its own place";
  ASSERT_EQ(report->axes.size(), 1U);
  EXPECT_LE(report->axes[0].following_error_max, 1.0) << "increments: it is where it is told to be, when it is told";

  // A master without knowledge of the families.
  ecat_master::Master master((*line)->session()->port(), (*line)->clock());
  auto ready = master.scan();
  if (ready) ready = master.enter_pre_op();
  ASSERT_TRUE(ready) << ecat_master::describe(ready.error());
  EXPECT_EQ(master.slaves()[1].info.description.vendor_id, acme::kVendorId);
  ecat_master::CoeClient coe(*master.mailbox(1));
  const auto told = must(coe.upload_as<std::uint32_t>(acme::kSetpointTime, 0));
  EXPECT_EQ(*told, 1000U);
}

TEST_F(SecondFamily, IsTakenForNoOther) {
  const auto line = must(open(std::string(kAxes) + "[[slave]]\nname = \"x\"\nmodel = \"acme\"\nvendor_id = 0x28\n"));
  const auto report = (*line)->run();
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().kind, ErrorKind::kLine);
  EXPECT_THAT(describe(report.error()), testing::HasSubstr("E000ACE0"));
}

}  // namespace
}  // namespace driveline::runtime

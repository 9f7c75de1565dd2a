#pragma once

#include <gmock/gmock.h>

#include <ostream>

#include "drive_line.hpp"

namespace driveline::bus_test {

/// A layout of the process image.
struct LayoutCase {
  const char* name;
  ecat_master::ImageLayout layout;
  std::vector<ecat_master::ExchangeGroupSettings> groups{};
  bool every_third_without_lrw = false;
};

inline void PrintTo(const LayoutCase& layout, std::ostream* out) {
  *out << layout.name;
}

/// All cases of the layout tests.
inline auto all_layouts() {
  using ecat_master::ImageLayout;
  return testing::Values(
      LayoutCase{"overlapped", ImageLayout::kOverlapped}, LayoutCase{"sequential", ImageLayout::kSequential},
      LayoutCase{"separate", ImageLayout::kSeparate}, LayoutCase{"mixed", ImageLayout::kOverlapped, {}, true},
      LayoutCase{"two_groups", ImageLayout::kOverlapped, {{1, 0}, {1, 0}}},
      LayoutCase{"three_groups_separate", ImageLayout::kSeparate, {{1, 0}, {1, 0}, {1, 0}}},
      LayoutCase{"divided_groups", ImageLayout::kOverlapped, {{1, 0}, {2, 0}, {2, 1}}},
      LayoutCase{"all_divided", ImageLayout::kSequential, {{2, 1}, {2, 0}}});
}

/// Six drives with the image of a layout case.
class LayoutTest : public testing::TestWithParam<LayoutCase> {
 protected:
  static constexpr std::size_t kDrives = 6;

  static RunOptions options() {
    RunOptions options;
    options.layout = {GetParam().layout, GetParam().groups};
    options.groups = std::max<std::size_t>(1, GetParam().groups.size());
    options.every_third_without_lrw = GetParam().every_third_without_lrw;
    options.amplitude_rad = 0.2;
    return options;
  }
  static std::uint32_t divider_of(std::size_t slave) {
    const auto& groups = GetParam().groups;
    return groups.empty() ? 1 : groups[slave % groups.size()].divider;
  }
  void start(port::Port& port, const RunOptions& run = options()) {
    operation = std::make_unique<LineOperation>(drives, port, run);
    ASSERT_EQ(sentence(operation->to_motion()), "");
    ASSERT_TRUE(operation->run_until(motion::MotionPhase::kFollowing, std::chrono::seconds{2}));
    operation->run(milliseconds{50});
  }
  ecat_master::CyclicCore& core() { return *operation->master().core(); }

  DriveLine drives{kDrives};
  std::unique_ptr<LineOperation> operation;
};

}  // namespace driveline::bus_test

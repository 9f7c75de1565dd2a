#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "driveline/ecat_master/process_data/process_image.hpp"
#include "driveline/motion/cia301/pdo_entry.hpp"
#include "driveline/motion/cycle/cycle_task.hpp"

namespace driveline::bench {

/// The image of a line of axes with 19 bytes of process data each way.
[[nodiscard]] ecat_master::ProcessImage make_image(std::size_t axes);

/// Reads status word, mode and position of every axis and writes control word and target, like an application with
/// handles.
class Decoder final : public motion::CycleTask {
 public:
  explicit Decoder(const ecat_master::ProcessImage& image) {
    for (const auto& place : image.places()) {
      axes_.push_back({motion::PdoEntry<std::uint16_t>(place.input_offset),
                       motion::PdoEntry<std::int32_t>(place.input_offset + 3),
                       motion::PdoEntry<std::uint16_t>(place.output_offset),
                       motion::PdoEntry<std::int32_t>(place.output_offset + 3)});
    }
  }
  void update(const motion::TaskCycle& now) noexcept override {
    const auto inputs = now.inputs;
    const auto valid = now.valid;
    const auto outputs = now.outputs;
    // Use locals, because a store to a byte may alias any member.
    const std::span<const AxisEntries> axes(axes_);
    std::uint64_t stale = 0;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const auto& axis = axes[i];
      if (!valid[i]) ++stale;
      axis.control_word.set(outputs, axis.status_word.get(inputs));
      axis.target.set(outputs, axis.position.get(inputs) + 1);
    }
    invalid += stale;
  }
  std::uint64_t invalid = 0;

 private:
  struct AxisEntries {
    motion::PdoEntry<std::uint16_t> status_word;
    motion::PdoEntry<std::int32_t> position;
    motion::PdoEntry<std::uint16_t> control_word;
    motion::PdoEntry<std::int32_t> target;
  };
  std::vector<AxisEntries> axes_;
};

}  // namespace driveline::bench

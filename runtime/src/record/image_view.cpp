#include "driveline/runtime/record/image_view.hpp"

namespace driveline::runtime {
namespace {

using ecat_master::ImageLayout;
using ecat_master::Master;
using ecat_master::ProcessDataPlace;

std::string_view layout_name(ImageLayout layout) {
  switch (layout) {
    case ImageLayout::kOverlapped:
      return "overlapped";
    case ImageLayout::kSequential:
      return "sequential";
    case ImageLayout::kSeparate:
      break;
  }
  return "lrd_lwr";
}

}  // namespace

std::string group_name(const LineConfig& config, std::size_t group) {
  const auto& groups = config.process_data.groups;
  return group < groups.size() ? groups[group].name : std::string("line");
}

ImageView view_image(const LineConfig& config, const Master& master,
                     std::span<const ecat_master::ExchangeGroupCounters> counters, const ExchangeGroupWatch* watch) {
  const auto& image = master.image();
  ImageView view;
  view.layout = layout_name(config.process_data.layout);
  view.bytes = image.outputs().size();
  view.datagrams = image.datagrams().size();
  view.frames = image.frame_count();
  view.wire = wire_budget(master, config);
  for (std::size_t i = 0; i < image.groups().size(); ++i) {
    ExchangeGroupView group;
    group.name = group_name(config, i);
    group.settings = image.groups()[i];
    for (const auto& place : image.places()) {
      const bool exchanged =
          place.output_datagram != ProcessDataPlace::kNone || place.input_datagram != ProcessDataPlace::kNone;
      if (place.group == i && exchanged) ++group.slaves;
    }
    for (const auto& datagram : image.datagrams()) {
      if (datagram.group != i) continue;
      ++group.datagrams;
      group.working_counter += datagram.expected_working_counter;
      if (group.frames.empty() || group.frames.back() != datagram.frame) group.frames.push_back(datagram.frame);
    }
    if (i < counters.size()) {
      group.exchanges = counters[i].exchanges.value();
      group.lost_frames = counters[i].lost_frames.value();
      group.wkc_errors = counters[i].wkc_errors.value();
      group.longest_bad = counters[i].longest_bad;
    }
    if (watch != nullptr) group.zeroings = watch->zeroings(i);
    view.groups.push_back(std::move(group));
  }
  return view;
}

}  // namespace driveline::runtime

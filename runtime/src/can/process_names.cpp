#include "can/process_names.hpp"

#include <string>
#include <utility>
#include <vector>

#include "driveline/motion/cia402/object_name.hpp"
#include "driveline/motion/drive/drive_objects.hpp"

namespace driveline::runtime {
namespace {

using ecat_master::ProcessVariable;

void add_variables(const canopen::NodePlan& node, std::size_t number, const canopen::PdoImage& image, bool output,
                   std::vector<ProcessVariable>& variables) {
  const auto& place = image.place(number);
  const auto& pdos = image.configuration(number);
  std::size_t bit = 8 * (output ? place.output_offset : place.input_offset);
  for (const auto& pdo : output ? pdos.outputs : pdos.inputs) {
    for (const auto& object : pdo.objects) {
      if (object.index != 0) {
        const auto first = motion::object_of_first_drive(object.index);
        variables.push_back({node.name,
                             static_cast<std::uint16_t>(number),
                             std::string(motion::cia402::object_name(first, object.subindex)),
                             {},
                             {},
                             object.index,
                             object.subindex,
                             output,
                             bit,
                             object.bits});
      }
      bit += object.bits;
    }
  }
}

}  // namespace

ecat_master::ProcessVariables can_variables(const canopen::MasterPlan& plan, const canopen::PdoImage& image) {
  std::vector<ProcessVariable> variables;
  for (std::size_t i = 0; i < plan.nodes.size(); ++i) {
    for (const bool output : {true, false}) add_variables(plan.nodes[i], i, image, output, variables);
  }
  return ecat_master::ProcessVariables(std::move(variables));
}

}  // namespace driveline::runtime

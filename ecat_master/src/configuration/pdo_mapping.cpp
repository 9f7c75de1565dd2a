#include "driveline/ecat_master/configuration/pdo_mapping.hpp"

namespace driveline::ecat_master {
namespace {

constexpr std::uint16_t kOutputAssignment = 0x1C12;
constexpr std::uint16_t kInputAssignment = 0x1C13;

using Steps = std::vector<SdoScript::Step>;

/// Writes a list object as CANopen requires: count 0, elements, count.
template <typename T, typename Elements, typename Raw>
void append_list(Steps& steps, std::uint16_t index, const Elements& elements, Raw raw) {
  steps.push_back(SdoScript::Step::of<std::uint8_t>(index, 0, 0));
  std::uint8_t subindex = 0;
  for (const auto& element : elements) steps.push_back(SdoScript::Step::of<T>(index, ++subindex, raw(element)));
  steps.push_back(SdoScript::Step::of<std::uint8_t>(index, 0, subindex));
}

AssignmentPlan plan_direction(std::uint16_t assignment, bool outputs, const std::vector<motion::PdoMapping>& pdos) {
  AssignmentPlan plan{static_cast<std::uint8_t>(assignment - kPdoAssignment), outputs, pdos, {}};
  plan.steps.push_back(SdoScript::Step::of<std::uint8_t>(assignment, 0, 0));
  for (const auto& pdo : pdos) {
    if (pdo.own_mapping || pdo.objects.empty()) continue;
    append_list<std::uint32_t>(plan.steps, pdo.index, pdo.objects,
                               [](const motion::MappedObject& o) { return o.raw(); });
  }
  append_list<std::uint16_t>(plan.steps, assignment, pdos, [](const motion::PdoMapping& pdo) { return pdo.index; });
  return plan;
}

}  // namespace

std::vector<AssignmentPlan> plan_assignments(const motion::PdoConfiguration& configuration) {
  return {plan_direction(kOutputAssignment, true, configuration.outputs),
          plan_direction(kInputAssignment, false, configuration.inputs)};
}

std::vector<SdoScript::Step> steps_of(std::span<const AssignmentPlan> plans) {
  Steps steps;
  for (const auto& plan : plans) steps.insert(steps.end(), plan.steps.begin(), plan.steps.end());
  return steps;
}

std::vector<SdoScript::Step> pdo_script(const motion::PdoConfiguration& configuration) {
  return steps_of(plan_assignments(configuration));
}

Result<void> write_pdo_configuration(CoeClient& coe, const motion::PdoConfiguration& configuration) {
  for (const auto& written : pdo_script(configuration)) {
    if (auto done = coe.download(written.at.index, written.at.subindex, written.data); !done) return done;
  }
  return {};
}

Result<std::vector<motion::PdoMapping>> read_assigned_pdos(CoeClient& coe, std::uint16_t assignment) {
  const auto count = coe.upload_as<std::uint8_t>(assignment, 0);
  if (!count) return tl::unexpected(count.error());
  std::vector<motion::PdoMapping> pdos;
  for (unsigned i = 1; i <= *count; ++i) {
    const auto index = coe.upload_as<std::uint16_t>(assignment, static_cast<std::uint8_t>(i));
    // A list may end before the number of its elements, and have unused ones, which are 0.
    if (!index && i > 1 && index.error().is<facts::SdoAbort>()) break;
    if (!index) return tl::unexpected(index.error());
    if (*index == 0) continue;
    const auto objects = coe.upload_as<std::uint8_t>(*index, 0);
    if (!objects) return tl::unexpected(objects.error());
    motion::PdoMapping pdo;
    pdo.index = *index;
    for (unsigned k = 1; k <= *objects; ++k) {
      const auto entry = coe.upload_as<std::uint32_t>(*index, static_cast<std::uint8_t>(k));
      if (!entry) return tl::unexpected(entry.error());
      pdo.objects.push_back(motion::MappedObject::from_raw(*entry));
    }
    pdos.push_back(std::move(pdo));
  }
  return pdos;
}

Result<std::size_t> read_assigned_bytes(CoeClient& coe, std::uint16_t assignment) {
  return read_assigned_pdos(coe, assignment).map([](const auto& pdos) { return motion::bytes_of(pdos); });
}

}  // namespace driveline::ecat_master

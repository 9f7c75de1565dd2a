#include "driveline/motion/drive/drive_objects.hpp"

namespace driveline::motion {
namespace {

void convert(MappedObject& object, unsigned drive) {
  const auto first = object_of_first_drive(object.index);
  if (first < 0x6000 || first >= 0x6800) return;  // no object of a drive
  const bool own = object.index == object_of_drive(first, drive);
  object = own ? MappedObject{first, object.subindex, object.bits} : MappedObject{0, 0, object.bits};
}

}  // namespace

PdoConfiguration pdos_of_drive(PdoConfiguration pdos, unsigned drive) {
  for (auto* direction : {&pdos.outputs, &pdos.inputs}) {
    for (auto& pdo : *direction) {
      for (auto& object : pdo.objects) convert(object, drive);
    }
  }
  return pdos;
}

}  // namespace driveline::motion

#include "driveline/motion/drive/axis_objects.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "driveline/motion/cia402/object_name.hpp"
#include "driveline/motion/drive/drive_objects.hpp"

namespace driveline::motion {
namespace {

using cia402::Mode;

constexpr std::uint16_t kTorqueOffset = 0x60B2;

/// Width with which the object is mapped anywhere; 0: not mapped.
std::uint8_t mapped_bits(const std::vector<PdoMapping>& pdos, std::uint16_t index, std::uint8_t subindex) {
  for (const auto& pdo : pdos) {
    for (const auto& object : pdo.objects) {
      if (object.index == index && object.subindex == subindex) return object.bits;
    }
  }
  return 0;
}

/// Target object of the mode; empty for homing.
constexpr std::optional<MissingObject> target_of(Mode mode) {
  switch (mode) {
    case Mode::kHoming:
      return std::nullopt;
    case Mode::kInterpolatedPosition:
      return MissingObject{0x60C1, 32, true, 0, 1};
    case Mode::kVelocity:
      return MissingObject{0x6042, 16, true};
    case Mode::kProfileVelocity:
    case Mode::kCyclicVelocity:
      return MissingObject{0x60FF, 32, true};
    case Mode::kCyclicTorque:
      return MissingObject{0x6071, 16, true};
    case Mode::kProfilePosition:
    case Mode::kCyclicPosition:
      break;
  }
  return MissingObject{0x607A, 32, true};
}

/// Mapped objects of a direction, such as "6040h, 6060h", in the order of the process data.
std::string mapped_list(const std::vector<PdoMapping>& pdos) {
  std::string text;
  for (const auto& pdo : pdos) {
    for (const auto& object : pdo.objects) {
      // Padding has no index.
      if (object.index != 0) text += fmt::format("{}{:04X}h", text.empty() ? "" : ", ", object.index);
    }
  }
  return text.empty() ? "nothing" : text;
}

}  // namespace

std::optional<std::size_t> object_offset(const std::vector<PdoMapping>& pdos, std::uint16_t index, std::size_t bits,
                                         std::uint8_t subindex) {
  std::size_t at = 0;
  for (const auto& pdo : pdos) {
    for (const auto& object : pdo.objects) {
      if (object.index == index && object.subindex == subindex && object.bits == bits && at % 8 == 0) return at / 8;
      at += object.bits;
    }
  }
  return std::nullopt;
}

std::vector<MissingObject> missing_objects(Mode mode, const PdoConfiguration& pdos, bool torque_offset) {
  std::vector<MissingObject> missing;
  const auto need = [&](MissingObject object) {
    const auto& direction = object.output ? pdos.outputs : pdos.inputs;
    if (object_offset(direction, object.index, object.bits, object.subindex)) return;
    object.mapped_bits = mapped_bits(direction, object.index, object.subindex);
    missing.push_back(object);
  };
  need({0x6040, 16, true});
  if (const auto target = target_of(mode)) need(*target);
  const bool uses_offset = mode == Mode::kCyclicPosition || mode == Mode::kCyclicVelocity;
  if (torque_offset && uses_offset) need({kTorqueOffset, 16, true});
  need({0x6041, 16, false});
  need({0x6064, 32, false});
  if (mode == Mode::kCyclicTorque) need({0x606C, 32, false});
  return missing;
}

std::string describe_missing(Mode mode, const std::vector<MissingObject>& missing, const PdoConfiguration& pdos,
                             unsigned drive) {
  if (missing.empty()) return {};
  const bool offset =
      std::any_of(missing.begin(), missing.end(), [](const auto& m) { return m.index == kTorqueOffset; });
  auto text = fmt::format("{}{} needs ", to_text(mode), offset ? " with a feed-forward of friction or gravity" : "");
  bool outputs = false;
  bool inputs = false;
  for (const auto& object : missing) {
    (object.output ? outputs : inputs) = true;
    const auto sub = object.subindex == 0 ? std::string{} : fmt::format(":{:02d}", object.subindex);
    text += fmt::format("{}{:04X}h{} ({}, {} bits) in {}", &object == &missing.front() ? "" : ", ",
                        object_of_drive(object.index, drive), sub, cia402::object_name(object.index, object.subindex),
                        object.bits, object.output ? "an RxPDO" : "a TxPDO");
    if (object.mapped_bits == object.bits) text += " and at the beginning of a byte";
    if (object.mapped_bits != 0 && object.mapped_bits != object.bits) {
      text += fmt::format(" instead of {} bits", object.mapped_bits);
    }
  }
  if (outputs) text += fmt::format("; the RxPDOs map {}", mapped_list(pdos.outputs));
  if (inputs) text += fmt::format("; the TxPDOs map {}", mapped_list(pdos.inputs));
  return text;
}

}  // namespace driveline::motion

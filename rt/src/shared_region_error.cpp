#include <fcntl.h>

#include <iomanip>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>

#include "driveline/rt/shared_region.hpp"

namespace driveline::rt {

namespace {

std::string hex(std::uint64_t value) {
  std::ostringstream text;
  text << "0x" << std::hex << std::uppercase << value;
  return text.str();
}

std::string seal_names(unsigned seals) {
  struct Name {
    unsigned seal;
    std::string_view text;
  };
  constexpr Name kNames[] = {{F_SEAL_SEAL, "seals"},
                             {F_SEAL_SHRINK, "shrinking"},
                             {F_SEAL_GROW, "growing"},
                             {F_SEAL_FUTURE_WRITE, "writing by others"}};
  std::string text;
  for (const Name& name : kNames) {
    if ((seals & name.seal) != 0) {
      text += (text.empty() ? "" : ", ") + std::string{name.text};
    }
  }
  return text;
}

std::string differs(std::string_view what, const std::string& found, const std::string& expected) {
  return std::string{what} + " " + found + " instead of " + expected;
}

std::string form_name(SharedForm form) {
  switch (form) {
    case SharedForm::kRing:
      return "ring";
    case SharedForm::kBroadcast:
      return "broadcast";
  }
  return hex(static_cast<std::uint32_t>(form));
}

/// The first thing that is not as expected.
std::string first_difference(const SharedLayout& found, const SharedLayout& expected) {
  if (found.form != expected.form) {
    return differs("form", form_name(found.form), form_name(expected.form));
  }
  if (found.content != expected.content) {
    return differs("content", hex(found.content), hex(expected.content));
  }
  if (found.content_version != expected.content_version) {
    return differs("version of the content", std::to_string(found.content_version),
                   std::to_string(expected.content_version));
  }
  if (found.record_bytes != expected.record_bytes) {
    return differs("bytes of a record", std::to_string(found.record_bytes), std::to_string(expected.record_bytes));
  }
  return differs("capacity", std::to_string(found.capacity), std::to_string(expected.capacity));
}

struct Sentence {
  std::string operator()(const SharedCallFailed& error) const {
    return std::string{error.call} + ": " + std::generic_category().message(error.error_number);
  }
  std::string operator()(const SharedNotMemory& /*error*/) const {
    return "the descriptor is not one of shared memory (memfd)";
  }
  std::string operator()(const SharedNotSealed& error) const {
    return "not sealed against further " + seal_names(error.required & ~error.present);
  }
  std::string operator()(const SharedWrongSize& error) const {
    return differs("size of", std::to_string(error.found_bytes), std::to_string(error.expected_bytes)) + " bytes";
  }
  std::string operator()(const SharedWrongMagic& error) const {
    return "begins with " + hex(error.found) + " and not as a region of driveline (" + hex(error.expected) + ")";
  }
  std::string operator()(const SharedWrongVersion& error) const {
    return differs("laid out in version", std::to_string(error.found), std::to_string(error.expected));
  }
  std::string operator()(const SharedOtherContent& error) const {
    return first_difference(error.found, error.expected);
  }
  std::string operator()(const SharedBadCapacity& error) const {
    return "cannot hold " + std::to_string(error.capacity) + " records of " + std::to_string(error.record_bytes) +
           " bytes";
  }
};

}  // namespace

std::string describe(const SharedRegionError& error) {
  return "shared region: " + std::visit(Sentence{}, error);
}

}  // namespace driveline::rt

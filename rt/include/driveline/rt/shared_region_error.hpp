#pragma once

#include <fcntl.h>

#include <cstdint>
#include <iomanip>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <variant>

#include "driveline/rt/shared_layout.hpp"

namespace driveline::rt {

/// A call of the system failed.
struct SharedCallFailed {
  const char* call;  ///< e.g. "mmap"
  int error_number;  ///< errno
};

/// The descriptor belongs to a file without seals: a plain file, a pipe.
struct SharedNotMemory {};

/// The memory can still change its size, or its readers can write to it.
struct SharedNotSealed {
  unsigned required;  ///< F_SEAL_... that the form needs
  unsigned present;   ///< F_SEAL_... that are set
};

/// The memory is smaller than a header, or not of the size that follows from its header.
struct SharedWrongSize {
  std::uint64_t expected_bytes;  ///< what it should have, at least
  std::uint64_t found_bytes;     ///< what it has
};

/// The memory does not begin as a region of driveline.
struct SharedWrongMagic {
  std::uint64_t expected;  ///< kSharedMagic
  std::uint64_t found;     ///< the first eight bytes
};

/// The region was made by another version of this library that lays regions out in another way.
struct SharedWrongVersion {
  std::uint32_t expected;  ///< kSharedLayoutVersion
  std::uint32_t found;     ///< of the region
};

/// The region has another layout or content than expected.
struct SharedOtherContent {
  SharedLayout expected;  ///< what was asked for
  SharedLayout found;     ///< what the header says
};

/// No region can be made with so many records of this size.
struct SharedBadCapacity {
  std::uint64_t capacity;      ///< records, as given
  std::uint32_t record_bytes;  ///< of each, as given
};

/// Why there is no shared region.
using SharedRegionError = std::variant<SharedCallFailed, SharedNotMemory, SharedNotSealed, SharedWrongSize,
                                       SharedWrongMagic, SharedWrongVersion, SharedOtherContent, SharedBadCapacity>;

/// Words of describe().
namespace shared_detail {

inline std::string hex(std::uint64_t value) {
  std::ostringstream text;
  text << "0x" << std::hex << std::uppercase << value;
  return text.str();
}

inline std::string seal_names(unsigned seals) {
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

inline std::string differs(std::string_view what, const std::string& found, const std::string& expected) {
  return std::string{what} + " " + found + " instead of " + expected;
}

inline std::string form_name(SharedForm form) {
  switch (form) {
    case SharedForm::kRing:
      return "ring";
    case SharedForm::kBroadcast:
      return "broadcast";
  }
  return hex(static_cast<std::uint32_t>(form));
}

/// The first thing that is not as expected.
inline std::string first_difference(const SharedLayout& found, const SharedLayout& expected) {
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

struct RegionSentence {
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

}  // namespace shared_detail

/// The error as one sentence with all of its facts.
[[nodiscard]] inline std::string describe(const SharedRegionError& error) {
  return "shared region: " + std::visit(shared_detail::RegionSentence{}, error);
}

}  // namespace driveline::rt

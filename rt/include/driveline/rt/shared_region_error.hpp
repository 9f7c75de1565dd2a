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

/// A system call failed.
struct SharedCallFailed {
  const char* call;  ///< e.g. "mmap"
  int error_number;  ///< errno
};

/// The descriptor belongs to a file without seals, such as a plain file or a pipe.
struct SharedNotMemory {};

/// The memory can still change its size, or its readers can write to it.
struct SharedNotSealed {
  unsigned required;  ///< required F_SEAL_... flags of the form
  unsigned present;   ///< F_SEAL_... flags that are set
};

/// The memory is smaller than a header, or its size does not match its header.
struct SharedWrongSize {
  std::uint64_t expected_bytes;  ///< expected size, at least
  std::uint64_t found_bytes;     ///< actual size
};

/// The memory does not start with the magic number of a driveline region.
struct SharedWrongMagic {
  std::uint64_t expected;  ///< kSharedMagic
  std::uint64_t found;     ///< first eight bytes of the memory
};

/// The region was created by a version of this library with another layout of regions.
struct SharedWrongVersion {
  std::uint32_t expected;  ///< kSharedLayoutVersion
  std::uint32_t found;     ///< version in the region
};

/// The layout or content of the region differs from what is expected.
struct SharedOtherContent {
  SharedLayout expected;  ///< requested layout
  SharedLayout found;     ///< layout in the header
};

/// No region can be created for this number and size of records.
struct SharedBadCapacity {
  std::uint64_t capacity;      ///< requested number of records
  std::uint32_t record_bytes;  ///< requested size of a record in bytes
};

/// Reasons why there is no shared region.
using SharedRegionError = std::variant<SharedCallFailed, SharedNotMemory, SharedNotSealed, SharedWrongSize,
                                       SharedWrongMagic, SharedWrongVersion, SharedOtherContent, SharedBadCapacity>;

/// Parts of the sentences of describe().
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

/// Describes the first field that differs.
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

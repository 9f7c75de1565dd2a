#pragma once

#include <cstddef>
#include <cstdint>

#include "driveline/motion/group/group_request.hpp"
#include "driveline/motion/single_axis/request_table.hpp"

namespace driveline::motion {

/// Three bytes: axis, phase and reason.
template <>
struct ReportCode<GroupRequestReport> {
  static constexpr unsigned kBits = 24;  ///< bits of a report
  /// The report as bits; the number of the axis has one byte. \rtsafe
  [[nodiscard]] static constexpr std::uint64_t encode(const GroupRequestReport& report) noexcept {
    return std::uint64_t{static_cast<std::uint8_t>(report.axis)} << 16U |
           std::uint64_t{static_cast<std::uint8_t>(report.phase)} << 8U | static_cast<std::uint8_t>(report.error);
  }
  /// The report of these bits. \rtsafe
  [[nodiscard]] static constexpr GroupRequestReport decode(std::uint64_t bits) noexcept {
    return {static_cast<RequestPhase>(bits >> 8U & 0xFFU), static_cast<GroupError>(bits & 0xFFU),
            static_cast<std::size_t>(bits >> 16U & 0xFFU)};
  }
};

/// Reports of the requests to groups. Written by the cycle and by planning.
using GroupRequestTable = ReportTable<GroupRequestReport>;

}  // namespace driveline::motion

#pragma once

#include <cmath>

#include "driveline/trajectory/group_vector.hpp"

// Arithmetic of group vectors. Functions process all axes, used or not: eight fit into a few registers.

namespace driveline::trajectory {

inline GroupVector sum(const GroupVector& a, const GroupVector& b, double factor = 1.0) noexcept {
  GroupVector result{};
  for (std::size_t i = 0; i < kMaxGroupAxes; ++i) result[i] = a[i] + factor * b[i];
  return result;
}

inline GroupVector difference(const GroupVector& a, const GroupVector& b) noexcept {
  return sum(a, b, -1.0);
}

inline GroupVector times(const GroupVector& a, double factor) noexcept {
  GroupVector result{};
  for (std::size_t i = 0; i < kMaxGroupAxes; ++i) result[i] = a[i] * factor;
  return result;
}

inline double dot(const GroupVector& a, const GroupVector& b) noexcept {
  double total = 0.0;
  for (std::size_t i = 0; i < kMaxGroupAxes; ++i) total += a[i] * b[i];
  return total;
}

inline double norm(const GroupVector& a) noexcept {
  return std::sqrt(dot(a, a));
}

}  // namespace driveline::trajectory

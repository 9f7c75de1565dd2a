#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "driveline/trajectory/path.hpp"

namespace driveline::trajectory::segment_detail {

/// A vector with one value per axis.
using AxisColumn = Eigen::VectorXd;

inline Eigen::Index to_index(std::size_t value) {
  return static_cast<Eigen::Index>(value);
}

inline Eigen::Map<const AxisColumn> column(std::span<const double> values) {
  return {values.data(), to_index(values.size())};
}

inline double step_s(const Path& path, std::size_t segment) {
  return path.times_s()[segment + 1] - path.times_s()[segment];
}

inline AxisColumn slope(const Path& path, std::size_t segment) {
  return (column(path.positions(segment + 1)) - column(path.positions(segment))) / step_s(path, segment);
}

}  // namespace driveline::trajectory::segment_detail

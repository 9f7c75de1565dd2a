#pragma once

#include <cstddef>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/trajectory/contour_settings.hpp"
#include "driveline/trajectory/path_move.hpp"
#include "driveline/trajectory/position_unit.hpp"

namespace driveline::cli {

/// An axis of a file of moves.
struct MoveAxis {
  std::string name;
  const trajectory::PositionUnit* unit;
};

/// A move, and where it stands.
struct FileMove {
  trajectory::PathMove move;
  std::size_t line;
};

/// A file of moves: JSON lines, the first of which describes the axes (docs/motion.md). All values in SI.
struct MoveFile {
  std::vector<MoveAxis> axes;
  trajectory::ContourSettings settings;
  trajectory::GroupVector start{};
  std::vector<FileMove> moves;
};

/// Reads such a text. The error is a sentence with `name` of the file and the line.
[[nodiscard]] tl::expected<MoveFile, std::string> parse_moves(const std::string& text, const std::string& name);

}  // namespace driveline::cli

#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/trajectory/contour_settings.hpp"
#include "driveline/trajectory/kinematics.hpp"
#include "driveline/trajectory/path_move.hpp"
#include "driveline/trajectory/position_unit.hpp"

namespace driveline::cli {

/// An axis of a file of moves, or a coordinate of them.
struct MoveAxis {
  std::string name;
  const trajectory::PositionUnit* unit;
};

/// A move, and where it stands.
struct FileMove {
  trajectory::PathMove move;
  std::size_t line;
  std::size_t point = 0;  ///< of a polyline, 1 is the first; 0: the line is a move of its own
};

/// A file of moves: JSON lines, the first of which describes the axes (docs/motion.md). All values in SI.
struct MoveFile {
  std::vector<MoveAxis> axes;
  std::vector<MoveAxis> coordinates;                   ///< of the moves: with kinematics those of the tool
  std::unique_ptr<trajectory::Kinematics> kinematics;  ///< null: coordinates are axes
  std::vector<std::string> outputs;                    ///< names; a move knows their numbers
  trajectory::ContourSettings settings;
  trajectory::GroupVector start{};
  std::vector<FileMove> moves;
};

/// Reads such a text, and the files of points that it names, which stand beside it. The error is a sentence with `name`
/// of the file and the line.
[[nodiscard]] tl::expected<MoveFile, std::string> parse_moves(const std::string& text, const std::string& name);

/// What is wrong with the path as a whole before anything moves: corners, arcs, places that axes or machine cannot
/// have. A sentence with file and line; empty: nothing.
[[nodiscard]] std::string refusal_of(const MoveFile& file, const std::string& name);

}  // namespace driveline::cli

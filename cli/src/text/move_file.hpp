#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/trajectory/contour_settings.hpp"
#include "driveline/trajectory/machine.hpp"
#include "driveline/trajectory/path_move.hpp"

namespace driveline::cli {

/// A move, and where it stands.
struct FileMove {
  trajectory::PathMove move;
  std::size_t line;
  std::size_t point = 0;  ///< of a polyline, 1 is the first; 0: the line is a move of its own
};

/// A file of moves: JSON lines, the first of which describes the axes (docs/motion.md). All values in SI.
struct MoveFile {
  std::vector<trajectory::NamedAxis> axes;
  std::vector<trajectory::NamedAxis> coordinates;  ///< of the moves: with a machine those of the tool
  std::optional<trajectory::Machine> machine;      ///< none: coordinates are axes
  std::vector<std::string> outputs;                ///< names; a move knows their numbers
  trajectory::ContourSettings settings;
  trajectory::GroupVector start{};
  std::vector<FileMove> moves;
};

/// What holds where a file says nothing.
struct MoveDefaults {
  std::optional<trajectory::GroupVector> start{};  ///< where something stands, rad or m; none: zeros, which are checked
  double tolerance = 0.0;                          ///< at corners, until a move says another one, rad or m
};

/// Reads such a text, and the files of points that it names, which stand beside it. The error is a sentence with `name`
/// of the file and the line.
[[nodiscard]] tl::expected<MoveFile, std::string> parse_moves(const std::string& text, const std::string& name,
                                                              const MoveDefaults& defaults = {});

/// What is wrong with the path as a whole before anything moves: corners, arcs, places that axes or machine cannot
/// have. A sentence with file and line; empty: nothing.
[[nodiscard]] std::string refusal_of(const MoveFile& file, const std::string& name);

}  // namespace driveline::cli

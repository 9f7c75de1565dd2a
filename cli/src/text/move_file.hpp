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

/// A move, and its position in the file.
struct FileMove {
  trajectory::PathMove move;
  std::size_t line;
  std::size_t point = 0;  ///< number of the point of a polyline, from 1; 0: the line is a single move
};

/// The content of a file of moves: JSON lines, the first of which describes the axes (docs/motion.md). All values in SI
/// units.
struct MoveFile {
  std::vector<trajectory::NamedAxis> axes;
  std::vector<trajectory::NamedAxis> coordinates;  ///< names of move coordinates: axes, or those of the tool
  std::optional<trajectory::Machine> machine;      ///< none: coordinates are axes
  std::vector<std::string> outputs;                ///< names; moves contain their indices
  trajectory::ContourSettings settings;
  trajectory::GroupVector start{};
  std::vector<FileMove> moves;
};

/// Defaults for values that a file leaves out.
struct MoveDefaults {
  std::optional<trajectory::GroupVector> start{};  ///< present position, rad or m; none: zeros, which are checked
  double tolerance = 0.0;                          ///< at corners, until a move sets another one, rad or m
};

/// Parses the text of a file, and the files of points that it names, which are beside it. The error is a sentence with
/// `name` of the file and the line.
[[nodiscard]] tl::expected<MoveFile, std::string> parse_moves(const std::string& text, const std::string& name,
                                                              const MoveDefaults& defaults = {});

/// Why the path as a whole is invalid: corners, arcs, positions that axes or machine cannot reach. A sentence with file
/// and line; empty: it is valid.
[[nodiscard]] std::string refusal_of(const MoveFile& file, const std::string& name);

}  // namespace driveline::cli

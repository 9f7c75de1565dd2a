#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "can/node_facts.hpp"
#include "text/line_description.hpp"

namespace driveline::cli {

/// A node to be described.
struct FoundCanNode {
  NodeFacts facts;
  std::optional<FoundDrive> drive;  ///< none: no drive of CiA 402
  std::string eds;                  ///< its data sheet, relative to the description; empty: not known
};

/// The input of a description of a CAN line.
struct FoundCanLine {
  std::vector<FoundCanNode> nodes;
  std::optional<std::string> interface;  ///< interface of the bus; none: simulated in this process
  std::uint32_t bit_rate = 1'000'000;    ///< bit/s
  std::string path_file;                 ///< file of a path beside the description; empty: no motion
};

/// Asks a drive for what its axis needs; none: the node is no drive of CiA 402.
[[nodiscard]] std::optional<FoundDrive> read_can_drive(canopen::SdoClient& client, const NodeFacts& facts);

/// Data sheets that the user has.
class DataSheets {
 public:
  /// Reads one file, or all files of a folder with the ending .eds or .dcf. Failure: the path cannot be read, or a
  /// single file is no data sheet; files of a folder that are none are passed over.
  [[nodiscard]] static Outcome<DataSheets> read(const std::filesystem::path& path);
  /// The data sheet of a node by vendor and product: one with bit rates, as those of a device on another bus have none,
  /// and that of its revision, before the others; null: there is none.
  [[nodiscard]] const std::filesystem::path* find(const NodeFacts& facts) const;

 private:
  struct Sheet {
    std::filesystem::path file;
    std::uint32_t vendor_id = 0;
    std::uint32_t product_code = 0;
    std::uint32_t revision = 0;
    bool has_bit_rates = false;
  };
  std::vector<Sheet> sheets_;
};

/// Whether a description of this node needs its data sheet: the program has no model of the device.
[[nodiscard]] bool needs_sheet(const NodeFacts& facts);

/// Names of the axes that the description has.
[[nodiscard]] std::vector<std::string> axes_of(const FoundCanLine& line);

/// Whether all axes of the description can follow a path: there is none whose drive plans its motions itself.
[[nodiscard]] bool can_follow_path(const FoundCanLine& line);

/// Creates a line description (TOML) of nodes that have been found, which `run` can use unchanged: each is expected by
/// vendor, product, revision and serial number, as far as it tells them. Drives of CiA 402 with interpolated position
/// get an [[axis]] with the scaling that they report, others are a comment with the reason. The period of SYNC is the
/// shortest one from 2 ms on in which the PDOs of all axes fit.
[[nodiscard]] std::string describe_can_line(const FoundCanLine& line);

}  // namespace driveline::cli

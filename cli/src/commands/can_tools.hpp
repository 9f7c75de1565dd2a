#pragma once

#include "commands/can_options.hpp"

namespace driveline::cli {

/// The tools that have the same names on both kinds of bus, on a CAN bus. Each opens the bus and returns the exit
/// status.

/// What `scan` does beside its table.
struct CanScanOptions {
  bool json = false;
  std::string write;            ///< file for a line description; empty: none
  std::optional<double> turns;  ///< revolutions on a path beside it; none: no path
  std::string eds;              ///< data sheet of the nodes, or a folder of them; empty: none
};
/// `scan`: which nodes there are; compares them with the description, or writes one.
[[nodiscard]] Outcome<int> scan_can(const runtime::BusOptions& bus, const CanOptions& can,
                                    const CanScanOptions& options);
/// `slaves`: identities, versions and states.
[[nodiscard]] Outcome<int> list_can_nodes(const runtime::BusOptions& bus, const CanOptions& can, bool as_json);
/// `states`: NMT states.
[[nodiscard]] Outcome<int> show_can_states(const runtime::BusOptions& bus, const CanOptions& can,
                                           const std::string& wanted, bool as_json);

/// The object of `upload` and `download`.
struct CanObjectOptions {
  std::string index;
  std::string subindex;
  std::string type;   ///< empty: as in the description of the device, or raw bytes
  std::string value;  ///< download only
  bool block = false;
  bool json = false;
};
/// `upload`: reads an object.
[[nodiscard]] Outcome<int> upload_can(const runtime::BusOptions& bus, const CanOptions& can,
                                      const CanObjectOptions& object);
/// `download`: writes an object.
[[nodiscard]] Outcome<int> download_can(const runtime::BusOptions& bus, const CanOptions& can,
                                        const CanObjectOptions& object);

/// What `sdos` lists.
struct CanDictionaryOptions {
  std::string index;  ///< empty: all objects
  std::string eds;    ///< description of the device; empty: by its identity, else objects are searched
  bool quiet = false;
  bool verbose = false;
  bool json = false;
};
/// `sdos`: the objects of the nodes.
[[nodiscard]] Outcome<int> list_can_objects(const runtime::BusOptions& bus, const CanOptions& can,
                                            const CanDictionaryOptions& options);
/// `pdos`: the PDOs of the nodes and what is mapped into them.
[[nodiscard]] Outcome<int> list_can_pdos(const runtime::BusOptions& bus, const CanOptions& can, bool as_json);

}  // namespace driveline::cli

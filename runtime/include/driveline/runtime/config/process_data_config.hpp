#pragma once

#include <string>
#include <vector>

#include "driveline/ecat_master/process_data/process_image.hpp"

namespace driveline::runtime {

/// Slaves that are exchanged together: a [[group]] of a line description.
struct ExchangeGroupConfig {
  std::string name;                             ///< name by which the file refers to the group
  ecat_master::ExchangeGroupSettings settings;  ///< divider, phase, limit of bad cycles
};

/// A [[copy]]: an input of a slave that is copied to an output of another slave, by the names in ProcessVariables.
struct CopyConfig {
  std::string from;        ///< input, "slave.object"
  std::string to;          ///< output, "slave.object"
  std::string from_place;  ///< "file:line: [copy 1] from", for errors that appear only once the line is configured
  std::string to_place;    ///< same for `to`
};

/// A name that the file gives to an entry of a slave's process data ([slave.names]).
struct EntryName {
  std::string name;    ///< the new name, without the slave
  std::string object;  ///< name in ProcessVariables, without the slave
  std::string place;   ///< "file:line: [slave 1.names] name"
};

/// Layout, groups and copies of the process image in a line description.
struct ProcessDataConfig {
  /// How outputs and inputs share the logical address space.
  ecat_master::ImageLayout layout = ecat_master::ImageLayout::kOverlapped;
  std::vector<ExchangeGroupConfig>
      groups;                      ///< indexed by group number in the image; none: all slaves together in every cycle
  std::vector<CopyConfig> copies;  ///< in the order of the file
};

}  // namespace driveline::runtime

#pragma once

#include <memory>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/bridge/dds_commands.hpp"
#include "driveline/bridge/dds_publisher.hpp"
#include "driveline/bridge/dds_setpoints.hpp"
#include "driveline/rt/shared_block.hpp"
#include "driveline/rt/shared_mapping.hpp"
#include "driveline/rt/shared_ring.hpp"
#include "driveline/snapshot/feed/command_records.hpp"
#include "driveline/snapshot/feed/feed_reader.hpp"
#include "driveline/snapshot/feed/setpoint_records.hpp"

namespace driveline::bridge {

/// Passes commands and setpoints from DDS to shared memory, and answers and reports back. Belongs to one thread.
class CommandRelay {
 public:
  /// `descriptor`: region of the commands; the regions of answers, setpoints and stream reports have the next three
  /// numbers. They remain the caller's. `publisher` must outlive it. Errors: a region has another version, or DDS
  /// refuses.
  [[nodiscard]] static tl::expected<std::unique_ptr<CommandRelay>, snapshot::FeedError> open(int descriptor,
                                                                                             DdsPublisher& publisher);

  /// Passes on what is available now, up to a limit per call.
  void serve();

 private:
  /// Regions shared with the process of the line.
  struct Regions {
    rt::SharedMapping commands;
    rt::SharedMapping answers;
    rt::SharedMapping setpoints;
    rt::SharedMapping reports;
  };
  CommandRelay(std::unique_ptr<DdsCommands> dds, std::unique_ptr<DdsSetpoints> streams, Regions regions);
  void serve_streams();

  std::unique_ptr<DdsCommands> dds_;
  std::unique_ptr<DdsSetpoints> streams_;
  Regions regions_;
  rt::SharedRingWriter<snapshot::CommandRecord> writer_;
  rt::SharedBlockReader reader_;
  std::vector<std::uint64_t> record_;
  rt::SharedRingWriter<snapshot::StreamedSetpoint> setpoint_writer_;
  rt::SharedBlockReader report_reader_;
  std::vector<std::uint64_t> report_record_;
  std::vector<snapshot::StreamedSetpoint> batch_;
};

}  // namespace driveline::bridge

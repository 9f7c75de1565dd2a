#pragma once

#include <memory>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/bridge/dds_commands.hpp"
#include "driveline/bridge/dds_publisher.hpp"
#include "driveline/rt/shared_block.hpp"
#include "driveline/rt/shared_mapping.hpp"
#include "driveline/rt/shared_ring.hpp"
#include "driveline/snapshot/feed/command_records.hpp"
#include "driveline/snapshot/feed/feed_reader.hpp"

namespace driveline::bridge {

/// Carries commands from DDS into shared memory, and their answers back. Belongs to one thread.
class CommandRelay {
 public:
  /// `descriptor`: of the region of the commands; that of their answers has the next number. Both remain the caller's.
  /// `publisher` must outlive it. Errors: a region is not of this version, or
  /// DDS refuses.
  [[nodiscard]] static tl::expected<std::unique_ptr<CommandRelay>, snapshot::FeedError> open(int descriptor,
                                                                                             DdsPublisher& publisher);

  /// All that is there now, as far as it is not too much for one time.
  void serve();

 private:
  CommandRelay(std::unique_ptr<DdsCommands> dds, rt::SharedMapping commands, rt::SharedMapping answers);

  std::unique_ptr<DdsCommands> dds_;
  rt::SharedMapping commands_;
  rt::SharedMapping answers_;
  rt::SharedRingWriter<snapshot::CommandRecord> writer_;
  rt::SharedBlockReader reader_;
  std::vector<std::uint64_t> record_;
};

}  // namespace driveline::bridge

#pragma once

#include <memory>

namespace eprosima::fastdds::rtps {
struct TransportDescriptorInterface;
}  // namespace eprosima::fastdds::rtps

namespace driveline::bridge {

/// The shared memory of Fast DDS in one direction: samples go by it to readers who can have them so, which are those
/// of the user that this process is; nobody is told of a port here, so whatever comes, comes by another transport. By
/// the transports before it the samples go to them, too.
///
/// Fast DDS 2.9 alone would write to the ports of all readers of this machine and to nothing else of theirs, and they
/// to ours, although its segments and ports are of mode 0644: between two users everything would be lost.
[[nodiscard]] std::shared_ptr<eprosima::fastdds::rtps::TransportDescriptorInterface> shared_memory_to_own_user();

}  // namespace driveline::bridge

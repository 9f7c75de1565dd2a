#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "commands/command_desk.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/shared_region.hpp"
#include "driveline/runtime/axes/axis_requests.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/snapshot/feed/setpoint_records.hpp"
#include "stream/remote_streams.hpp"

namespace driveline::runtime {

/// Reads the commands and setpoints that the bridge writes into shared memory, and writes the answers for the bridge.
/// It has its own thread and reads a bounded number of records in each pass, so that nothing that the bridge writes can
/// affect the cycle or the thread of the line.
class CommandService {
 public:
  /// `axis_requests` must outlive it. Error (kMachine): no shared memory.
  [[nodiscard]] static Result<std::unique_ptr<CommandService>> start(AxisRequests& axis_requests,
                                                                     std::chrono::nanoseconds lease_timeout);
  CommandService(const CommandService&) = delete;
  CommandService& operator=(const CommandService&) = delete;
  ~CommandService();

  /// Returns descriptors of the regions for the bridge: commands, answers, setpoints, stream reports.
  [[nodiscard]] std::vector<int> descriptors() const {
    return {commands_.descriptor(), answers_.descriptor(), setpoints_.descriptor(), reports_.descriptor()};
  }
  /// Sends setpoints to these streams from now on; null: discards them. Any thread; after the call the previous streams
  /// are not used any more.
  void attach(RemoteStreams* streams);
  /// Ends the streams before the line ends. Any thread.
  void end_streams();
  /// Reports that the bridge has ended. Any thread.
  void bridge_lost() noexcept { lost_.store(true, std::memory_order_release); }

 private:
  CommandService(AxisRequests& axis_requests, std::chrono::nanoseconds lease_timeout, rt::SharedRegion commands,
                 rt::SharedRegion answers, rt::SharedRegion setpoints, rt::SharedRegion reports);
  void serve();
  void pass();
  void pass_streams();
  void forget_bridge();

  rt::SharedRegion commands_;
  rt::SharedRegion answers_;
  rt::SharedRegion setpoints_;
  rt::SharedRegion reports_;
  rt::SharedRingReader<snapshot::CommandRecord> reader_;
  rt::SharedBlockWriter writer_;
  rt::SharedRingReader<snapshot::StreamedSetpoint> setpoint_reader_;
  rt::SharedBlockWriter report_writer_;
  rt::MonotonicClock clock_;
  AxisRequests& axis_requests_;
  CommandDesk desk_;
  std::mutex streams_lock_;  ///< protects `streams_`
  RemoteStreams* streams_ = nullptr;
  std::uint64_t breaches_ = 0;
  std::uint64_t setpoint_breaches_ = 0;
  std::vector<snapshot::CommandRecord> room_;
  std::vector<snapshot::StreamedSetpoint> setpoint_room_;
  std::atomic<bool> lost_{false};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace driveline::runtime

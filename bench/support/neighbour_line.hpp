#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "support/child_program.hpp"

namespace driveline::bench {

/// What was on the networks of a NeighbourLine.
struct NeighbourTraffic {
  std::uint64_t dds_cycles = 0;   ///< received by a reader, the samples of all eight axes in each
  std::uint64_t eoe_packets = 0;  ///< received from a drive, each with up to 1000 bytes
};

/// Load for the other programs of a benchmark: `driveline run` with eight simulated drives and a cycle of 1 ms, whose
/// telemetry is published by Fast DDS, every cycle of it, and read, and a drive of which is pinged through its EoE end
/// point as fast as it answers. All of it is ordinary work (without CAP_SYS_NICE), which real-time threads go before.
///
/// Needs root in a network namespace of one's own whose loopback interface is up.
class NeighbourLine {
 public:
  /// Starts it, and returns when a drive answers. Null: `setpriv` or `ping` is not installed. Throws
  /// std::runtime_error when it does not start.
  [[nodiscard]] static std::unique_ptr<NeighbourLine> start();
  NeighbourLine(const NeighbourLine&) = delete;
  NeighbourLine& operator=(const NeighbourLine&) = delete;
  ~NeighbourLine();

  /// Throws std::runtime_error when one of its programs has ended by itself.
  void must_go_on();
  /// Ends it.
  [[nodiscard]] NeighbourTraffic finish();

 private:
  NeighbourLine();
  void write_description() const;

  unsigned domain_;
  std::filesystem::path folder_;
  std::unique_ptr<ChildProgram> reader_;
  std::unique_ptr<ChildProgram> run_;
  std::unique_ptr<ChildProgram> pings_;
};

}  // namespace driveline::bench

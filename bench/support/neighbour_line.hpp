#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "support/child_program.hpp"

namespace driveline::bench {

/// Traffic on the networks of a NeighbourLine.
struct NeighbourTraffic {
  std::uint64_t dds_cycles = 0;   ///< received by a reader, each with the samples of all eight axes
  std::uint64_t eoe_packets = 0;  ///< received from a drive, each with up to 1000 bytes
};

/// Load for the other programs of a benchmark: `driveline run` with eight simulated drives and a cycle of 1 ms. Fast
/// DDS publishes the telemetry of every cycle to a reader, and a drive is pinged through its EoE end point as fast as
/// it answers. All of it runs with ordinary priority (without CAP_SYS_NICE), below real-time threads.
///
/// Needs root in a private network namespace whose loopback interface is up.
class NeighbourLine {
 public:
  /// Starts the load, and returns when a drive answers. Null: `setpriv` or `ping` is not installed. Throws
  /// std::runtime_error if it does not start.
  [[nodiscard]] static std::unique_ptr<NeighbourLine> start();
  NeighbourLine(const NeighbourLine&) = delete;
  NeighbourLine& operator=(const NeighbourLine&) = delete;
  ~NeighbourLine();

  /// Throws std::runtime_error if one of its programs has ended on its own.
  void must_go_on();
  /// Ends the load and returns its traffic.
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

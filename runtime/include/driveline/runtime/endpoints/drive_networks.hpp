#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "driveline/runtime/error.hpp"
#include "driveline/slaves/line/simulated_line.hpp"

namespace driveline::runtime {

/// IP stacks of the devices with EoE of a simulated line: one process per device (`driveline-endpoint`) in its own
/// network namespace, so that devices of the same subnet can reach each other only over the line. It answers ARP and
/// ping, shows the device at http://ADDRESS/ and /state.json, and echoes at TCP port 7.
///
/// Frames pass through rings between the thread that runs the line and a thread of this object with ordinary priority,
/// so that the line never waits for an end point. An end point that dies is restarted.
class DriveNetworks {
 public:
  /// How the end points are run.
  struct Settings {
    std::filesystem::path program;                    ///< program of the end point; empty: find_program()
    std::size_t queue = 64;                           ///< most waiting frames in each direction
    std::chrono::milliseconds status_period{250};     ///< interval at which the status of a device is read
    std::chrono::milliseconds start_limit{5000};      ///< time-out for the start of all end points
    std::chrono::milliseconds first_pause{200};       ///< pause before the first restart, doubled each time
    std::chrono::milliseconds longest_pause{10'000};  ///< longest pause before a restart
  };
  /// Figures of a device since the start.
  struct Figures {
    std::size_t slave = 0;          ///< position in the line
    bool running = false;           ///< its end point is ready
    std::int32_t process = 0;       ///< process of its end point; 0: none
    std::uint64_t from_master = 0;  ///< frames that the device handed to its network
    std::uint64_t to_master = 0;    ///< frames that the device took from it
    std::uint64_t dropped = 0;      ///< frames of either direction dropped because the ring was full
    std::uint64_t malformed = 0;    ///< invalid messages from the end point
    std::uint64_t restarts = 0;     ///< restarts of the end point
    std::string failure;            ///< reason of the last failure of the end point, in its words; empty: none
  };

  /// Starts the end points of all devices with EoE and waits until they are ready. The line must be idle meanwhile, and
  /// outlive this object. Error (kMachine): an end point cannot be started, or fails, with its sentence.
  [[nodiscard]] static Result<std::unique_ptr<DriveNetworks>> start(slaves::SimulatedLine& line,
                                                                    const Settings& settings);
  /// Same, with the default settings.
  [[nodiscard]] static Result<std::unique_ptr<DriveNetworks>> start(slaves::SimulatedLine& line) {
    return start(line, Settings{});
  }
  /// Ends the end points. The line must be idle meanwhile.
  ~DriveNetworks();
  DriveNetworks(const DriveNetworks&) = delete;
  DriveNetworks& operator=(const DriveNetworks&) = delete;

  /// Finds the program of the end point: from the environment variable DRIVELINE_ENDPOINT, else in the folder of this
  /// program, or in ../libexec/driveline from there, where it is installed. Error (kMachine): it does not exist.
  [[nodiscard]] static Result<std::filesystem::path> find_program();

  /// Returns the figures of the devices with EoE, in the order of the line. Any thread.
  [[nodiscard]] std::vector<Figures> figures() const;

 private:
  class Pump;
  explicit DriveNetworks(std::unique_ptr<Pump> pump) noexcept;
  std::unique_ptr<Pump> pump_;
};

}  // namespace driveline::runtime

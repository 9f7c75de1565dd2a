#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "driveline/runtime/error.hpp"
#include "driveline/slaves/line/line.hpp"

namespace driveline::runtime {

/// The IP stacks of the devices of a simulated line that have EoE: one process each (`driveline-endpoint`), with a
/// network namespace of its own, so that devices of one subnet do not know each other but over the line. It answers
/// ARP and ping, shows the device at http://ADDRESS/ and /state.json, and echoes at TCP port 7.
///
/// Frames go through rings between the thread that drives the line and a thread of this object with ordinary priority,
/// so that the line never waits for an end point. One that dies is started again.
class DriveNetworks {
 public:
  /// How the end points are run.
  struct Settings {
    std::filesystem::path program;                    ///< the end point; empty: find_program()
    std::size_t queue = 64;                           ///< frames in each direction that may wait
    std::chrono::milliseconds status_period{250};     ///< between two looks at what a device shows
    std::chrono::milliseconds start_limit{5000};      ///< until all end points must be ready
    std::chrono::milliseconds first_pause{200};       ///< before a dead one is started again, doubled each time
    std::chrono::milliseconds longest_pause{10'000};  ///< and no longer
  };
  /// Of one device, since the start.
  struct Figures {
    std::size_t slave = 0;          ///< position in the line
    bool running = false;           ///< its end point is ready
    std::int32_t process = 0;       ///< that is its end point; 0: none
    std::uint64_t from_master = 0;  ///< frames that the device handed to its network
    std::uint64_t to_master = 0;    ///< frames that the device took from it
    std::uint64_t dropped = 0;      ///< frames of either direction for which there was no room
    std::uint64_t malformed = 0;    ///< messages of the end point that are none
    std::uint64_t restarts = 0;     ///< of the end point
    std::string failure;            ///< why the end point failed last, in its words; empty: it has not
  };

  /// Starts the end points of all devices with EoE and waits until they are ready. The line must rest meanwhile, and
  /// outlive this. Error (kMachine): an end point cannot be started, or fails, with its sentence.
  [[nodiscard]] static Result<std::unique_ptr<DriveNetworks>> start(slaves::Line& line, const Settings& settings);
  /// With the default settings.
  [[nodiscard]] static Result<std::unique_ptr<DriveNetworks>> start(slaves::Line& line) {
    return start(line, Settings{});
  }
  /// Ends the end points. The line must rest meanwhile.
  ~DriveNetworks();
  DriveNetworks(const DriveNetworks&) = delete;
  DriveNetworks& operator=(const DriveNetworks&) = delete;

  /// The end point: that of the environment variable DRIVELINE_ENDPOINT; else beside this program, or in
  /// ../libexec/driveline from there, as it is installed. Error (kMachine): it is not there.
  [[nodiscard]] static Result<std::filesystem::path> find_program();

  /// Of the devices with EoE, in the order of the line. Any thread.
  [[nodiscard]] std::vector<Figures> figures() const;

 private:
  class Pump;
  explicit DriveNetworks(std::unique_ptr<Pump> pump) noexcept;
  std::unique_ptr<Pump> pump_;
};

}  // namespace driveline::runtime

#pragma once

#include <poll.h>

#include <memory>
#include <vector>

#include "cockpit.hpp"
#include "outcome.hpp"

struct MHD_Daemon;

namespace driveline::endpoint {

/// HTTP on port 80: `/` is the cockpit page, `/state.json` the state. Runs in the thread that calls serve().
class WebServer {
 public:
  /// Serves the current content of `state`, which must outlive the server.
  [[nodiscard]] static Outcome<WebServer> open(const CockpitState& state);

  /// Appends the descriptors to wait for.
  void wait_for(std::vector<pollfd>& descriptors) const;
  /// Handles everything that is possible without waiting.
  void serve();

 private:
  struct Stop {
    void operator()(MHD_Daemon* daemon) const noexcept;
  };
  explicit WebServer(MHD_Daemon* daemon) : daemon_(daemon) {}

  std::unique_ptr<MHD_Daemon, Stop> daemon_;
};

}  // namespace driveline::endpoint

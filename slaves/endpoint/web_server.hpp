#pragma once

#include <poll.h>

#include <memory>
#include <vector>

#include "cockpit.hpp"
#include "outcome.hpp"

struct MHD_Daemon;

namespace driveline::endpoint {

/// HTTP at port 80: `/` the cockpit, `/state.json` the state. Runs in the thread that calls serve().
class WebServer {
 public:
  /// Shows `state` as it is when it is asked for, which must outlive the server.
  [[nodiscard]] static Outcome<WebServer> open(const CockpitState& state);

  /// Appends what it waits for.
  void wait_for(std::vector<pollfd>& descriptors) const;
  /// Does what can be done without waiting.
  void serve();

 private:
  struct Stop {
    void operator()(MHD_Daemon* daemon) const noexcept;
  };
  explicit WebServer(MHD_Daemon* daemon) : daemon_(daemon) {}

  std::unique_ptr<MHD_Daemon, Stop> daemon_;
};

}  // namespace driveline::endpoint

#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "driveline/canopen_master/can_master.hpp"
#include "driveline/canopen_master/node_line.hpp"

namespace driveline::canopen {

/// An error of the line as a whole.
[[nodiscard]] NodeError line_error(NodeErrorKind kind);

/// The first boot of a line: listens for another master, boots all nodes side by side, collects their errors, and lays
/// out the process data when all mappings are known. Waits on the port.
class LineBoot {
 public:
  /// `plan` is completed. All must outlive this.
  LineBoot(CanPort& port, rt::Clock& clock, MasterPlan& plan, const CanMaster::Settings& settings) noexcept
      : port_(&port), clock_(&clock), plan_(&plan), settings_(&settings) {}

  /// Boots; returns the errors of all nodes, empty: the line is configured.
  [[nodiscard]] NodeErrors run(const CanMaster::Progress& progress);
  /// After run(): the nodes; null when nothing was sent.
  [[nodiscard]] std::unique_ptr<NodeLine> take_line() noexcept { return std::move(line_); }
  /// After run() without errors: the process data.
  [[nodiscard]] std::optional<PdoImage> take_image() noexcept { return std::move(image_); }
  /// What did not stop the boot.
  [[nodiscard]] NodeErrors take_notes() noexcept { return std::move(notes_); }

 private:
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept { return clock_->now(); }
  [[nodiscard]] bool listen();
  void tell(const CanMaster::Progress& progress, std::vector<BootStep>& told) const;
  [[nodiscard]] NodeErrors errors() const;
  void adopt_plans();
  [[nodiscard]] NodeErrors make_image();
  [[nodiscard]] std::optional<NodeError> missing_mapping(std::size_t number) const;

  CanPort* port_;
  rt::Clock* clock_;
  MasterPlan* plan_;
  const CanMaster::Settings* settings_;
  std::unique_ptr<NodeLine> line_;
  std::optional<PdoImage> image_;
  NodeErrors notes_;
};

}  // namespace driveline::canopen

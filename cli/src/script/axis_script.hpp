#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/runtime/axes/axis_requests.hpp"
#include "driveline/runtime/config/coupling_config.hpp"
#include "failure.hpp"
#include "script/script_groups.hpp"

namespace driveline::cli {

/// A script of requests to axes and groups of axes, executed one after the other:
///
///     x move 90deg velocity=30deg/s  submits the request and continues at once
///     plotter move 90mm 20mm         the same for a group
///     plotter path contour.jsonl     follows the moves of a file; its path is relative to the folder of the script
///     wait x                         waits until x has completed or reached its last request; `wait all`
///     sleep 0.5s
///     # a comment
///
/// At its end the script waits for all of its requests.
class AxisScript {
 public:
  /// The names that a script may use: the axes, groups and couplings of a line.
  struct Names {
    std::span<const motion::AxisConfig> axes;
    std::span<const runtime::AxisGroupConfig> groups{};
    const runtime::CouplingPlan* couplings = nullptr;  ///< gears and cams of the axes; null: there are none
  };

  /// Reads a script. Failure (status 2): file, line and what was expected.
  [[nodiscard]] static Outcome<AxisScript> read(const std::filesystem::path& file, const Names& names);
  /// The same for a text in memory. `name`: the file name in failures.
  [[nodiscard]] static Outcome<AxisScript> parse(std::string_view text, const std::string& name, const Names& names);

  /// Executes as many steps as possible; `now` is the time of the line. True: the script is done. Failure: a request
  /// was refused or has failed.
  [[nodiscard]] Outcome<bool> step(runtime::AxisRequests& axis_requests, runtime::GroupRequests& groups,
                                   std::chrono::nanoseconds now);

 private:
  /// A line of the script.
  struct Step {
    enum class Kind : std::uint8_t { kRequest, kGroupRequest, kGroupPath, kWait, kSleep };
    Kind kind = Kind::kRequest;
    std::size_t line = 0;
    std::vector<std::size_t> axes{};
    std::vector<motion::AxisRequest> requests{};   ///< kRequest: one per axis, or else ...
    std::vector<runtime::CouplingOrder> orders{};  ///< ... a coupling order per axis
    std::chrono::nanoseconds time{};
    bool all = false;                             ///< kWait: for all axes and groups
    std::optional<std::size_t> group{};           ///< kGroupRequest, kGroupPath; kWait: the group to wait for
    runtime::ClientGroupRequest group_request{};  ///< kGroupRequest
    std::filesystem::path file{};                 ///< kGroupPath
  };
  /// A request that has been submitted.
  struct Made {
    std::size_t line = 0;
    std::size_t axis = 0;
    std::uint64_t number = 0;
    bool last = true;  ///< no later request to this axis has been submitted
    bool over = false;
  };

  explicit AxisScript(std::string name);
  [[nodiscard]] Outcome<Step> read_step(std::span<const std::string> words, const Names& names) const;
  [[nodiscard]] Outcome<Step> read_group_step(std::size_t group, std::span<const std::string> words,
                                              const Names& names) const;
  void join_blended_moves();
  [[nodiscard]] Outcome<void> ask(runtime::AxisRequests& axis_requests, const Step& step);
  [[nodiscard]] Outcome<void> ask(runtime::GroupRequests& group_requests, const Step& step);
  [[nodiscard]] Outcome<void> to_outcome(const std::optional<ScriptGroups::Trouble>& trouble) const;
  [[nodiscard]] Outcome<void> check_requests(const runtime::AxisRequests& axis_requests);
  [[nodiscard]] Outcome<bool> done(runtime::AxisRequests& axis_requests, runtime::GroupRequests& groups,
                                   const Step& step, std::chrono::nanoseconds now);
  [[nodiscard]] bool arrived(const Step& step) const;
  [[nodiscard]] tl::unexpected<Failure> fail(std::size_t line, const std::string& reason) const;

  std::string name_;
  std::vector<Step> steps_;
  std::size_t next_ = 0;
  bool begun_ = false;
  std::chrono::nanoseconds step_began_{};
  bool step_runs_ = false;
  std::vector<Made> made_;
  ScriptGroups groups_;
};

}  // namespace driveline::cli

#pragma once

#include <chrono>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>

#include "commands/tool_options.hpp"
#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/discovery/line_survey.hpp"
#include "text/drive_view.hpp"

namespace driveline::cli {

/// Reads the drives of a line through their mailboxes without changing their states. A line that is completely in INIT,
/// and stays there for a second when it had a master, has none now: its slaves are taken to PREOP, and to INIT again at
/// the end, unless a master takes them further.
///
/// A mailbox is shared with the master that runs the line: answers may reach that master. Lost answers are requested
/// again.
class DriveLink {
 public:
  /// Opens the line behind `session`, which must outlive the link. Errors: nothing on the line, the bus.
  [[nodiscard]] static Outcome<std::unique_ptr<DriveLink>> open(runtime::Session& session);
  DriveLink(const DriveLink&) = delete;
  DriveLink& operator=(const DriveLink&) = delete;
  /// A line that was taken to PREOP goes back to INIT.
  ~DriveLink();

  [[nodiscard]] std::size_t size() const noexcept { return slaves_.size(); }
  [[nodiscard]] std::vector<std::uint16_t> aliases() const;
  /// Whether another master had taken the line to PREOP or above before.
  [[nodiscard]] bool other_master() const noexcept { return other_master_; }

  /// Reads the drive at `position` anew into `view`. Failure: no mailbox with CoE in its present state, no drive
  /// (1000h), no answer; `view` then keeps its values and names the trouble.
  [[nodiscard]] Outcome<void> read(std::size_t position, DriveView& view);
  /// Acknowledges the fault of the drive at `position`, which must have been read before: writes 1 to P 153 (MSD manual
  /// 13.2; the PC tool's way). Failure: as with read(), or the drive has no such parameter.
  [[nodiscard]] Outcome<void> acknowledge(std::size_t position);

 private:
  explicit DriveLink(runtime::Session& session);
  [[nodiscard]] Outcome<void> take_to_pre_op();
  [[nodiscard]] Outcome<void> read_registers(std::size_t position, DriveView& view);
  [[nodiscard]] bool all_in(std::initializer_list<wire::AlState> states);
  [[nodiscard]] bool left_in_init();
  /// Opens the mailbox as the slave's registers say it is set up.
  [[nodiscard]] Outcome<void> attach(std::size_t position);
  [[nodiscard]] Outcome<void> read_object(std::size_t position, const DriveObjectRow& row, DriveView& view);
  [[nodiscard]] Outcome<std::optional<std::vector<std::byte>>> upload(std::size_t position, const DriveObjectRow& row);

  runtime::Session& session_;
  ecat_master::Master master_;
  ecat_master::MailboxEngine engine_;
  std::vector<ecat_master::SurveyedSlave> slaves_;
  bool other_master_ = false;
  bool raised_ = false;
  std::optional<std::chrono::nanoseconds> in_init_since_;  ///< the whole line, as far as looks have seen it
  std::map<std::size_t, ecat_master::MailboxWindow> attached_;
  /// Objects that a slave does not have; they are not read again.
  std::map<std::size_t, std::vector<DriveObject>> missing_;
};

}  // namespace driveline::cli

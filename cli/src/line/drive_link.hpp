#pragma once

#include <chrono>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>

#include "commands/tool_options.hpp"
#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/discovery/line_survey.hpp"
#include "line/drive_source.hpp"

namespace driveline::cli {

/// Reads the drives of a line through their mailboxes without changing their states. Exception: a line that is
/// completely in INIT, for a second if it had a master, has no master any more. Its slaves are taken to PREOP, and back
/// to INIT at the end, unless another master takes them further.
///
/// The mailboxes are shared with the master that runs the line, so answers may reach that master. Lost answers are
/// requested again.
class DriveLink final : public DriveSource {
 public:
  /// Opens the line of `session`, which must outlive the link. Errors: no slaves on the line, bus errors.
  [[nodiscard]] static Outcome<std::unique_ptr<DriveLink>> open(runtime::Session& session);
  DriveLink(const DriveLink&) = delete;
  DriveLink& operator=(const DriveLink&) = delete;
  /// Takes a line that was raised to PREOP back to INIT.
  ~DriveLink() override;

  [[nodiscard]] std::size_t size() const noexcept override { return slaves_.size(); }
  [[nodiscard]] std::vector<std::uint16_t> aliases() const override;
  /// Whether another master had already taken the line to PREOP or above.
  [[nodiscard]] bool other_master() const noexcept { return other_master_; }

  [[nodiscard]] Outcome<void> read(std::size_t position, DriveView& view) override;
  [[nodiscard]] Outcome<void> acknowledge(std::size_t position) override;

 private:
  explicit DriveLink(runtime::Session& session);
  [[nodiscard]] Outcome<void> take_to_pre_op();
  [[nodiscard]] Outcome<void> read_registers(std::size_t position, DriveView& view);
  [[nodiscard]] bool all_in(std::initializer_list<wire::AlState> states);
  [[nodiscard]] bool left_in_init();
  /// Opens the mailbox as it is configured in the sync managers of the slave.
  [[nodiscard]] Outcome<void> attach(std::size_t position);
  [[nodiscard]] Outcome<void> read_object(std::size_t position, const DriveObjectRow& row, DriveView& view);
  [[nodiscard]] Outcome<std::optional<std::vector<std::byte>>> upload(std::size_t position, unsigned drive,
                                                                      const DriveObjectRow& row);

  runtime::Session& session_;
  ecat_master::Master master_;
  ecat_master::MailboxEngine engine_;
  std::vector<ecat_master::SurveyedSlave> slaves_;
  bool other_master_ = false;
  bool raised_ = false;
  std::optional<std::chrono::nanoseconds> in_init_since_;  ///< since when the whole line has been seen in INIT
  std::map<std::size_t, ecat_master::MailboxWindow> attached_;
  /// Objects that a slave does not have, by position; they are not read again.
  std::map<std::size_t, std::vector<DriveObject>> missing_;
};

}  // namespace driveline::cli

#pragma once

#include <map>
#include <memory>
#include <vector>

#include "commands/tool_options.hpp"
#include "driveline/ecat_master/discovery/line_survey.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/esi/sii.hpp"

namespace driveline::cli {

/// One slave as the commands show it.
struct SlaveView {
  ecat_master::SurveyedSlave slave;
  std::string alias_position;        ///< "0:2": last alias address up to this slave, and number of slaves since then
  std::vector<std::byte> image;      ///< EEPROM content, as far as it could be read
  std::optional<esi::SiiImage> sii;  ///< the decoded content; none: it could not be decoded
  std::string trouble;               ///< the sentence of `info.problem`; empty: the EEPROM has no problem
  ecat_master::SlaveInfo info;       ///< the facts that a master needs, without the EEPROM bytes

  [[nodiscard]] std::string name() const;
};

/// A bus for commands that read: opened and surveyed, but not changed. The destructor prints on stderr if another
/// master was heard in the meantime.
class LineView {
 public:
  LineView(const LineView&) = delete;
  LineView& operator=(const LineView&) = delete;
  ~LineView();
  [[nodiscard]] static Outcome<std::unique_ptr<LineView>> open(const runtime::BusOptions& bus);

  [[nodiscard]] runtime::Session& session() noexcept { return *session_; }
  [[nodiscard]] ecat_master::Master& master() noexcept { return *master_; }
  [[nodiscard]] ecat_master::Bus& bus() noexcept { return master_->bus(); }
  [[nodiscard]] const std::vector<ecat_master::SurveyedSlave>& slaves() const noexcept { return slaves_; }

  [[nodiscard]] Outcome<std::vector<std::size_t>> select(const SlaveSelection& selection) const;
  [[nodiscard]] Outcome<ecat_master::SlaveRef> select_one(const SlaveSelection& selection, bool explicitly) const;
  /// Reads the EEPROMs of the slaves at `positions`.
  [[nodiscard]] std::vector<SlaveView> read(std::span<const std::size_t> positions);
  [[nodiscard]] std::vector<SlaveView> read_all();
  /// Refuses an access that concerns a single slave while that is in SAFEOP or OP; not with `force`.
  [[nodiscard]] Outcome<void> must_not_be_used(std::size_t position, bool force, std::string_view would) const;
  /// Opens the mailboxes of the slaves at `positions`. Slaves in PREOP, SAFEOP and OP keep their state; the others are
  /// taken to PREOP, unless a master drives the line (a slave is in OP) and `force` is not set. Other slaves are not
  /// touched.
  [[nodiscard]] Outcome<void> open_mailboxes(std::span<const std::size_t> positions, bool force);
  /// The mailbox of a slave after open_mailboxes(); null: the slave has none.
  [[nodiscard]] ecat_master::MailboxClient* mailbox(std::size_t position) noexcept;
  /// The mailbox of the selected slave, of slave 0 without a selection. Failure also: no mailbox.
  [[nodiscard]] Outcome<ecat_master::MailboxClient*> open_mailbox(const SlaveSelection& selection, bool force);
  /// Whether another master uses the mailbox of that slave and may receive its answers.
  [[nodiscard]] bool shared(std::size_t position) const;
  /// Repeats `ask`, which returns a Result, until an answer arrives, if answers may go to another master.
  template <typename Ask>
  [[nodiscard]] auto ask(std::size_t position, Ask&& ask) const {
    auto answer = ask();
    for (int attempt = 1; attempt < kAttempts && shared(position) && went_astray(answer); ++attempt) answer = ask();
    return answer;
  }
  /// Failure: a master drives the line, `force` (--force) is not set, and the action in `would` would disturb it.
  [[nodiscard]] Outcome<void> must_not_disturb(bool force, std::string_view would) const;
  /// The connections between the slaves.
  [[nodiscard]] Outcome<ecat_master::Topology> topology();

 private:
  static constexpr int kAttempts = 8;

  LineView() = default;
  template <typename T>
  static bool went_astray(const ecat_master::Result<T>& answer) {
    if (answer) return false;
    const ecat_master::Error& error = answer.error();
    return error.is<ecat_master::facts::MailboxTimeout>() || error.is<ecat_master::facts::MailboxMalformed>();
  }
  [[nodiscard]] std::vector<std::uint16_t> aliases() const;
  /// Counter of the last mailbox message that the slave has accepted.
  [[nodiscard]] std::uint8_t find_counter(ecat_master::SlaveRef slave, ecat_master::MailboxWindow window);
  /// Takes the slaves to PREOP through INIT.
  [[nodiscard]] Outcome<void> enter_pre_op(std::span<const std::size_t> positions);

  std::unique_ptr<runtime::Session> session_;
  std::unique_ptr<ecat_master::Master> master_;
  std::vector<ecat_master::SurveyedSlave> slaves_;
  std::map<std::size_t, std::unique_ptr<ecat_master::MailboxClient>> mailboxes_;
  std::vector<std::size_t> shared_;  ///< positions of slaves whose mailboxes were open before, in SAFEOP or OP
};

/// "alias:position" of every slave as the IgH tool counts: the alias address of the last slave that has one, and the
/// number of slaves since that one; before the first alias 0 and the position on the line.
[[nodiscard]] std::vector<std::string> alias_positions(std::span<const std::uint16_t> aliases);

/// The heading of the section about one slave.
[[nodiscard]] std::string slave_heading(std::size_t position);

}  // namespace driveline::cli

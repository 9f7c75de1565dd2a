#pragma once

#include <map>
#include <memory>
#include <vector>

#include "commands/tool_options.hpp"
#include "driveline/ecat_master/discovery/line_survey.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/esi/sii.hpp"

namespace driveline::cli {

/// One slave as the tools show it.
struct SlaveView {
  ecat_master::SurveyedSlave slave;
  std::string alias_position;        ///< "0:2": last alias address up to here, and slaves since
  std::vector<std::byte> image;      ///< EEPROM content, as far as it could be read
  std::optional<esi::SiiImage> sii;  ///< the same taken apart; nothing when it could not be
  std::string trouble;               ///< why not, or what is wrong with it; empty: nothing

  [[nodiscard]] std::string name() const;
};

/// A bus as most tools need it: opened and looked at, nothing changed on it. Tells on stderr at its end when another
/// master was heard meanwhile.
class LineView {
 public:
  LineView(const LineView&) = delete;
  LineView& operator=(const LineView&) = delete;
  ~LineView();
  [[nodiscard]] static Outcome<std::unique_ptr<LineView>> open(const BusOptions& bus);

  [[nodiscard]] Session& session() noexcept { return *session_; }
  [[nodiscard]] ecat_master::Master& master() noexcept { return *master_; }
  [[nodiscard]] ecat_master::Bus& bus() noexcept { return master_->bus(); }
  [[nodiscard]] const std::vector<ecat_master::SurveyedSlave>& slaves() const noexcept { return slaves_; }

  [[nodiscard]] Outcome<std::vector<std::size_t>> select(const SlaveSelection& selection) const;
  [[nodiscard]] Outcome<ecat_master::SlaveRef> select_one(const SlaveSelection& selection, bool explicitly) const;
  /// Reads the EEPROMs of the slaves at `positions`.
  [[nodiscard]] std::vector<SlaveView> read(std::span<const std::size_t> positions);
  [[nodiscard]] std::vector<SlaveView> read_all();
  /// Takes the slaves at `positions` to PREOP by way of INIT, for SDO transfers; the others are not touched.
  [[nodiscard]] Outcome<void> enter_pre_op(std::span<const std::size_t> positions);
  /// Of a slave that enter_pre_op() took there; null: it has none.
  [[nodiscard]] ecat_master::MailboxClient* mailbox(std::size_t position) noexcept;
  /// The mailbox of the one slave selected, slave 0 without a selection, taken to PREOP. Failure also: no mailbox.
  [[nodiscard]] Outcome<ecat_master::MailboxClient*> open_mailbox(const SlaveSelection& selection);
  /// Who is connected to whom.
  [[nodiscard]] Outcome<ecat_master::Topology> topology();

 private:
  LineView() = default;
  [[nodiscard]] std::vector<std::uint16_t> aliases() const;

  std::unique_ptr<Session> session_;
  std::unique_ptr<ecat_master::Master> master_;
  std::vector<ecat_master::SurveyedSlave> slaves_;
  std::map<std::size_t, std::unique_ptr<ecat_master::MailboxClient>> mailboxes_;
};

/// "alias:position" of every slave as the IgH tool counts: the alias address of the last slave that has one, and how
/// many slaves it is behind that; before the first alias 0 and the position on the line.
[[nodiscard]] std::vector<std::string> alias_positions(std::span<const std::uint16_t> aliases);

/// The heading over the part of one slave.
[[nodiscard]] std::string slave_heading(std::size_t position);

}  // namespace driveline::cli

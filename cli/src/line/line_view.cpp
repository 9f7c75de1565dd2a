#include "line/line_view.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <numeric>
#include <utility>

#include "console.hpp"
#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/discovery/discovery.hpp"
#include "driveline/runtime/setup/process_data_plan.hpp"
#include "driveline/wire/mailbox.hpp"
#include "line/mailbox_registers.hpp"

namespace driveline::cli {
namespace {

void decode_image(SlaveView& view, ecat_master::Result<std::vector<std::byte>> image) {
  view.info = ecat_master::make_slave_info(view.slave.ref, std::move(image));
  view.image = std::exchange(view.info.sii, {});
  if (view.info.problem) view.trouble = ecat_master::describe(*view.info.problem);
  if (auto decoded = esi::decode_sii(view.image)) view.sii = std::move(*decoded);
}

/// Master settings of the line description; defaults if there is none.
ecat_master::Master::Settings settings_of(const runtime::Session& session) {
  auto settings = session.has_config() ? runtime::master_settings(session.config()) : ecat_master::Master::Settings{};
  settings.exchange.guest = true;
  return settings;
}

}  // namespace

std::string SlaveView::name() const {
  if (!sii) return trouble;
  if (const auto* general = sii->find<esi::SiiGeneral>(esi::SiiCategoryType::kGeneral)) {
    if (const auto text = sii->text(general->name_text); !text.empty()) return std::string(text);
    if (const auto text = sii->text(general->order_text); !text.empty()) return std::string(text);
  }
  return fmt::format("0x{:08x}:0x{:08x}", sii->vendor_id, sii->product_code);
}

Outcome<std::unique_ptr<LineView>> LineView::open(const runtime::BusOptions& bus) {
  auto session = open_session(bus);
  if (!session) return tl::unexpected(session.error());
  std::unique_ptr<LineView> view(new LineView);
  view->session_ = std::move(*session);
  view->master_ = std::make_unique<ecat_master::Master>(view->session_->port(), view->session_->clock(),
                                                        settings_of(*view->session_));
  auto slaves = ecat_master::survey(view->bus());
  if (!slaves) return bus_failure(slaves.error());
  view->slaves_ = std::move(*slaves);
  return view;
}

LineView::~LineView() {
  // A process that has claimed the line is a known master, so its traffic is no surprise.
  if (!master_ || session_->claimed_by_another()) return;
  const auto strange = ecat_master::describe_traffic(master_->exchange_statistics());
  if (!strange.empty()) progress("{}", strange);
}

Outcome<void> LineView::must_not_disturb(bool force, std::string_view would) const {
  std::vector<ecat_master::AlReport> states;
  for (const auto& slave : slaves_) states.push_back(slave.al);
  if (auto free = refuse_if_driven(states, force, would); !free) return free;
  return outcome(session_->claim(force, would));
}

Outcome<void> LineView::open_mailboxes(std::span<const std::size_t> positions, bool force) {
  std::vector<std::size_t> below;
  for (const auto position : positions) {
    const auto& slave = slaves_[position];
    const auto state = slave.al.status.state;
    if (!has_mailbox(state)) {
      below.push_back(position);
      continue;
    }
    auto window = read_mailbox_window(bus(), slave.ref);
    if (!window) return tl::unexpected(window.error());
    if (!*window) continue;
    if (state != wire::AlState::kPreOp) {
      // Short, because the answer may have gone to another master: then the request is repeated.
      (*window)->timeouts.response = std::chrono::milliseconds{250};
      shared_.push_back(position);
    }
    (*window)->last_counter = find_counter(slave.ref, **window);
    mailboxes_[position] = std::make_unique<ecat_master::MailboxClient>(master_->mailboxes(), slave.ref, **window);
  }
  if (below.empty()) return {};
  if (auto done = must_not_disturb(force, fmt::format("take slave {} to PREOP", below.front())); !done) return done;
  return enter_pre_op(below);
}

/// A slave drops a mailbox message with the same counter as the previous one (ETG.1000.4 5.6.1), and only its last
/// master knows that counter. So a harmless single-message request is repeated with other counters until it is
/// answered; its counter is then the last one. A dropped request is followed by its abort, which uses a counter too, so
/// the next attempt skips that one.
std::uint8_t LineView::find_counter(ecat_master::SlaveRef slave, ecat_master::MailboxWindow window) {
  window.timeouts.response = std::chrono::milliseconds{100};
  for (const auto before : {std::uint8_t{0}, std::uint8_t{3}}) {
    window.last_counter = before;
    ecat_master::MailboxClient mailbox(master_->mailboxes(), slave, window);
    // Any answer proves that the slave has accepted the counter.
    if (!went_astray(ecat_master::CoeClient(mailbox).upload(0x1000, 0))) return wire::next_mailbox_counter(before);
  }
  return 6;
}

Outcome<void> LineView::enter_pre_op(std::span<const std::size_t> positions) {
  std::vector<ecat_master::SlaveRef> refs;
  for (const auto position : positions) refs.push_back(slaves_[position].ref);
  const auto found = ecat_master::inspect(bus(), refs);
  if (!found) return bus_failure(found.error());
  auto mailboxes = ecat_master::enter_pre_op(master_->mailboxes(), *found);
  if (!mailboxes) return bus_failure(mailboxes.error());
  for (std::size_t i = 0; i < refs.size(); ++i) mailboxes_[positions[i]] = std::move((*mailboxes)[i]);
  return {};
}

bool LineView::shared(std::size_t position) const {
  return std::find(shared_.begin(), shared_.end(), position) != shared_.end();
}

ecat_master::MailboxClient* LineView::mailbox(std::size_t position) noexcept {
  const auto found = mailboxes_.find(position);
  return found == mailboxes_.end() ? nullptr : found->second.get();
}

Outcome<ecat_master::MailboxClient*> LineView::open_mailbox(const SlaveSelection& selection, bool force) {
  const auto slave = select_one(selection, false);
  if (!slave) return tl::unexpected(slave.error());
  const std::size_t position = slave->position;
  if (auto done = open_mailboxes({&position, 1}, force); !done) return tl::unexpected(done.error());
  auto* opened = mailbox(position);
  if (opened == nullptr) return failed(fmt::format("slave {} has no mailbox", position));
  return opened;
}

std::vector<std::uint16_t> LineView::aliases() const {
  std::vector<std::uint16_t> aliases;
  for (const auto& slave : slaves_) aliases.push_back(slave.alias);
  return aliases;
}

Outcome<std::vector<std::size_t>> LineView::select(const SlaveSelection& selection) const {
  return selection.select(aliases());
}

Outcome<ecat_master::SlaveRef> LineView::select_one(const SlaveSelection& selection, bool explicitly) const {
  return selection.select_one(aliases(), explicitly).map([this](std::size_t i) { return slaves_[i].ref; });
}

std::vector<SlaveView> LineView::read(std::span<const std::size_t> positions) {
  std::vector<ecat_master::SlaveRef> refs;
  for (const auto position : positions) refs.push_back(slaves_[position].ref);
  auto images = ecat_master::read_each_sii(bus(), refs);
  const auto names = alias_positions(aliases());
  std::vector<SlaveView> views;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    SlaveView view{slaves_[positions[i]], names[positions[i]], {}, std::nullopt, {}, {}};
    decode_image(view, std::move(images[i]));
    views.push_back(std::move(view));
  }
  return views;
}

std::vector<SlaveView> LineView::read_all() {
  std::vector<std::size_t> positions(slaves_.size());
  std::iota(positions.begin(), positions.end(), std::size_t{0});
  return read(positions);
}

Outcome<void> LineView::must_not_be_used(std::size_t position, bool force, std::string_view would) const {
  const auto state = slaves_[position].al.status.state;
  if (force || (state != wire::AlState::kSafeOp && state != wire::AlState::kOp))
    return outcome(session_->claim(force, would));
  return failed(fmt::format(
      "slave {} is in {}: a master drives it, and this would {}{}; --force does it anyway", position,
      wire::to_text(state), would,
      state == wire::AlState::kOp ? "" : "; `driveline states INIT` takes a line that was left in that state to INIT"));
}

Outcome<ecat_master::Topology> LineView::topology() {
  std::vector<ecat_master::SlaveRef> refs;
  for (const auto& slave : slaves_) refs.push_back(slave.ref);
  const auto facts = ecat_master::read_port_facts(bus(), refs);
  if (!facts) return bus_failure(facts.error());
  auto topology = ecat_master::build_topology(*facts);
  if (!topology) return bus_failure(topology.error());
  return std::move(*topology);
}

std::vector<std::string> alias_positions(std::span<const std::uint16_t> aliases) {
  std::vector<std::string> texts;
  std::uint16_t alias = 0;
  std::size_t since = 0;
  for (const auto own : aliases) {
    if (own != 0) {
      alias = own;
      since = 0;
    }
    texts.push_back(fmt::format("{}:{}", alias, since++));
  }
  return texts;
}

std::string slave_heading(std::size_t position) {
  return fmt::format("=== Master 0, Slave {} ===\n", position);
}

}  // namespace driveline::cli

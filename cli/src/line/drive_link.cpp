#include "line/drive_link.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "driveline/motion/drive/drive_objects.hpp"
#include "line/mailbox_registers.hpp"

namespace driveline::cli {
namespace {

namespace facts = ecat_master::facts;
using wire::AlState;
namespace reg = wire::reg;

/// Short, because another master may have received the answer: then the request is repeated.
constexpr std::chrono::milliseconds kReplyTimeout{250};
constexpr int kAttempts = 4;
/// A master that is starting takes its line out of INIT within this time.
constexpr std::chrono::seconds kLeftAfter{1};

}  // namespace

DriveLink::DriveLink(runtime::Session& session)
    : session_(session),
      master_(session.port(), session.clock(), {.exchange = {.guest = true}}),
      engine_(master_.bus(), {.reply_timeout = kReplyTimeout}) {}

DriveLink::~DriveLink() {
  engine_.close_all();
  // A destructor cannot report an error.
  if (raised_ && all_in({AlState::kInit, AlState::kPreOp})) static_cast<void>(master_.shut_down());
}

bool DriveLink::all_in(std::initializer_list<AlState> states) {
  std::vector<ecat_master::SlaveRef> refs;
  for (const auto& slave : slaves_) refs.push_back(slave.ref);
  const auto reports = ecat_master::read_al_status(master_.bus(), refs);
  if (!reports) return false;
  return std::all_of(reports->begin(), reports->end(), [&states](const auto& report) {
    return std::find(states.begin(), states.end(), report.status.state) != states.end();
  });
}

/// Whether the line has been in INIT for so long that its master must have ended.
bool DriveLink::left_in_init() {
  const auto now = session_.clock().now();
  if (!all_in({AlState::kInit})) {
    in_init_since_.reset();
    return false;
  }
  if (!in_init_since_) in_init_since_ = now;
  return now - *in_init_since_ >= kLeftAfter;
}

Outcome<std::unique_ptr<DriveLink>> DriveLink::open(runtime::Session& session) {
  std::unique_ptr<DriveLink> link(new DriveLink(session));
  auto slaves = ecat_master::survey(link->master_.bus(), ecat_master::SurveyAddresses::kLeave);
  if (!slaves) return bus_failure(slaves.error());
  link->slaves_ = std::move(*slaves);
  link->other_master_ = std::any_of(link->slaves_.begin(), link->slaves_.end(),
                                    [](const auto& slave) { return slave.al.status.state != AlState::kInit; });
  // A master that has just started may not have changed any state yet.
  if (!link->other_master_) link->other_master_ = !session.claim(false, "take the line to PREOP");
  if (!link->other_master_) {
    if (auto done = link->take_to_pre_op(); !done) return tl::unexpected(done.error());
  }
  return link;
}

Outcome<void> DriveLink::take_to_pre_op() {
  raised_ = true;
  other_master_ = false;
  in_init_since_.reset();
  engine_.close_all();
  attached_.clear();
  if (auto done = master_.scan(); !done) return bus_failure(done.error());
  if (auto done = master_.enter_pre_op(); !done) return bus_failure(done.error());
  for (std::size_t i = 0; i < slaves_.size(); ++i) slaves_[i].ref = master_.slaves()[i].info.ref;
  return {};
}

std::vector<std::uint16_t> DriveLink::aliases() const {
  std::vector<std::uint16_t> aliases;
  for (const auto& slave : slaves_) aliases.push_back(slave.alias);
  return aliases;
}

Outcome<void> DriveLink::read_registers(std::size_t position, DriveView& view) {
  const auto& slave = slaves_[position].ref;
  const auto with_address = std::count_if(slaves_.begin(), slaves_.end(),
                                          [&slave](const auto& other) { return other.ref.station == slave.station; });
  if (slave.station == 0 || with_address > 1) {
    return failed(
        fmt::format("slave {} has no unique station address (0x{:04X}), and another master uses the line: the slave is "
                    "not accessed",
                    position, slave.station));
  }
  const auto al = ecat_master::read_al_status(master_.bus(), std::span(&slave, 1));
  if (!al) return bus_failure(al.error());
  view.al = al->front();
  if (view.al.status.state == AlState::kSafeOp || view.al.status.state == AlState::kOp) {
    other_master_ = true;  // another master has raised the line
    raised_ = false;
  }
  const auto dl = master_.bus().read(slave, reg::kDlStatus);
  if (!dl) return bus_failure(dl.error());
  view.dl = wire::DlStatus::from_raw(*dl);
  if (!has_mailbox(view.al.status.state)) {
    attached_.erase(position);
    return failed(fmt::format("slave {} is in {}, in which it has no CoE mailbox{}", position,
                              wire::to_text(view.al.status.state),
                              other_master_ ? "; another master uses the line and must change its state" : ""));
  }
  return {};
}

Outcome<void> DriveLink::attach(std::size_t position) {
  const auto& slave = slaves_[position].ref;
  const auto window = read_mailbox_window(master_.bus(), slave);
  if (!window) return tl::unexpected(window.error());
  if (!*window) {
    return failed(fmt::format("slave {} has no mailbox: sync managers 0 and 1 are not configured for one", position));
  }
  const auto known = attached_.find(position);
  if (known != attached_.end() && known->second == **window) return {};
  engine_.open(slave, **window);
  attached_[position] = **window;
  return {};
}

Outcome<std::optional<std::vector<std::byte>>> DriveLink::upload(std::size_t position, unsigned drive,
                                                                 const DriveObjectRow& row) {
  ecat_master::CoeClient coe(engine_, slaves_[position].ref.position);
  for (int attempt = 1;; ++attempt) {
    auto data = coe.upload(motion::object_of_drive(row.index, drive), row.subindex);
    if (data) return std::optional(std::move(*data));
    if (never_served(data.error())) {
      missing_[position].push_back(row.object);
      return std::nullopt;
    }
    if (data.error().is<facts::SdoAbort>()) return std::nullopt;  // the object is temporarily unavailable
    if (attempt == kAttempts) return bus_failure(data.error());
  }
}

Outcome<void> DriveLink::read_object(std::size_t position, const DriveObjectRow& row, DriveView& view) {
  auto& missing = missing_[position];
  if (std::find(missing.begin(), missing.end(), row.object) != missing.end()) return {};
  auto value = upload(position, view.drive, row);
  if (!value) return tl::unexpected(value.error());
  view.values.set(row.object, std::move(*value));
  return {};
}

Outcome<void> DriveLink::read(std::size_t position, DriveView& view) {
  const bool fresh = view.position != position || !view.values.bits(DriveObject::kDeviceType);
  if (view.position != position) view.values = {};
  view.position = position;
  view.slaves = slaves_.size();
  view.other_master = other_master_;
  const auto fail = [&view](const Failure& failure) {
    view.trouble = failure.text;
    return tl::unexpected(failure);
  };
  if (auto done = read_registers(position, view); !done) {
    if (!left_in_init()) return fail(done.error());
    if (done = take_to_pre_op(); done) done = read_registers(position, view);
    if (!done) return fail(done.error());
  }
  view.other_master = other_master_;
  if (auto done = attach(position); !done) return fail(done.error());
  for (const auto& row : drive_objects()) {
    if (row.constant && !fresh) continue;
    if (auto done = read_object(position, row, view); !done) return fail(done.error());
    if (row.object != DriveObject::kDeviceType) continue;
    if (auto drive = check_device_type(position, view.values); !drive) return fail(drive.error());
  }
  view.trouble.clear();
  return {};
}

Outcome<void> DriveLink::acknowledge(std::size_t position) {
  ecat_master::CoeClient coe(engine_, slaves_[position].ref.position);
  for (int attempt = 1;; ++attempt) {
    const auto done = coe.download_as<std::uint8_t>(kFaultResetIndex, 0, 1);
    if (done) return {};
    if (never_served(done.error())) return no_fault_reset(position);
    if (done.error().is<facts::SdoAbort>() || attempt == kAttempts) return bus_failure(done.error());
  }
}

}  // namespace driveline::cli

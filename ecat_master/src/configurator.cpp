#include "driveline/ecat_master/configurator.hpp"

#include <algorithm>

#include "driveline/ecat_master/process_data_setup.hpp"
#include "driveline/ecat_master/state_machine.hpp"

namespace driveline::ecat_master {
namespace {

using Use = esi::SyncManager::Use;

Error identity_error(const SlaveInfo& slave, std::uint16_t field, std::uint32_t planned, std::uint32_t found) {
  Error error;
  error.kind = ErrorKind::kIdentityMismatch;
  error.slave = slave.ref.position;
  error.address = field;
  error.expected = planned;
  error.received = found;
  return error;
}

}  // namespace

Result<SdoScript> coe_script(const ConfiguredSlave& slave) {
  SdoScript script;
  script.position = slave.info.ref.position;
  const bool fixed_pdos = !slave.info.description.mailbox.any();
  const bool no_pdos = slave.plan.pdos.outputs.empty() && slave.plan.pdos.inputs.empty();
  if (slave.plan.startup_sdos.empty() && (no_pdos || fixed_pdos)) return script;
  if (!slave.mailbox || !slave.info.description.mailbox.coe) {
    Error error;
    error.kind = ErrorKind::kNoMailbox;
    error.slave = slave.info.ref.position;
    return tl::unexpected(error);
  }
  for (const auto& sdo : slave.plan.startup_sdos) {
    script.steps.push_back({{sdo.index, sdo.subindex, false}, sdo.data});
  }
  for (auto& step : pdo_script(slave.plan.pdos)) script.steps.push_back(std::move(step));
  return script;
}

Result<void> compare_identities(std::span<const SlavePlan> plans, std::span<const SlaveInfo> found) {
  if (plans.empty()) return {};
  if (plans.size() != found.size()) {
    Error error;
    error.kind = ErrorKind::kSlaveCountMismatch;
    error.expected = static_cast<std::uint32_t>(plans.size());
    error.received = static_cast<std::uint32_t>(found.size());
    return tl::unexpected(error);
  }
  for (std::size_t i = 0; i < plans.size(); ++i) {
    const auto& device = found[i].description;
    if (plans[i].vendor_id != 0 && plans[i].vendor_id != device.vendor_id) {
      return tl::unexpected(identity_error(found[i], 0, plans[i].vendor_id, device.vendor_id));
    }
    if (plans[i].product_code != 0 && plans[i].product_code != device.product_code) {
      return tl::unexpected(identity_error(found[i], 1, plans[i].product_code, device.product_code));
    }
  }
  return {};
}

Result<std::optional<MailboxWindow>> write_mailbox_channels(Bus& bus, const SlaveInfo& slave) {
  const auto out = find_sync_manager(slave, Use::kMailboxOut);
  const auto in = find_sync_manager(slave, Use::kMailboxIn);
  if (!slave.description.mailbox.any() || !out || !in) return std::nullopt;
  const auto& out_layout = slave.description.sync_managers[*out];
  const auto& in_layout = slave.description.sync_managers[*in];
  for (const auto& [number, layout] : {std::pair{*out, &out_layout}, std::pair{*in, &in_layout}}) {
    if (auto done = write_sync_manager(bus, slave.ref, number, *layout, layout->default_size); !done) {
      return tl::unexpected(done.error());
    }
  }
  return MailboxWindow{out_layout.start_address, out_layout.default_size, in_layout.start_address,
                       in_layout.default_size};
}

Result<std::vector<std::unique_ptr<MailboxClient>>> enter_pre_op(MailboxEngine& engine,
                                                                 std::span<const SlaveInfo> slaves) {
  auto& bus = engine.bus();
  std::vector<SlaveRef> refs;
  for (const auto& slave : slaves) refs.push_back(slave.ref);
  // An attempt before may have got somewhere; sync managers and mailbox counters start anew out of INIT only.
  if (auto done = change_state(bus, refs, wire::AlState::kInit, kPreOpTimeout); !done)
    return tl::unexpected(done.error());
  if (auto done = clear_channels(bus); !done) return tl::unexpected(done.error());
  std::vector<std::unique_ptr<MailboxClient>> mailboxes;
  for (const auto& slave : slaves) {
    mailboxes.push_back(nullptr);
    const auto window = write_mailbox_channels(bus, slave);
    if (!window) return tl::unexpected(window.error());
    if (*window) mailboxes.back() = std::make_unique<MailboxClient>(engine, slave.ref, **window);
  }
  if (auto done = change_state(bus, refs, wire::AlState::kPreOp, kPreOpTimeout); !done)
    return tl::unexpected(done.error());
  return mailboxes;
}

Result<ProcessImage> configure_process_data(MailboxEngine& engine, std::span<ConfiguredSlave> slaves,
                                            const LayoutSettings& layout) {
  std::vector<SdoScript> scripts;
  for (const auto& slave : slaves) {
    auto script = coe_script(slave);
    if (!script) return tl::unexpected(script.error());
    if (!script->steps.empty()) scripts.push_back(std::move(*script));
  }
  for (auto& done : run_scripts(engine, scripts)) {
    if (!done) return tl::unexpected(done.error());
  }
  auto& bus = engine.bus();
  const auto demands = make_demands(bus, slaves);
  if (!demands) return tl::unexpected(demands.error());
  auto image = ProcessImage::lay_out(*demands, layout);
  if (!image) return image;
  for (const auto& slave : slaves) {
    if (auto done = write_process_data_setup(bus, slave, *image); !done) return tl::unexpected(done.error());
  }
  return image;
}

Error explain_state_error(Bus& bus, std::span<ConfiguredSlave> slaves, Error error) {
  const auto code = static_cast<wire::AlStatusCode>(error.code);
  const bool outputs = code == wire::AlStatusCode::kInvalidOutputConfiguration;
  if (error.kind != ErrorKind::kStateRefused || (!outputs && code != wire::AlStatusCode::kInvalidInputConfiguration))
    return error;
  const auto slave = std::find_if(slaves.begin(), slaves.end(),
                                  [&](const ConfiguredSlave& s) { return s.info.ref.position == error.slave; });
  if (slave == slaves.end() || !slave->mailbox) return error;
  const auto number = find_sync_manager(slave->info, outputs ? Use::kOutputs : Use::kInputs);
  if (!number) return error;
  std::array<std::byte, 2> length{};
  CoeClient coe(*slave->mailbox);
  const auto read =
      bus.read(slave->info.ref, static_cast<std::uint16_t>(wire::reg::kSyncManager.at(*number) + 2), length);
  const auto assigned = read_assigned_bytes(coe, outputs ? 0x1C12 : 0x1C13);
  // When the slave does not even tell, the error stays as it is.
  if (!read || !assigned) return error;
  error.extra = *number;
  error.expected = wire::load_le<std::uint16_t>(length);
  error.received = static_cast<std::uint32_t>(*assigned);
  return error;
}

}  // namespace driveline::ecat_master

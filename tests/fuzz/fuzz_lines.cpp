#include "fuzz_lines.hpp"

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>

#include "driveline/ecat_master/master.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/runtime/config/axis_path.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/ethercat/configure_line.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "driveline/runtime/setup/process_data_plan.hpp"

namespace driveline::fuzz {
namespace {

/// Lines that would slow down the fuzzer are parsed, but not built.
constexpr std::size_t kMaxSlaves = 10;
constexpr int kCycles = 4;
/// For mailboxes that never answer: the two seconds of a real line would take too many steps of the simulated one.
constexpr std::chrono::milliseconds kMailboxTimeout{5};

void must_have_a_reason(const std::string& reason) {
  if (reason.empty()) std::abort();
}

void exchange(const runtime::LineConfig& config, ecat_master::Master& master, rt::VirtualClock& clock) {
  auto named = runtime::name_process_data(config, master);
  if (!named) return must_have_a_reason(runtime::describe(named.error()));
  ecat_master::CyclicCore::Settings settings;
  settings.period = config.period;
  settings.copies = named->copies;
  const auto started = master.start_cycle(nullptr, {}, settings, [&clock](ecat_master::CyclicCore& core) {
    return std::make_unique<motion::InlineRunner>(core, clock);
  });
  if (!started) return must_have_a_reason(started.error().message());
  master.pass(kCycles * config.period);
  static_cast<void>(master.shut_down());
}

}  // namespace

void try_line(std::string_view toml, const std::filesystem::path& name) {
  auto config = runtime::parse_line_config(toml, name);
  if (!config) return must_have_a_reason(runtime::describe(config.error()));
  if (!config->axes.empty()) {
    if (const auto path = runtime::load_axis_path(*config); !path)
      return must_have_a_reason(runtime::describe(path.error()));
  }
  if (config->slaves.size() > kMaxSlaves) return;
  for (auto& slave : config->slaves) slave.plan.mailbox_timeouts = {kMailboxTimeout, kMailboxTimeout};
  rt::VirtualClock clock;
  runtime::Observer silent;
  const auto line = runtime::make_simulated_line(*config, clock);
  ecat_master::Master master(*line, clock, runtime::master_settings(*config));
  if (const auto found = master.scan(); !found) return must_have_a_reason(ecat_master::describe(found.error()));
  if (const auto done = runtime::configure_line(master, &*config, silent); !done)
    return must_have_a_reason(runtime::describe(done.error()));
  exchange(*config, master, clock);
}

std::filesystem::path examples() {
  return DRIVELINE_EXAMPLES_DIR;
}

std::string example_line(const std::string& name) {
  std::ifstream stream(examples() / name, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace driveline::fuzz

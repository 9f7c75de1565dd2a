#include "fuzz_lines.hpp"

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>

#include "config/axis_path.hpp"
#include "driveline/cli/line_config.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/rt/clock.hpp"
#include "line/composition.hpp"
#include "line/line_check.hpp"
#include "line/process_data_plan.hpp"

namespace driveline::fuzz {
namespace {

/// Lines that would make the fuzzer slow are read and not built.
constexpr std::size_t kMaxSlaves = 10;
constexpr int kCycles = 4;
/// For mailboxes that never answer: each of the two seconds of a real line takes as many steps of the simulated one.
constexpr std::chrono::milliseconds kMailboxTimeout{5};

void must_have_a_reason(const std::string& reason) {
  if (reason.empty()) std::abort();
}

void exchange(const cli::LineConfig& config, ecat_master::Master& master, rt::VirtualClock& clock) {
  auto named = cli::name_process_data(config, master);
  if (!named) return must_have_a_reason(named.error().text);
  ecat_master::CyclicCore::Settings settings;
  settings.period = config.period;
  settings.copies = named->copies;
  const auto started = master.start_cycle(nullptr, {}, settings, [&clock](ecat_master::CyclicCore& core) {
    return std::make_unique<ecat_master::InlineRunner>(core, clock);
  });
  if (!started) return must_have_a_reason(started.error().message());
  master.pass(kCycles * config.period);
  static_cast<void>(master.shut_down());
}

}  // namespace

void try_line(std::string_view toml, const std::filesystem::path& name) {
  auto config = cli::parse_line_config(toml, name);
  if (!config) return must_have_a_reason(config.error());
  if (!config->axes.empty()) {
    if (const auto path = cli::load_axis_path(*config); !path) return must_have_a_reason(path.error());
  }
  if (config->slaves.size() > kMaxSlaves) return;
  for (auto& slave : config->slaves) slave.plan.mailbox_timeouts = {kMailboxTimeout, kMailboxTimeout};
  rt::VirtualClock clock;
  const auto line = cli::make_simulated_line(*config, clock);
  ecat_master::Master master(*line, clock, cli::master_settings(*config));
  if (const auto found = master.scan(); !found) return must_have_a_reason(ecat_master::describe(found.error()));
  if (const auto done = cli::configure_line(master, &*config); !done) return must_have_a_reason(done.error().text);
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

// Process data of a drive in every cycle: an application reads the status word and the position, and writes the control
// word. Nothing moves; see 05_csp.cpp for that.

#include <atomic>
#include <cstdio>
#include <memory>

#include "driveline/ecat_master/configuration/process_variables.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/devices/device_registry.hpp"
#include "driveline/slaves/line/simulated_line.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"

using namespace driveline;
using namespace std::chrono_literals;

/// Runs in the cycle: no allocation, no lock, no waiting. Accessing an entry is a single load or store.
class Application final : public motion::CycleTask {
 public:
  using Word = motion::PdoEntry<std::uint16_t>;
  using Position = motion::PdoEntry<std::int32_t>;
  Application(Word control_to, Word status_from, Position position_from)
      : control_word_(control_to), status_word_(status_from), position_(position_from) {}

  void update(const motion::TaskCycle& now) noexcept override {
    const auto inputs = now.inputs;
    const auto valid = now.valid;
    const auto outputs = now.outputs;
    control_word_.set(outputs, 0x0006);  // shutdown: ready to be switched on (CiA 402)
    if (!valid[0]) return;               // the inputs are older than this cycle
    status_word.store(status_word_.get(inputs));
    position.store(position_.get(inputs));
  }

  std::atomic<std::uint16_t> status_word{0};
  std::atomic<std::int32_t> position{0};

 private:
  Word control_word_;
  Word status_word_;
  Position position_;
};

int main() {
  rt::VirtualClock clock;
  std::vector<std::unique_ptr<slaves::Slave>> slaves;
  slaves.push_back(std::make_unique<slaves::Slave>(std::make_unique<slaves::msd::MsdDrive>()));
  slaves::SimulatedLine line(clock, std::move(slaves));

  const runtime::DeviceRegistry devices;
  const auto& rules = devices.rules_for({slaves::msd::kVendorId, slaves::msd::kProductCode});
  ecat_master::SlavePlan plan;
  plan.name = "x";
  plan.startup_sdos = rules.startup_sdos({}, 1ms);
  plan.pdos.outputs = {{.index = 0x1600, .objects = {{0x6040, 0, 16}}}};
  plan.pdos.inputs = {{.index = 0x1A00, .objects = {{0x6041, 0, 16}, {0x6064, 0, 32}}}};

  ecat_master::Master master(line, clock);
  auto done = master.scan();
  if (done) done = master.configure({plan});
  if (!done) {
    std::puts(ecat_master::describe(done.error()).c_str());
    return 1;
  }
  // Entries are looked up once, by the names of slave and object; the cycle uses the handles. Addresses work as well
  // ("x.6041h"), and case does not matter. The error for an unknown name lists the existing ones.
  const ecat_master::ProcessVariables variables(master.slaves(), master.image());
  const auto control_word = variables.entry<std::uint16_t>("x.controlword");
  const auto status_word = variables.entry<std::uint16_t>("x.statusword");
  const auto position = variables.entry<std::int32_t>("x.position_actual_value");
  if (!control_word || !status_word || !position) {
    const auto& error = !control_word ? control_word.error() : !status_word ? status_word.error() : position.error();
    std::puts(describe(error).c_str());
    return 1;
  }
  Application application(*control_word, *status_word, *position);
  ecat_master::CyclicCore::Settings settings;
  settings.period = 1ms;
  settings.receive_window = 500us;
  motion::TaskSchedule tasks;
  tasks.add(application, {});
  settings.tasks = &tasks;
  const auto started = master.start_cycle(nullptr, {}, settings, [&clock](ecat_master::CyclicCore& core) {
    return std::make_unique<motion::InlineRunner>(core, clock);
  });
  if (!started || !master.go_operational()) return 1;
  master.pass(100ms);
  std::printf("status word 0x%04X, position %d increments\n", application.status_word.load(),
              application.position.load());
  const bool ready = (application.status_word.load() & 0x006F) == 0x0021;
  return ready && master.shut_down() ? 0 : 1;
}

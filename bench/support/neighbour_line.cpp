#include "support/neighbour_line.hpp"

#include <fmt/format.h>
#include <fmt/ostream.h>
#include <ifaddrs.h>
#include <linux/if_link.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace driveline::bench {
namespace {

using namespace std::chrono_literals;

constexpr int kDrives = 8;
constexpr auto kStartTimeout = std::chrono::seconds{60};
constexpr auto kStartLook = std::chrono::milliseconds{100};
constexpr const char* kInterface = "dl-load";
constexpr const char* kDrive = "192.168.41.5";
constexpr int kPingBytes = 1000;

std::filesystem::path programs() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

/// Prefixes a command line so that the program cannot become a real-time one.
std::vector<std::string> as_ordinary_work(std::vector<std::string> words) {
  words.insert(words.begin(), {"setpriv", "--bounding-set", "-sys_nice", "--inh-caps", "-sys_nice"});
  return words;
}

/// Packets received from an interface of this network namespace; 0: there is no such interface.
std::uint64_t received_by(std::string_view interface) {
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return 0;
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> owner{first, freeifaddrs};
  for (const ifaddrs* entry = first; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_PACKET || interface != entry->ifa_name) continue;
    return static_cast<const rtnl_link_stats*>(entry->ifa_data)->rx_packets;
  }
  return 0;
}

bool answers(const char* address) {
  const auto ping = ChildProgram::start({"ping", "-c", "1", "-W", "1", "-n", "-q", address});
  if (!ping) return false;
  try {
    static_cast<void>(ping->finish());
    return true;
  } catch (const std::runtime_error&) {
    return false;
  }
}

}  // namespace

NeighbourLine::NeighbourLine() : domain_(100U + static_cast<unsigned>(::getpid()) % 50U) {
  auto name = (std::filesystem::temp_directory_path() / "driveline-neighbour-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr)
    throw std::runtime_error("no folder can be made in the one for temporary files");
  folder_ = name;
}

NeighbourLine::~NeighbourLine() {
  pings_.reset();
  run_.reset();
  reader_.reset();
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void NeighbourLine::write_description() const {
  std::ofstream out(folder_ / "line.toml");
  // Ordinary work on a busy machine: no delay ends it.
  fmt::print(out,
             "[line]\nname = \"neighbour\"\ncycle_us = 1000\n[bus]\nmax_lost_ms = 10000\n[realtime]\npolicy = "
             "\"degrade\"\nlock_memory = false\ncpu_latency_us = -1\n[eoe]\ninterface = \"{}\"\naddress = "
             "\"192.168.41.1/24\"\n[telemetry]\ndomain = {}\n[output]\ndirectory = \"out\"\nplots = false\n",
             kInterface, domain_);
  for (int i = 0; i < kDrives; ++i) {
    fmt::print(out,
               "[[slave]]\nname = \"a{0}\"\nip = \"192.168.41.{1}\"\n[slave.watchdog]\nprocess_data_ms = 6500\n"
               "[[axis]]\nname = \"a{0}\"\nmax_velocity = 200.0\nmax_acceleration = 2500.0\n",
               i, 5 + i);
  }
}

std::unique_ptr<NeighbourLine> NeighbourLine::start() {
  std::unique_ptr<NeighbourLine> line(new NeighbourLine);
  line->write_description();
  const auto folder = programs();
  line->reader_ = ChildProgram::start({folder / "telemetry_reader" / "fast_dds_reader", std::to_string(line->domain_)});
  if (!line->reader_) throw std::runtime_error("fast_dds_reader is not there: build all");
  line->run_ = ChildProgram::start(
      as_ordinary_work({folder.parent_path() / "driveline", "run", "--config", line->folder_ / "line.toml"}));
  if (!line->run_) return nullptr;
  const auto patience = std::chrono::steady_clock::now() + kStartTimeout;
  while (!answers(kDrive)) {
    line->must_go_on();
    if (std::chrono::steady_clock::now() > patience)
      throw std::runtime_error(fmt::format("no drive of the neighbouring line answers at {}", kDrive));
    std::this_thread::sleep_for(kStartLook);
  }
  line->pings_ = ChildProgram::start({"ping", "-f", "-q", "-n", "-s", std::to_string(kPingBytes), kDrive});
  if (!line->pings_) return nullptr;
  return line;
}

void NeighbourLine::must_go_on() {
  for (auto* program : {reader_.get(), run_.get(), pings_.get()}) {
    if (program == nullptr || !program->has_ended()) continue;
    static_cast<void>(program->finish());  // throws, with the reason, if it has failed
    throw std::runtime_error("a program of the neighbouring line has ended before the measurement");
  }
}

NeighbourTraffic NeighbourLine::finish() {
  NeighbourTraffic traffic;
  traffic.eoe_packets = received_by(kInterface);
  pings_.reset();
  run_.reset();
  reader_->signal(SIGTERM);
  traffic.dds_cycles = nlohmann::json::parse(reader_->finish()).at("cycles").get<std::uint64_t>();
  return traffic;
}

}  // namespace driveline::bench

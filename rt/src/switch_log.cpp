#include "driveline/rt/switch_log.hpp"

#include <linux/perf_event.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <fstream>
#include <system_error>

namespace driveline::rt {
namespace {

using std::chrono::nanoseconds;

constexpr std::size_t kHeaderBytes = 4096;  // page of metadata before the records
constexpr std::size_t kRecordBytes = 1U << 16;
/// Offsets in a switch record: the previous or next thread, followed by the fields that end every record.
constexpr std::size_t kSampleAt = sizeof(perf_event_header) + 2 * sizeof(std::uint32_t);
constexpr std::size_t kThreadAt = kSampleAt + sizeof(std::uint32_t);
constexpr std::size_t kTimeAt = kSampleAt + 2 * sizeof(std::uint32_t);
constexpr std::size_t kSwitchBytes = kTimeAt + sizeof(std::uint64_t);

perf_event_attr switches_of_a_cpu() noexcept {
  perf_event_attr what{};
  what.size = sizeof what;
  what.type = PERF_TYPE_SOFTWARE;
  what.config = PERF_COUNT_SW_DUMMY;
  what.context_switch = 1;
  what.sample_id_all = 1;
  what.sample_type = PERF_SAMPLE_TID | PERF_SAMPLE_TIME;
  what.use_clockid = 1;
  what.clockid = CLOCK_MONOTONIC;
  // The kernel writes the newest record first and overwrites the oldest.
  what.write_backward = 1;
  return what;
}

template <typename T>
T value_at(const std::byte* records, std::size_t at) noexcept {
  T value{};
  // The size of a record is a multiple of eight bytes, so a record wraps around the end of the memory only between
  // fields.
  std::memcpy(&value, records + at % kRecordBytes, sizeof value);
  return value;
}

}  // namespace

std::string SwitchLogError::message() const {
  const std::string what = "thread switches of CPU " + std::to_string(cpu) + " cannot be recorded: ";
  if (error_number == EPERM || error_number == EACCES)
    return what + "it needs root or the capability CAP_PERFMON (`setcap cap_perfmon+ep`)";
  if (error_number == ENODEV || error_number == EINVAL) return what + "there is no such CPU";
  if (error_number == ENOENT || error_number == ENOSYS || error_number == EOPNOTSUPP)
    return what + "the kernel does not support it (CONFIG_PERF_EVENTS)";
  return what + std::generic_category().message(error_number);
}

tl::expected<std::unique_ptr<SwitchLog>, SwitchLogError> SwitchLog::open(int cpu) {
  auto what = switches_of_a_cpu();
  const auto descriptor = static_cast<int>(
      syscall(SYS_perf_event_open, &what, -1, cpu, -1, static_cast<unsigned long>(PERF_FLAG_FD_CLOEXEC)));
  if (descriptor < 0) return tl::unexpected(SwitchLogError{cpu, errno});
  // Map without PROT_WRITE: only then does the kernel overwrite the oldest records.
  void* memory = mmap(nullptr, kHeaderBytes + kRecordBytes, PROT_READ, MAP_SHARED, descriptor, 0);
  if (memory == MAP_FAILED) {
    const int error_number = errno;
    close(descriptor);
    return tl::unexpected(SwitchLogError{cpu, error_number});
  }
  // Not make_unique, because the constructor is private.
  return std::unique_ptr<SwitchLog>{new SwitchLog{descriptor, static_cast<std::byte*>(memory)}};
}

SwitchLog::~SwitchLog() {
  munmap(memory_, kHeaderBytes + kRecordBytes);
  close(descriptor_);
}

std::size_t SwitchLog::read(nanoseconds since, std::span<CpuSwitch> found) const noexcept {
  const auto& page = *reinterpret_cast<const perf_event_mmap_page*>(memory_);
  const std::byte* records = memory_ + kHeaderBytes;
  // Decreases from 0 with each record.
  const std::uint64_t head = __atomic_load_n(&page.data_head, __ATOMIC_ACQUIRE);
  const std::uint64_t written = std::min<std::uint64_t>(0 - head, kRecordBytes);
  std::size_t count = 0;
  for (std::uint64_t passed = 0; passed + sizeof(perf_event_header) <= written && count < found.size();) {
    const auto at = static_cast<std::size_t>((head + passed) % kRecordBytes);
    const auto header = value_at<perf_event_header>(records, at);
    if (header.size < sizeof header || passed + header.size > written) break;
    passed += header.size;
    const bool to_a_thread = header.type == PERF_RECORD_SWITCH_CPU_WIDE && header.size >= kSwitchBytes &&
                             (header.misc & PERF_RECORD_MISC_SWITCH_OUT) == 0;
    if (!to_a_thread) continue;
    const nanoseconds time{static_cast<std::int64_t>(value_at<std::uint64_t>(records, at + kTimeAt))};
    found[count++] = {time, static_cast<std::int32_t>(value_at<std::uint32_t>(records, at + kThreadAt))};
    if (time <= since) break;
  }
  return count;
}

std::string thread_name(std::int32_t thread) {
  if (thread == 0) return "idle";
  std::ifstream file("/proc/" + std::to_string(thread) + "/comm");
  std::string name;
  std::getline(file, name);
  return name;
}

}  // namespace driveline::rt

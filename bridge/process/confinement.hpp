#pragma once

#include <cstdint>
#include <string>

namespace driveline::bridge {

/// Whether the program is built with a sanitizer, which needs more memory, reads /proc, and stops its threads at the
/// end.
#ifdef DRIVELINE_SANITIZED
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// The user that a process of root changes to.
struct Identity {
  unsigned user = 65534;   ///< must not be 0; 65534 is `nobody`
  unsigned group = 65534;  ///< 65534 is `nogroup`
};

/// Drops, before Fast DDS is started, what a process that reads a network does not need: for root, user and groups (it
/// becomes `identity`, without supplementary groups); capabilities; new privileges; core files; more than 256 MiB of
/// its own memory and 64 open files; real-time scheduling; and `realtime_cpu` (-1: none) if there is another CPU. Its
/// threads get smaller stacks. Returns an error message; empty: success.
[[nodiscard]] std::string give_up_privileges(int realtime_cpu, Identity identity = {});

/// Files that the process can still open.
enum class FileLimits : std::uint8_t {
  kSharedMemory,  ///< only those in /dev/shm
  kNone,          ///< the kernel has no such restriction: the rights of the user apply
};

/// Restricts this thread, and threads that it starts from now on, to opening, creating and removing files in /dev/shm,
/// and none that can be executed, by Landlock. Call it before Fast DDS is started. Requires give_up_privileges().
[[nodiscard]] FileLimits limit_files_to_shared_memory();

/// Restricts this process and all of its threads to the system calls listed in system_call_filter.cpp. Other calls fail
/// with EPERM; calls that would start a program or access another process end this one. Call it after all sockets are
/// open. `shared_memory`: also allow system calls on files, which are needed to reach later readers;
/// limit_files_to_shared_memory() restricts the files. Returns an error message; empty: success. Requires
/// give_up_privileges().
[[nodiscard]] std::string filter_system_calls(bool shared_memory = false);

}  // namespace driveline::bridge

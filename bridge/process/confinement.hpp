#pragma once

#include <cstdint>
#include <string>

namespace driveline::bridge {

/// Whether a sanitizer is part of the program: it needs more memory, reads /proc, and stops its threads in the end.
#ifdef DRIVELINE_SANITIZED
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// Whom a process of root becomes.
struct Identity {
  unsigned user = 65534;   ///< not 0; `nobody`
  unsigned group = 65534;  ///< `nogroup`
};

/// Gives up, before Fast DDS is started, what a process that reads a network needs not have: user and groups where it
/// is root (it becomes `identity`, without supplementary groups), capabilities, new privileges, core files, more than
/// 256 MiB of its own memory and 64 open files, real-time scheduling, and `realtime_cpu` (-1: none) where there is
/// another CPU. Its threads get smaller stacks. What was wrong; empty: nothing.
[[nodiscard]] std::string give_up_privileges(int realtime_cpu, Identity identity = {});

/// How far files are out of reach.
enum class FileLimits : std::uint8_t {
  kSharedMemory,  ///< but for those in /dev/shm
  kNone,          ///< the kernel knows no such limits: the rights of the user count
};

/// Lets this thread, and those that it starts from now on, open, make and remove files in /dev/shm alone, and none that
/// could be run, by Landlock. To be called before Fast DDS is started. Requires give_up_privileges().
[[nodiscard]] FileLimits limit_files_to_shared_memory();

/// Lets this process and all of its threads do only the system calls of the list in system_call_filter.cpp from now on;
/// another one fails with EPERM, and those that would start a program or look into another process end this one. To be
/// called when all sockets are open. `shared_memory`: those on files, too, which it takes to reach readers that come
/// later; limit_files_to_shared_memory() says which files. What was wrong; empty: nothing. Requires
/// give_up_privileges().
[[nodiscard]] std::string filter_system_calls(bool shared_memory = false);

}  // namespace driveline::bridge

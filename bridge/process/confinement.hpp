#pragma once

#include <string>

namespace driveline::bridge {

/// Whether a sanitizer is part of the program: it needs more memory, reads /proc, and stops its threads in the end.
#ifdef DRIVELINE_SANITIZED
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// Gives up, before Fast DDS is started, what a process that reads a network needs not have: user and groups where it
/// is root (it becomes `nobody`), capabilities, new privileges, core files, more than 256 MiB of its own memory and 64
/// open files, real-time scheduling, and `realtime_cpu` (-1: none) where there is another CPU. Its threads get smaller
/// stacks. What was wrong; empty: nothing.
[[nodiscard]] std::string give_up_privileges(int realtime_cpu);

/// Lets this process and all of its threads do only the system calls of the list in system_call_filter.cpp from now on;
/// another one fails with EPERM, and those that would start a program or look into another process end this one. To be
/// called when all sockets are open. What was wrong; empty: nothing. Requires give_up_privileges().
[[nodiscard]] std::string filter_system_calls();

}  // namespace driveline::bridge

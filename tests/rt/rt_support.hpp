#pragma once

#include <string>
#include <vector>

#include "driveline/rt/realtime_report.hpp"

namespace driveline::rt::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif
#else
inline constexpr bool kSanitized = false;
#endif

/// Why this machine refuses a full real-time set-up; empty: it grants it. A child process asks the kernel without the
/// code under test.
std::string realtime_refusal();

/// The setting called `name`; fails the test if the report does not contain it.
const RealtimeItem& setting(const RealtimeReport& report, const std::string& name);

/// All lines of a report, for a failure message.
std::string text_of(const RealtimeReport& report);

}  // namespace driveline::rt::test

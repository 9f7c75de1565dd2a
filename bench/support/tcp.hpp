#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

namespace driveline::bench {

/// Waits until TCP port 7 of `address` takes a connection. Throws Disturbed when it does not within `patience`.
void await_answer(const std::string& address, std::chrono::nanoseconds patience);

/// Round trips of ICMP echoes with 56 bytes, one after the other, in us. Throws Disturbed when one stays away for 5 s.
[[nodiscard]] std::vector<double> ping(const std::string& address, int count);

/// Sends to the TCP echo of every address at once for `duration`, and takes what comes back. Returns ms per MiB that
/// has come back from all of them together, one for every 100 ms after the first 300.
[[nodiscard]] std::vector<double> echo_load(const std::vector<std::string>& addresses,
                                            std::chrono::nanoseconds duration);

}  // namespace driveline::bench

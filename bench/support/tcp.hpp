#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

namespace driveline::bench {

/// Waits until TCP port 7 of `address` accepts a connection. Throws Disturbed if it does not within `patience`.
void await_answer(const std::string& address, std::chrono::nanoseconds patience);

/// Round trips of consecutive ICMP echoes with 56 bytes, in us. Throws Disturbed if an answer takes longer than 5 s.
[[nodiscard]] std::vector<double> ping(const std::string& address, int count);

/// Sends to the TCP echo of every address at once for `duration`, and receives the answers. Returns ms per MiB received
/// from all of them together, a value for every 100 ms after the first 300.
[[nodiscard]] std::vector<double> echo_load(const std::vector<std::string>& addresses,
                                            std::chrono::nanoseconds duration);

}  // namespace driveline::bench

// The IP stack of a simulated device in a separate process: it exchanges Ethernet frames over an inherited socket, and
// supports ARP, ICMP, UDP, TCP, HTTP and echo.

#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "endpoint.hpp"

int main(int argc, char** argv) {
  int socket = -1;
  const std::string_view text = argc == 3 && std::string_view(argv[1]) == "--socket" ? argv[2] : "";
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), socket);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size() || socket < 0) {
    std::fprintf(
        stderr,
        "usage: driveline-endpoint --socket N\n"
        "The network of a simulated drive, started by driveline; N is a SOCK_SEQPACKET socket that it inherits.\n");
    return 2;
  }
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGINT, SIG_IGN);  // from a terminal: the program ends with the socket instead
  driveline::endpoint::Endpoint endpoint(socket);
  const auto result = endpoint.run();
  if (result) return 0;
  std::fprintf(stderr, "driveline-endpoint: %s\n", describe(result.error()).c_str());
  return 1;
}

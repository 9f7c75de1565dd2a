#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "driveline/rt/clock.hpp"
#include "driveline/runtime/can_line/can_line.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/slaves/can/door.hpp"
#include "driveline/wire/eoe.hpp"

namespace driveline::runtime {

class DatagramEntrance;

/// A local address of TCP or UDP; port 0: a free one.
struct TcpPlace {
  wire::IpV4Address address = {127, 0, 0, 1};
  std::uint16_t port = 0;
};

/// Where other programs reach a CAN line.
struct CanEntrances {
  std::vector<TcpPlace> slcan;              ///< serial CAN adapters over TCP
  std::vector<std::filesystem::path> ptys;  ///< serial CAN adapters as terminals: links to make
  std::vector<TcpPlace> socketcand;         ///< servers of the protocol of socketcand
  std::vector<TcpPlace> cannelloni_tcp;     ///< cannelloni over TCP
  std::vector<TcpPlace> cannelloni_udp;     ///< cannelloni in UDP: who sends a packet is a client
};

/// Serves a CAN line to other programs, in the time of a clock: each client is a node that takes part in arbitration,
/// at the end of the cable. An address has up to kMaxClients clients at a time; a terminal is one client.
///
/// Clients that send faster than the bus wait; clients that do not read lose frames. Belongs to one thread, that which
/// calls turn().
class CanServer {
 public:
  static constexpr std::size_t kMaxClients = 8;  ///< of an address

  /// Opens the entrances. `line` and `clock` must outlive this; `interface` is the name of the bus for clients of
  /// socketcand. Error (kMachine): an address or a path is not available.
  [[nodiscard]] static Result<std::unique_ptr<CanServer>> open(CanLine& line, const std::string& interface,
                                                               const CanEntrances& entrances, rt::Clock& clock);
  CanServer(const CanServer&) = delete;
  CanServer& operator=(const CanServer&) = delete;
  ~CanServer();

  /// Does what is due, and waits for clients, the bus or `longest`, whichever comes first.
  void turn(std::chrono::nanoseconds longest);
  /// Returns where each entrance is: "slcan at 127.0.0.1:29550".
  [[nodiscard]] std::vector<std::string> places() const;
  /// Returns the number of clients that are connected; terminals count always.
  [[nodiscard]] std::size_t clients() const noexcept;
  /// Returns the sums over all clients since the start.
  [[nodiscard]] slaves::can::DoorStatistics statistics() const;

 private:
  struct Entrance;
  struct Client;

  CanServer(CanLine& line, rt::Clock& clock);
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept { return clock_->now() - start_; }
  [[nodiscard]] Result<void> listen_everywhere(const std::string& interface, const CanEntrances& entrances);
  [[nodiscard]] Result<void> open_terminal(const std::filesystem::path& link);
  void add_client(Entrance& entrance, std::unique_ptr<slaves::can::Door> door, bool recovers = false);
  void wait(std::chrono::nanoseconds longest);
  void accept(Entrance& entrance);
  void read(Client& client);
  void write(Client& client);
  void drop(Client& client);

  CanLine* line_;
  rt::Clock* clock_;
  std::chrono::nanoseconds start_;
  std::vector<std::unique_ptr<Entrance>> entrances_;
  std::vector<std::unique_ptr<DatagramEntrance>> datagrams_;
};

}  // namespace driveline::runtime

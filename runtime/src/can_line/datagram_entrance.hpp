#pragma once

#include <netinet/in.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "driveline/rt/file_descriptor.hpp"
#include "driveline/runtime/can_line/can_line.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/slaves/can/cannelloni_door.hpp"
#include "driveline/wire/eoe.hpp"

namespace driveline::runtime {

/// A UDP socket whose clients speak cannelloni: each address that has sent a packet is a client and gets the frames of
/// the bus, up to a number of clients. UDP has no end of a connection: an address from which nothing has come for
/// kSilence gives its place to a new one.
class DatagramEntrance {
 public:
  static constexpr std::chrono::seconds kSilence{30};

  /// Opens the socket and puts the doors of its clients on the bus of `line`, which must outlive this; port 0: a free
  /// one. Error (kMachine): the address is not available.
  [[nodiscard]] static Result<std::unique_ptr<DatagramEntrance>> open(CanLine& line, const wire::IpV4Address& address,
                                                                      std::uint16_t port, std::size_t most_clients);

  /// Returns where it is: "cannelloni on UDP at 127.0.0.1:20000".
  [[nodiscard]] const std::string& place() const noexcept { return place_; }
  /// Returns the socket, to wait for it.
  [[nodiscard]] int descriptor() const noexcept { return socket_.get(); }
  /// Whether packets wait for room in the socket.
  [[nodiscard]] bool sends() const noexcept;
  /// Takes the packets that have come, in the time of the bus.
  void read(std::chrono::nanoseconds now);
  /// Sends what the clients are to get.
  void write();
  /// Returns the number of clients.
  [[nodiscard]] std::size_t clients() const noexcept;
  /// Returns the sums over all clients since the start, and the packets that were none of this protocol or found no
  /// place as refused.
  [[nodiscard]] slaves::can::DoorStatistics statistics() const;

 private:
  struct Client {
    std::unique_ptr<slaves::can::CannelloniUdpDoor> door;
    sockaddr_in address{};
    bool there = false;
    std::chrono::nanoseconds last{0};  ///< when a packet came
  };

  DatagramEntrance() = default;
  [[nodiscard]] Client* client_of(const sockaddr_in& address, std::chrono::nanoseconds now);
  void send_packet(Client& client, bool& full);

  std::string place_;
  rt::FileDescriptor socket_;
  std::vector<Client> clients_;
  std::vector<char> buffer_;
  std::uint64_t refused_ = 0;
};

}  // namespace driveline::runtime

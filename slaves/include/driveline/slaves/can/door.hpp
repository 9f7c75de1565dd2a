#pragma once

#include <string>
#include <string_view>

#include "driveline/slaves/can/controller.hpp"

namespace driveline::slaves::can {

/// What has passed a door.
struct DoorStatistics {
  std::uint64_t sent = 0;      ///< frames of the client that its controller has taken
  std::uint64_t received = 0;  ///< frames that were passed on to the client
  std::uint64_t dropped = 0;   ///< frames that the client has lost, because it does not read
  std::uint64_t refused = 0;   ///< commands and frames of the client that were not carried out
  std::uint64_t missing = 0;   ///< packets of the client that did not arrive, by their sequence numbers

  /// Adds the figures of another door. \rtsafe
  DoorStatistics& operator+=(const DoorStatistics& other) noexcept;
};

/// A client outside of this program as a node of the bus: the state of one connection. Bytes come in and go out;
/// sockets and terminals are the business of the caller. A client that does not read loses frames and delays nobody.
///
/// All functions are called by the thread that advances the bus.
class Door : public Node {
 public:
  static constexpr std::size_t kOutputBytes = 64 * 1024;  ///< bytes that wait for a client at most

  Door();

  /// A client has come: the state is that of a new connection.
  void open();
  /// The client has gone: the controller is off, and what waited is lost. A door without a client is not on the bus.
  void leave();
  /// Returns how many bytes of the client are sure to find room in the queue of its controller: the caller lets the
  /// others wait, so that a client may send faster than the bus.
  [[nodiscard]] std::size_t room() const noexcept;
  /// Bytes from the client, in pieces of any size.
  virtual void input(std::string_view bytes, nanoseconds now) = 0;
  /// Bytes for the client.
  [[nodiscard]] std::string_view output() const noexcept { return output_; }
  /// How many bytes of output() are to be sent at once: a packet, where the protocol has packets.
  [[nodiscard]] virtual std::size_t piece() const noexcept { return output_.size(); }
  /// The client has been sent the first `bytes` of output().
  virtual void taken(std::size_t bytes) { output_.erase(0, bytes); }
  /// Whether the connection is to be closed, after the output has been sent.
  [[nodiscard]] bool closing() const noexcept { return closing_; }
  /// Figures of all clients since the start. \rtsafe
  [[nodiscard]] const DoorStatistics& statistics() const noexcept { return statistics_; }

  // Node
  void connected(Controller& controller) override;
  void advance(nanoseconds /*now*/) override {}
  [[nodiscard]] nanoseconds next_wake() const noexcept override { return kNever; }

 protected:
  /// Returns the controller of the client. \rtsafe
  [[nodiscard]] Controller& controller() const noexcept { return *controller_; }
  /// Sends a frame of the client; false, and counted: the controller does not take it.
  bool send(const Frame& frame) noexcept;
  /// Appends an answer; it is lost when the output is full.
  void answer(std::string_view text);
  /// Appends what tells of a number of frames; false: they are dropped and counted, because the output is full. An
  /// empty text is no frame that the client can be told of.
  bool pass_on(std::string_view text, std::uint64_t frames = 1);
  /// Counts a command that was not carried out.
  void refuse() noexcept { ++statistics_.refused; }
  /// Whether frames were dropped since the last call.
  [[nodiscard]] bool take_overrun() noexcept;
  /// Asks for the end of the connection, see closing(). \rtsafe
  void close() noexcept { closing_ = true; }
  /// Returns to the state of a new connection; what greets the client is answer()ed here.
  virtual void restart() = 0;
  /// Ends what goes on by itself: the client has gone.
  virtual void left() noexcept {}
  /// Counts packets of the client that did not arrive.
  void miss(std::uint64_t packets) noexcept { statistics_.missing += packets; }

 private:
  Controller* controller_ = nullptr;
  std::uint32_t bit_rate_ = 0;  ///< of the controller before a client has changed it
  std::string output_;
  DoorStatistics statistics_;
  std::uint64_t told_dropped_ = 0;
  bool closing_ = false;
};

}  // namespace driveline::slaves::can

#pragma once

#include "driveline/slaves/can/door.hpp"

namespace driveline::slaves::can {

/// A client of socketcand (socketcand, doc/protocol.md): opens the bus, and sends and receives frames in raw mode.
///
/// Elements: open, rawmode, bcmmode, echo, send, sendrtr. The jobs of the broadcast manager (add, update, delete,
/// subscribe, filter), control mode and ISO-TP are answered with an error. Remote frames are elements of their own,
/// rtr: clients that do not know it leave them out, and none takes them for data frames.
class SocketcandDoor final : public Door {
 public:
  static constexpr std::size_t kLongestElement = 256;  ///< longer ones are refused as a whole

  /// `bus`: the name by which clients open the bus. `epoch`: what time 0 of the bus is, since 1970.
  explicit SocketcandDoor(std::string bus, nanoseconds epoch = nanoseconds{0});

  void input(std::string_view bytes, nanoseconds now) override;
  void receive(const Frame& frame, nanoseconds now) override;

 private:
  enum class Mode : std::uint8_t { kNoBus, kBroadcastManager, kRaw };

  void restart() override;
  void execute();
  void open_bus(std::string_view name);
  void transmit(canopen::FrameKind kind, std::string_view words);
  void change_mode(Mode mode);
  void fail(std::string_view reason);

  std::string bus_;
  nanoseconds epoch_;
  std::string element_;  ///< from its '<' on
  Mode mode_ = Mode::kNoBus;
  bool inside_ = false;  ///< behind a '<'
};

}  // namespace driveline::slaves::can

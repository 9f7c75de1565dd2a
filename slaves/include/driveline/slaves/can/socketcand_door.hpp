#pragma once

#include "driveline/slaves/can/broadcast_manager.hpp"
#include "driveline/slaves/can/door.hpp"

namespace driveline::slaves::can {

/// A client of socketcand (socketcand, doc/protocol.md): opens the bus, and sends and receives frames.
///
/// Elements: open, rawmode, bcmmode, controlmode, echo, send, sendrtr; in bcmmode add, update, delete, subscribe,
/// filter and unsubscribe, in controlmode statistics. Filters of multiplexed content and ISO-TP are answered with an
/// error. Remote frames are elements of their own, rtr: clients that do not know it leave them out, and none takes them
/// for data frames.
///
/// Frames wait behind the answer to rawmode until the client sends something, at most kQuiet: clients such as that of
/// python-can expect this answer alone in what they read.
class SocketcandDoor final : public Door {
 public:
  static constexpr std::size_t kLongestElement = 256;                   ///< longer ones are refused as a whole
  static constexpr nanoseconds kQuiet = std::chrono::milliseconds{50};  ///< between the answer to rawmode and frames
  /// Shorter intervals of statistics are as long as this.
  static constexpr nanoseconds kShortestStatistics = std::chrono::milliseconds{10};

  /// `bus`: the name by which clients open the bus. `epoch`: what time 0 of the bus is, since 1970.
  explicit SocketcandDoor(std::string bus, nanoseconds epoch = nanoseconds{0});

  void input(std::string_view bytes, nanoseconds now) override;
  void receive(const Frame& frame, nanoseconds now) override;
  void transmitted(const Frame& frame, nanoseconds now) override;
  void advance(nanoseconds now) override;
  [[nodiscard]] nanoseconds next_wake() const noexcept override;

 private:
  enum class Mode : std::uint8_t { kNoBus, kBroadcastManager, kRaw, kControl };
  /// Frames and bytes of one direction, for statistics.
  struct Traffic {
    std::uint64_t bytes = 0;
    std::uint64_t frames = 0;
    void count(const Frame& frame) noexcept;
  };

  void restart() override;
  void left() noexcept override;
  void execute(nanoseconds now);
  [[nodiscard]] bool manage(std::string_view command, std::string_view words, nanoseconds now);
  void add_job(std::string_view words, nanoseconds now);
  void subscribe(std::string_view words, bool filtered);
  void remove(std::string_view words, bool job);
  void set_statistics(std::string_view words, nanoseconds now);
  void tell_statistics(nanoseconds now);
  void open_bus(std::string_view name, nanoseconds now);
  void transmit(canopen::FrameKind kind, std::string_view words);
  void change_mode(Mode mode, nanoseconds now);
  void fail(std::string_view reason);
  void tell(const Frame& frame, nanoseconds now);
  void release();

  std::string bus_;
  nanoseconds epoch_;
  std::string element_;  ///< from its '<' on
  Mode mode_ = Mode::kNoBus;
  bool inside_ = false;  ///< behind a '<'
  BroadcastManager jobs_;
  std::vector<std::string> held_;       ///< frames behind the answer to rawmode
  nanoseconds quiet_until_ = kNever;    ///< kNever: frames are passed on at once
  nanoseconds statistics_interval_{0};  ///< 0: none are sent
  nanoseconds statistics_at_ = kNever;
  Traffic received_;
  Traffic sent_;
};

}  // namespace driveline::slaves::can

#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "driveline/ecat_master/bus/datagram_exchange.hpp"
#include "driveline/ecat_master/cyclic/acyclic_channel.hpp"
#include "driveline/rt/clock.hpp"

namespace driveline::ecat_master {

/// DatagramExchange through an AcyclicChannel: acyclic work while the cycle runs.
class CyclicExchange final : public DatagramExchange {
 public:
  /// Lets time pass while waiting for the cycle: sleeps if a real-time thread runs it, or runs cycles on virtual time.
  using Pass = std::function<void(std::chrono::nanoseconds)>;

  /// Channel and clock must outlive this object. For the one thread on the channel's other side; not \rtsafe.
  CyclicExchange(AcyclicChannel& channel, rt::Clock& clock, Pass pass);

  /// Errors besides those of DatagramExchange: ExchangeFull if earlier abandoned frames still fill the channel.
  [[nodiscard]] Result<void> exchange(std::span<Request> requests) override;
  [[nodiscard]] bool relays() const noexcept override { return true; }
  /// Errors as exchange(). After an error the started work is abandoned.
  [[nodiscard]] Result<void> relay(const Relay& relay) override;
  void pause(std::chrono::nanoseconds duration) override { pass_(duration); }
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept override { return clock_.now(); }

 private:
  /// Requests `first` to `first + count - 1` travel in one frame.
  struct Part {
    std::size_t first = 0;
    std::size_t count = 0;
    std::uint64_t id = 0;  ///< number of the job that carries them now; 0: none
    int tries = 0;
    std::chrono::nanoseconds deadline{0};
    bool done = false;
  };
  /// Requests that are handled alike, and the frames that they are divided into.
  struct Lot {
    std::span<Request> requests;
    std::vector<Part> parts{};
    int tries = 0;             ///< maximum number of tries per frame
    std::uint64_t round = 0;   ///< AcyclicJob::round
    std::uint64_t behind = 0;  ///< AcyclicJob::behind

    [[nodiscard]] bool done() const noexcept;
    [[nodiscard]] bool handed_over() const noexcept;
  };

  [[nodiscard]] Result<void> cut(Lot& lot) const;
  [[nodiscard]] Result<void> carry_out();
  [[nodiscard]] Result<void> submit();
  [[nodiscard]] Result<void> submit_open(Lot& lot);
  [[nodiscard]] AcyclicJob make_job(const Lot& lot, const Part& part) const;
  [[nodiscard]] bool take_answers();
  [[nodiscard]] bool take_answer(Lot& lot, const AcyclicJob& job);
  void adopt();
  void give_up_late(Lot& lot);
  void reopen(Lot& lot, std::size_t part);

  AcyclicChannel& channel_;
  rt::Clock& clock_;
  Pass pass_;
  std::uint64_t next_id_ = 1;
  std::uint64_t rounds_ = 0;
  Lot begun_;
  Lot open_;
  Lot next_;
  std::vector<AcyclicJob> early_;  ///< answers to frames of next_
};

}  // namespace driveline::ecat_master

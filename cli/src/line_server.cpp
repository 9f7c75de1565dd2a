#include "line_server.hpp"

#include <algorithm>

#include "driveline/wire/ethernet.hpp"
#include "driveline/wire/registers.hpp"

namespace driveline::cli {
namespace {

/// Longest sleep without a frame: the drives' control loops must run on.
constexpr auto kIdleStep = std::chrono::microseconds{125};
constexpr std::size_t kMaxChanges = 4096;

}  // namespace

LineServer::LineServer(slaves::Line& line, port::Port& port, rt::Clock& clock)
    : line_(line), port_(port), clock_(clock), states_(line.size()), changes_(kMaxChanges) {}

void LineServer::run(std::stop_token stop) noexcept {
  while (!stop.stop_requested()) {
    if (const auto frame = port_.receive()) {
      serve(*frame);
      continue;
    }
    line_.advance(clock_.now());
    watch_states();
    port_.wait_readable(clock_.now() + kIdleStep);
  }
}

void LineServer::serve(const port::ReceivedFrame& frame) noexcept {
  // As long as the request, but no shorter than Ethernet allows: what a real wire would have padded already.
  const auto length = std::min(frame.bytes.size(), buffer_.size());
  const auto reply = std::span(buffer_).first(std::max(length, wire::kMinFrameBytes));
  std::fill(std::copy_n(frame.bytes.begin(), length, reply.begin()), reply.end(), std::byte{0});
  if (!line_.process(reply, frame.time)) return;
  const auto status = port_.send(reply);
  frames_.store(frames_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  if (status != port::SendStatus::kSent) {
    send_failures_.store(send_failures_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }
  turn_around_.record(clock_.now() - frame.time);
}

void LineServer::watch_states() noexcept {
  for (std::size_t i = 0; i < line_.size(); ++i) {
    const auto& esc = line_.slave(i).esc();
    const auto status = esc.al_status();
    if (status == states_[i]) continue;
    states_[i] = status;
    changes_.try_push({static_cast<std::uint16_t>(i), status,
                       static_cast<wire::AlStatusCode>(esc.memory().get(wire::reg::kAlStatusCode))});
  }
}

}  // namespace driveline::cli

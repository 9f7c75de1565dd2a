#include "driveline/canopen_port/can_capture.hpp"

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "driveline/canopen_wire/candump.hpp"
#include "driveline/capture/pcapng_writer.hpp"

namespace driveline::canopen {
namespace {

using capture::CaptureDirection;

/// Lines of a log of candump. It has no place for directions and drops.
class CandumpLog final : public capture::CaptureFormat {
 public:
  explicit CandumpLog(std::vector<std::byte>& sink) : sink_(sink) {}

  void header(std::string_view interface_name) override { interface_ = interface_name; }
  void packet(const capture::CapturedPacket& packet) override {
    const auto frame = socketcan::parse_packet(packet.bytes);
    if (!frame) return;  // no other bytes are recorded
    const auto time = std::chrono::duration_cast<std::chrono::microseconds>(packet.unix_time).count();
    const auto line = candump::line_of(*frame, interface_, static_cast<std::uint64_t>(std::max<std::int64_t>(time, 0)));
    for (const char c : line.view()) sink_.push_back(static_cast<std::byte>(c));
    sink_.push_back(static_cast<std::byte>('\n'));
  }
  void statistics(std::chrono::nanoseconds /*unix_time*/, std::uint64_t /*captured*/,
                  std::uint64_t /*dropped*/) override {}

 private:
  std::vector<std::byte>& sink_;
  std::string interface_;
};

std::unique_ptr<capture::CaptureFormat> candump_log(std::vector<std::byte>& sink) {
  return std::make_unique<CandumpLog>(sink);
}

std::unique_ptr<capture::CaptureFormat> can_pcapng(std::vector<std::byte>& sink) {
  return std::make_unique<capture::PcapngWriter>(sink, capture::LinkType::kCanSocketcan);
}

CanPortError port_error(const capture::CaptureError& error) {
  return {CanPortErrorCode::kMachine, error.message};
}

}  // namespace

tl::expected<std::unique_ptr<CanCapture>, CanPortError> CanCapture::open(CanPort& inner, const rt::Clock& clock,
                                                                         const CanCaptureConfig& config) {
  CanCaptureConfig named = config;
  if (named.interface_name.empty()) named.interface_name = "can0";
  const bool pcapng = config.file.extension() == ".pcapng";
  auto recorder = Recorder::open(named, pcapng ? can_pcapng : candump_log, clock);
  if (!recorder) return tl::unexpected(port_error(recorder.error()));
  // Not make_unique: the constructor is private.
  return std::unique_ptr<CanCapture>{new CanCapture{inner, clock, std::move(*recorder)}};
}

SendStatus CanCapture::send(const Frame& frame) noexcept {
  const SendStatus status = inner_.send(frame);
  if (status == SendStatus::kSent)
    recorder_->record(CaptureDirection::kOutbound, clock_.now(), socketcan::packet_of(frame));
  return status;
}

std::optional<ReceivedFrame> CanCapture::receive() noexcept {
  const auto received = inner_.receive();
  if (received) recorder_->record(CaptureDirection::kInbound, received->time, socketcan::packet_of(received->frame));
  return received;
}

tl::expected<CanCaptureStatistics, CanPortError> CanCapture::close() {
  auto statistics = recorder_->close();
  if (!statistics) return tl::unexpected(port_error(statistics.error()));
  return *statistics;
}

}  // namespace driveline::canopen

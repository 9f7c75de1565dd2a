#include "driveline/port/capture_port.hpp"

#include <utility>
#include <vector>

#include "driveline/capture/pcapng_writer.hpp"

namespace driveline::port {

namespace {

using capture::CaptureDirection;

PortError port_error(const capture::CaptureError& error) {
  return {error.of_file ? PortErrorCode::kFile : PortErrorCode::kSystem, error.error_number, error.message};
}

std::unique_ptr<capture::CaptureFormat> ethernet_pcapng(std::vector<std::byte>& sink) {
  return std::make_unique<capture::PcapngWriter>(sink, capture::LinkType::kEthernet);
}

}  // namespace

tl::expected<std::unique_ptr<CapturePort>, PortError> CapturePort::open(Port& inner, const rt::Clock& clock,
                                                                        const CaptureConfig& config) {
  auto recorder = Recorder::open(config, ethernet_pcapng, clock);
  if (!recorder) return tl::unexpected(port_error(recorder.error()));
  // Not make_unique: the constructor is private.
  return std::unique_ptr<CapturePort>{new CapturePort{inner, std::move(*recorder)}};
}

SendStatus CapturePort::send(std::span<const std::byte> frame) noexcept {
  const SendStatus status = inner_.send(frame);
  if (status == SendStatus::kSent) recorder_->record(CaptureDirection::kOutbound, inner_.last_send_time(), frame);
  return status;
}

std::optional<ReceivedFrame> CapturePort::receive() noexcept {
  const auto frame = inner_.receive();
  if (frame) recorder_->record(CaptureDirection::kInbound, frame->time, frame->bytes);
  return frame;
}

tl::expected<CaptureStatistics, PortError> CapturePort::close() {
  auto statistics = recorder_->close();
  if (!statistics) return tl::unexpected(port_error(statistics.error()));
  return *statistics;
}

CaptureStatistics CapturePort::statistics() const noexcept {
  return recorder_->statistics();
}

}  // namespace driveline::port

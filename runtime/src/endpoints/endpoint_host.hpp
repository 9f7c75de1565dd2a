#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include "driveline/runtime/endpoints/drive_networks.hpp"
#include "endpoints/device_network.hpp"
#include "helper/helper_process.hpp"
#include "helper/restart_pause.hpp"

namespace driveline::runtime {

/// Runs the end point of a device, and sends it address, link, status and frames. Belongs to one thread.
class EndpointHost {
 public:
  using Clock = std::chrono::steady_clock;

  /// Serves the device at position `slave`; the device must outlive this object.
  EndpointHost(std::size_t slave, slaves::Device& device, std::filesystem::path program,
               const DriveNetworks::Settings& settings)
      : network_(device, settings.queue),
        device_(&device),
        program_(std::move(program)),
        settings_(settings),
        pause_(settings.first_pause, settings.longest_pause) {
    figures_.slave = slave;
  }
  EndpointHost(const EndpointHost&) = delete;  // the device refers to the member `network_`
  EndpointHost& operator=(const EndpointHost&) = delete;
  ~EndpointHost() { device_->connect_network(nullptr); }

  /// Connects the device; false: it has no EoE.
  [[nodiscard]] bool connect() { return device_->connect_network(&network_); }
  /// Starts the process.
  [[nodiscard]] Result<void> start();
  /// Moves all messages that can be moved without waiting; restarts a process that has ended when its pause is over.
  /// Returns true if a message was moved.
  bool serve(Clock::time_point now);

  /// Returns the descriptor to wait for; -1: none, because there is no process or no room for what it sends.
  [[nodiscard]] int descriptor() const noexcept {
    return process_.valid() && network_.has_room() ? process_.descriptor() : -1;
  }
  /// Returns the figures since the start.
  [[nodiscard]] DriveNetworks::Figures figures() const;

 private:
  void ended(Clock::time_point now);
  bool take_messages(Clock::time_point now);
  bool take(const slaves::EndpointPacket& packet);
  bool tell(Clock::time_point now);
  bool send_frames();
  template <typename Content>
  bool send(slaves::EndpointMessage message, const Content& content);

  DeviceNetwork network_;
  slaves::Device* device_;
  std::filesystem::path program_;
  DriveNetworks::Settings settings_;
  HelperProcess process_;
  DriveNetworks::Figures figures_;
  RestartPause pause_;
  Clock::time_point again_at_{};
  Clock::time_point next_status_{};
  std::optional<slaves::EndpointAddress> sent_address_;
  std::optional<bool> sent_link_;
  slaves::EndpointPacket packet_;
  NetworkFrame frame_;
};

}  // namespace driveline::runtime

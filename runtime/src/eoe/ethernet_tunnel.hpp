#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "driveline/ecat_master/eoe/eoe_service.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/eoe/eoe_report.hpp"
#include "eoe/address_schedule.hpp"
#include "eoe/tap_device.hpp"

namespace driveline::runtime {

/// A slave that is reached over EoE.
struct EoeHost {
  std::uint16_t position = 0;        ///< position on the line
  std::string name;                  ///< name of the slave
  wire::EoeIpParameters parameters;  ///< parameters to set; they contain `ip`
};

/// Ethernet over EtherCAT between a TAP interface and slaves: a switch with a port for each of them, and the thread
/// that moves the frames. A slave gets its IP parameters whenever its mailboxes have been opened, at the start or when
/// it returns; its link is then up until its mailboxes are closed. A slave that does not answer is asked again with
/// growing pauses; a slave that refuses is not.
class EthernetTunnel final : private ecat_master::EoeReceiver {
 public:
  /// A slave that has not accepted its IP parameters.
  struct Refusal {
    EoeHost host;              ///< the slave
    ecat_master::Error error;  ///< reason
  };

  /// Opens the ports and starts the thread. `master` must outlive the tunnel. Error (kLine): a slave does not support
  /// EoE.
  [[nodiscard]] static Result<std::unique_ptr<EthernetTunnel>> start(ecat_master::Master& master,
                                                                     std::unique_ptr<TapDevice> tap,
                                                                     const IpNetwork& network,
                                                                     std::vector<EoeHost> hosts);
  EthernetTunnel(const EthernetTunnel&) = delete;
  EthernetTunnel& operator=(const EthernetTunnel&) = delete;
  /// Ends the thread and closes the ports.
  ~EthernetTunnel() override;

  /// Returns the state of all ports. Any thread.
  [[nodiscard]] EoeReport report() const;
  /// Returns the refusals since the last call. Any thread.
  [[nodiscard]] std::vector<Refusal> take_refusals();

 private:
  struct Slave final : SwitchedDevice {
    [[nodiscard]] bool send(std::span<const std::byte> frame) override { return port->send(frame); }

    EoeHost host;
    std::shared_ptr<ecat_master::EoePort> port;
    std::size_t number = 0;                                ///< number of its port at the switch
    AddressSchedule schedule;                              ///< schedule of its IP parameters
    std::shared_ptr<ecat_master::EoeService> being_given;  ///< request in progress that sets its IP parameters
  };

  EthernetTunnel(ecat_master::Master& master, std::unique_ptr<TapDevice> tap, const IpNetwork& network,
                 std::vector<EoeHost> hosts);
  void receive(std::uint16_t position, std::span<const std::byte> frame) override;
  void run(const std::stop_token& stop);
  void supervise(Slave& slave);
  void take_result(Slave& slave, const ecat_master::Result<void>& result);
  [[nodiscard]] bool take_from_tap();
  void rest();
  [[nodiscard]] std::chrono::nanoseconds now() { return master_.bus().exchange().now(); }

  ecat_master::Master& master_;
  std::unique_ptr<TapDevice> tap_;
  IpNetwork network_;
  EthernetSwitch switch_;
  std::vector<std::unique_ptr<Slave>> slaves_;
  /// Time of the last frame, ns; slaves' frames arrive on any thread that steps the engine.
  std::atomic<std::int64_t> last_frame_{0};
  std::mutex mutex_;  ///< protects refusals_
  std::vector<Refusal> refusals_;
  std::jthread thread_;
};

}  // namespace driveline::runtime

#include "shared_memory.hpp"

#include <fastdds/rtps/transport/TransportInterface.h>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdint>
#include <string>
#include <utility>

namespace driveline::bridge {
namespace {

namespace rtps = eprosima::fastdds::rtps;
using rtps::Locator;
using rtps::LocatorList;

constexpr std::uint32_t kSegment = 256 * 1024;  // bytes

/// Prefix of the file of a port; the port number follows.
constexpr const char* kPortFile = "/dev/shm/fastrtps_port";

/// Checks the owner of the file, not who may write to it: root may write, but no other reader can open root's segment
/// for writing.
bool is_of_own_user(const Locator& port) {
  struct stat facts {};
  return ::lstat((kPortFile + std::to_string(port.port)).c_str(), &facts) == 0 && facts.st_uid == ::geteuid();
}

/// Wraps the transport of Fast DDS, but accepts only ports of the own user and announces no port.
class OneWay final : public rtps::TransportInterface {
 public:
  explicit OneWay(std::unique_ptr<rtps::TransportInterface> transport)
      : TransportInterface(LOCATOR_KIND_SHM), transport_(std::move(transport)) {}

  /// Returns false for a reader without such a locator; samples reach it by another transport.
  bool transform_remote_locator(const Locator& remote, Locator& result) const override {
    return remote.kind == LOCATOR_KIND_SHM && is_of_own_user(remote) &&
           transport_->transform_remote_locator(remote, result);
  }

  // This process announces no locators in shared memory.
  bool getDefaultMetatrafficMulticastLocators(LocatorList& /*list*/, std::uint32_t /*port*/) const override {
    return true;
  }
  bool getDefaultMetatrafficUnicastLocators(LocatorList& /*list*/, std::uint32_t /*port*/) const override {
    return true;
  }
  bool getDefaultUnicastLocators(LocatorList& /*list*/, std::uint32_t /*port*/) const override { return true; }

  bool init(const eprosima::fastrtps::rtps::PropertyPolicy* properties) override {
    return transport_->init(properties);
  }
  bool IsInputChannelOpen(const Locator& locator) const override { return transport_->IsInputChannelOpen(locator); }
  bool IsLocatorSupported(const Locator& locator) const override { return transport_->IsLocatorSupported(locator); }
  bool is_locator_allowed(const Locator& locator) const override { return transport_->is_locator_allowed(locator); }
  Locator RemoteToMainLocal(const Locator& remote) const override { return transport_->RemoteToMainLocal(remote); }
  bool OpenOutputChannel(rtps::SendResourceList& senders, const Locator& locator) override {
    return transport_->OpenOutputChannel(senders, locator);
  }
  bool OpenInputChannel(const Locator& locator, rtps::TransportReceiverInterface* receiver,
                        std::uint32_t size) override {
    return transport_->OpenInputChannel(locator, receiver, size);
  }
  bool CloseInputChannel(const Locator& locator) override { return transport_->CloseInputChannel(locator); }
  bool DoInputLocatorsMatch(const Locator& left, const Locator& right) const override {
    return transport_->DoInputLocatorsMatch(left, right);
  }
  LocatorList NormalizeLocator(const Locator& locator) override { return transport_->NormalizeLocator(locator); }
  void select_locators(eprosima::fastrtps::rtps::LocatorSelector& selector) const override {
    transport_->select_locators(selector);
  }
  bool is_local_locator(const Locator& locator) const override { return transport_->is_local_locator(locator); }
  rtps::TransportDescriptorInterface* get_configuration() override { return transport_->get_configuration(); }
  void AddDefaultOutputLocator(LocatorList& list) override { transport_->AddDefaultOutputLocator(list); }
  bool fillMetatrafficMulticastLocator(Locator& locator, std::uint32_t port) const override {
    return transport_->fillMetatrafficMulticastLocator(locator, port);
  }
  bool fillMetatrafficUnicastLocator(Locator& locator, std::uint32_t port) const override {
    return transport_->fillMetatrafficUnicastLocator(locator, port);
  }
  bool configureInitialPeerLocator(Locator& locator, const eprosima::fastrtps::rtps::PortParameters& ports,
                                   std::uint32_t domain, LocatorList& list) const override {
    return transport_->configureInitialPeerLocator(locator, ports, domain, list);
  }
  bool fillUnicastLocator(Locator& locator, std::uint32_t port) const override {
    return transport_->fillUnicastLocator(locator, port);
  }
  std::uint32_t max_recv_buffer_size() const override { return transport_->max_recv_buffer_size(); }
  void shutdown() override { transport_->shutdown(); }
  void update_network_interfaces() override { transport_->update_network_interfaces(); }

 private:
  std::unique_ptr<rtps::TransportInterface> transport_;
};

/// Derives from the Fast DDS descriptor, because a participant detects shared memory by the type of the descriptor.
struct OneWayDescriptor final : rtps::SharedMemTransportDescriptor {
  rtps::TransportInterface* create_transport() const override {
    return new OneWay(std::unique_ptr<rtps::TransportInterface>(SharedMemTransportDescriptor::create_transport()));
  }
};

}  // namespace

std::shared_ptr<rtps::TransportDescriptorInterface> shared_memory_to_own_user() {
  auto descriptor = std::make_shared<OneWayDescriptor>();
  descriptor->segment_size(kSegment);
  return descriptor;
}

}  // namespace driveline::bridge

#include "driveline/bridge/dds_error.hpp"

#include "driveline/bridge/dds_config.hpp"

namespace driveline::bridge {
namespace {

std::string listed(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) {
    text += (text.empty() ? "" : ", ") + word;
  }
  return text;
}

struct Sentence {
  std::string operator()(const DdsNameLength& error) const {
    const std::string whose = error.axis ? "axis " + std::to_string(*error.axis) : "the line";
    return "The name of " + whose + " has " + std::to_string(error.name.size()) + " bytes; DDS telemetry takes 1 to " +
           std::to_string(kMaxNameLength) + ": '" + error.name + "'.";
  }
  std::string operator()(const DdsNoAddress& error) const {
    const std::string use = error.use == DdsNoAddress::Use::kInterface ? "interface"
                            : error.use == DdsNoAddress::Use::kPeer    ? "peer"
                                                                       : "discovery server";
    return "The DDS " + use + " '" + error.address + "' is not an IPv4 address such as 192.168.1.10.";
  }
  std::string operator()(const DdsForeignInterface& error) const {
    return "The DDS interface '" + error.address +
           "' is not an address of this machine; its addresses are: " + listed(error.own) + ".";
  }
  std::string operator()(const DdsTooManyAxes& error) const {
    return "DDS telemetry counts axes with 16 bits; " + std::to_string(error.count) + " are too many.";
  }
  std::string operator()(const DdsDomainOutOfRange& error) const {
    return "DDS domain " + std::to_string(error.domain) + " is out of range 0 to " + std::to_string(error.last) + ".";
  }
  std::string operator()(const DdsNoDecimation& /*error*/) const {
    return "The telemetry decimation is 0; 1 publishes every cycle, 8 every eighth.";
  }
  std::string operator()(const DdsTopicNames& error) const {
    return "The DDS topics '" + error.axis_topic + "' and '" + error.status_topic + "' must be two different names.";
  }
  std::string operator()(const DdsCannotJoin& error) const {
    return "Cannot join DDS domain " + std::to_string(error.domain) + " on interfaces [" +
           (error.interfaces.empty() ? "all" : listed(error.interfaces)) + "]; see the message of Fast DDS on stderr.";
  }
  std::string operator()(const DdsNoPublisher& /*error*/) const { return "Fast DDS cannot create a publisher."; }
  std::string operator()(const DdsNoWriter& error) const {
    return "Cannot create a DDS writer for topic '" + error.topic + "'.";
  }
  std::string operator()(const DdsNoReader& error) const {
    return "Cannot create a DDS reader for topic '" + error.topic + "'.";
  }
  std::string operator()(const DdsBadProfiles& error) const {
    return error.file + (error.line > 0 ? ":" + std::to_string(error.line) : "") + ": " + error.reason + ".";
  }
  std::string operator()(const DdsSecureSharedMemory& /*error*/) const {
    return "Shared memory is not tested with DDS Security; remove one of them.";
  }
};

}  // namespace

std::string describe(const DdsError& error) {
  return std::visit(Sentence{}, error);
}

}  // namespace driveline::bridge

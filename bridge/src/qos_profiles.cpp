#include "qos_profiles.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <cstdint>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/log/StdoutErrConsumer.hpp>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "topic_id.hpp"

namespace driveline::bridge {
namespace {

namespace dds = eprosima::fastdds::dds;

std::mutex heard_mutex;
std::string heard_first;  // guarded by heard_mutex

class Listener final : public dds::LogConsumer {
 public:
  void Consume(const dds::Log::Entry& entry) override {
    const std::lock_guard lock{heard_mutex};
    if (heard_first.empty() && entry.kind == dds::Log::Kind::Error) heard_first = entry.message;
  }
};

/// Maximum number of stored samples per topic, over all instances: the bridge has 256 MiB for all topics.
constexpr std::int64_t kMaxKeptSamples = 1'000'000;

DdsBadProfiles bad(const DdsConfig& config, int line, std::string reason) {
  return {config.profiles.file, line, std::move(reason)};
}

std::string in_one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && (text.back() == ' ' || text.back() == '.')) text.pop_back();
  return text;
}

std::string listed_topics(const std::vector<std::string>& topics) {
  std::string text;
  for (const auto& topic : topics) text += (text.empty() ? "" : ", ") + topic;
  return text;
}

/// Error text for invalid XML, from the error name of tinyxml2.
std::string xml_error(const tinyxml2::XMLDocument& document) {
  std::string name = document.ErrorName();
  constexpr std::string_view kPrefix = "XML_ERROR_";
  if (name.starts_with(kPrefix)) name.erase(0, kPrefix.size());
  std::transform(name.begin(), name.end(), name.begin(),
                 [](char c) { return c == '_' ? ' ' : static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
  return "is no XML: " + name;
}

/// Finds <profiles>, which may be inside <dds>.
const tinyxml2::XMLElement* profiles_of(const tinyxml2::XMLDocument& document) {
  const auto* root = document.RootElement();
  if (root != nullptr && std::string_view{root->Name()} == "dds") root = root->FirstChildElement("profiles");
  return root != nullptr && std::string_view{root->Name()} == "profiles" ? root : nullptr;
}

tl::expected<std::map<std::string, int>, DdsError> lines_of(const DdsConfig& config,
                                                            const tinyxml2::XMLDocument& document) {
  const auto* const profiles = profiles_of(document);
  if (profiles == nullptr) return tl::unexpected(bad(config, 0, "has no <profiles>"));
  const auto known = all_topic_names(config);
  std::map<std::string, int> lines;
  for (const auto* each = profiles->FirstChildElement(); each != nullptr; each = each->NextSiblingElement()) {
    const int line = each->GetLineNum();
    const std::string kind = each->Name();
    if (kind != "data_writer" && kind != "publisher") {
      return tl::unexpected(
          bad(config, line, "<" + kind + "> has no effect here, <data_writer> profiles are expected"));
    }
    const char* const name = each->Attribute("profile_name");
    if (name == nullptr || std::find(known.begin(), known.end(), name) == known.end()) {
      return tl::unexpected(bad(config, line,
                                (name == nullptr ? std::string{"a profile without profile_name"}
                                                 : "there is no topic \"" + std::string{name} + "\"") +
                                    "; the name of a profile is that of its topic, one of " + listed_topics(known)));
    }
    if (!lines.emplace(name, line).second) {
      return tl::unexpected(bad(config, line, "the topic " + std::string{name} + " already has a profile"));
    }
  }
  return lines;
}

tl::expected<void, DdsError> hand_to_fast_dds(const DdsConfig& config) {
  const HeardLog heard;
  const auto& xml = config.profiles.xml;
  const auto done = dds::DomainParticipantFactory::get_instance()->load_XML_profiles_string(xml.data(), xml.size());
  const auto complaint = heard.first();
  if (done == ReturnCode_t::RETCODE_OK && complaint.empty()) return {};
  return tl::unexpected(bad(config, 0, "Fast DDS cannot parse it" + (complaint.empty() ? "" : ": " + complaint)));
}

}  // namespace

HeardLog::HeardLog() {
  const std::lock_guard lock{heard_mutex};
  heard_first.clear();
  dds::Log::ClearConsumers();
  dds::Log::RegisterConsumer(std::make_unique<Listener>());
}

HeardLog::~HeardLog() {
  dds::Log::Flush();
  log_to_stderr();
}

std::string HeardLog::first() const {
  dds::Log::Flush();
  const std::lock_guard lock{heard_mutex};
  return in_one_line(heard_first);
}

void log_to_stderr() {
  auto consumer = std::make_unique<dds::StdoutErrConsumer>();
  consumer->stderr_threshold(dds::Log::Kind::Info);
  dds::Log::ClearConsumers();
  dds::Log::RegisterConsumer(std::move(consumer));
}

tl::expected<QosProfiles, DdsError> QosProfiles::load(const DdsConfig& config) {
  QosProfiles profiles;
  if (config.profiles.xml.empty() && config.profiles.file.empty()) return profiles;
  profiles.file_ = config.profiles.file;
  tinyxml2::XMLDocument document;
  if (document.Parse(config.profiles.xml.data(), config.profiles.xml.size()) != tinyxml2::XML_SUCCESS) {
    return tl::unexpected(bad(config, document.ErrorLineNum(), xml_error(document)));
  }
  auto lines = lines_of(config, document);
  if (!lines) return tl::unexpected(std::move(lines).error());
  profiles.lines_ = *std::move(lines);
  if (profiles.lines_.empty()) return profiles;
  if (auto done = hand_to_fast_dds(config); !done) return tl::unexpected(std::move(done).error());
  return profiles;
}

tl::expected<dds::DataWriterQos, DdsError> QosProfiles::apply(dds::Publisher& publisher, const std::string& topic,
                                                              const dds::DataWriterQos& own) const {
  const auto found = lines_.find(topic);
  if (found == lines_.end()) return own;
  dds::DataWriterQos qos;
  if (publisher.get_datawriter_qos_from_profile(topic, qos) != ReturnCode_t::RETCODE_OK) {
    return tl::unexpected(DdsBadProfiles{file_, found->second, "Fast DDS did not accept the profile of " + topic});
  }
  if (qos.durability().kind > dds::TRANSIENT_LOCAL_DURABILITY_QOS) {
    return tl::unexpected(
        DdsBadProfiles{file_, found->second,
                       "the durability of " + topic + " would need files: VOLATILE or TRANSIENT_LOCAL is expected"});
  }
  // Settings that the bridge cannot change: it opens no files, and the number of instances is fixed.
  qos.data_sharing().off();
  qos.endpoint().history_memory_policy = own.endpoint().history_memory_policy;
  qos.user_data() = own.user_data();
  auto& limits = qos.resource_limits();
  limits.max_instances = own.resource_limits().max_instances;
  if (qos.history().kind == dds::KEEP_LAST_HISTORY_QOS) limits.max_samples_per_instance = qos.history().depth;
  if (limits.max_instances > 0 && limits.max_samples_per_instance > 0) {
    const auto samples = std::int64_t{limits.max_instances} * limits.max_samples_per_instance;
    if (samples > kMaxKeptSamples) {
      return tl::unexpected(DdsBadProfiles{file_, found->second,
                                           topic + " would keep " + std::to_string(samples) + " samples, " +
                                               std::to_string(kMaxKeptSamples) + " at most are possible"});
    }
    limits.max_samples = static_cast<std::int32_t>(samples);
  }
  limits.allocated_samples = 1;
  return qos;
}

DdsError QosProfiles::blame(const std::string& topic, const std::string& reason, DdsError otherwise) const {
  const auto found = lines_.find(topic);
  if (found == lines_.end()) return otherwise;
  return DdsBadProfiles{
      file_, found->second,
      "Fast DDS cannot create a writer of " + topic + " with this profile" + (reason.empty() ? "" : ": " + reason)};
}

}  // namespace driveline::bridge

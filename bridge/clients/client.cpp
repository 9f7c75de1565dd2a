#include "client.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "text.hpp"

namespace driveline::bridge::clients {
namespace {

/// Last part of a topic name: "event" for "driveline/v1/event".
std::string_view short_name(std::string_view topic) {
  return topic.substr(topic.rfind('/') + 1);
}

}  // namespace

Clock::time_point after(double seconds) {
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

Outcome<std::vector<const Topic*>> select_topics(const std::vector<std::string>& names) {
  std::vector<const Topic*> chosen;
  for (const auto& name : names) {
    const Topic* found = find_topic(name);
    std::string known;
    for (const auto& topic : topics()) {
      if (found == nullptr && short_name(topic.name) == name) found = &topic;
      known += (known.empty() ? "" : ", ") + std::string(topic.name);
    }
    if (found == nullptr) return misused(fmt::format("there is no topic \"{}\"; there are {}", name, known));
    if (std::find(chosen.begin(), chosen.end(), found) == chosen.end()) chosen.push_back(found);
  }
  return chosen;
}

void OmittedSamples::add(std::string_view topic, std::string_view reason) {
  if (count_++ > 0) return;
  fmt::print(stderr, "driveline {}: {}: a sample is skipped: {}\n", command_, topic, visible(reason));
}

OmittedSamples::~OmittedSamples() {
  if (count_ > 1) fmt::print(stderr, "driveline {}: {} samples were skipped\n", command_, count_);
}

Outcome<void> print(std::string_view text) {
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (written && std::fflush(stdout) == 0) return {};
  return failed(fmt::format("the output cannot be written: {}", std::strerror(errno)));
}

}  // namespace driveline::bridge::clients

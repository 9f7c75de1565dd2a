#include <fmt/format.h>

#include <algorithm>

#include "client.hpp"
#include "driveline/rt/stop_signals.hpp"
#include "gaps.hpp"
#include "recording.hpp"
#include "subscription.hpp"
#include "text.hpp"

namespace driveline::bridge::clients {
namespace {

/// Longest time of samples that a power failure or a kill loses.
constexpr std::chrono::seconds kFlushPeriod{1};

/// All topics; on a secured line without the topics of commands, which not every reader may read.
std::vector<const Topic*> all_topics(bool secured) {
  std::vector<const Topic*> all;
  for (const auto& topic : topics()) {
    if (!secured || !topic.type.starts_with("driveline::commands::")) all.push_back(&topic);
  }
  return all;
}

/// Writes samples to a file, and counts them.
class Recorder {
 public:
  Recorder(const Options& options, std::vector<const Topic*> chosen, Subscription subscription,
           std::unique_ptr<Recording> recording)
      : options_(options),
        topics_(std::move(chosen)),
        subscription_(std::move(subscription)),
        recording_(std::move(recording)) {
    for (const auto* topic : topics_) gaps_.emplace_back(*topic);
  }

  Outcome<int> run() {
    const auto patience_s = options_.timeout_s.value_or(kDefaultTimeoutSeconds);
    const auto patience = after(patience_s);
    while (!rt::stop_requested() && outcome_ && !over()) {
      subscription_.take(kWait, [this](const Sample& sample) { add(sample); });
      if (samples_ == 0 && Clock::now() > patience) {
        recording_->remove();
        return failed(
            fmt::format("no line publishes in {}: no sample arrived for {} s", options_.place.text(), patience_s));
      }
      flush_now_and_then();
    }
    return finish();
  }

 private:
  void add(const Sample& sample) {
    if (!outcome_ || over()) return;
    if (samples_++ == 0) {
      if (options_.duration_s) end_ = after(*options_.duration_s);
      outcome_ = recording_->take_place();
      if (!outcome_) return;
    }
    outcome_ = recording_->add(sample);
    if (!outcome_) return;
    for (std::size_t i = 0; i < topics_.size(); ++i) {
      if (topics_[i] == sample.topic) gaps_[i].add(sample.bytes);
    }
  }

  [[nodiscard]] bool over() const { return Clock::now() >= end_; }

  void flush_now_and_then() {
    if (!outcome_ || Clock::now() < flushed_ + kFlushPeriod) return;
    flushed_ = Clock::now();
    outcome_ = recording_->flush();
  }

  Outcome<int> finish() {
    if (samples_ == 0) {
      recording_->remove();
      return failed("ended before a sample arrived; no recording was written");
    }
    const auto finished = recording_->finish();
    if (outcome_) outcome_ = finished;
    // Print the summary even if recording failed.
    if (auto told = print(options_.json ? json() : table()); !told) return tl::unexpected(told.error());
    if (outcome_) return 0;
    return failed(fmt::format("{}; the file has the samples recorded before", outcome_.error().text));
  }

  [[nodiscard]] std::string missing_text(std::size_t i, std::string_view unknown) const {
    return gaps_[i].counted() ? fmt::format("{}", gaps_[i].missing()) : std::string(unknown);
  }

  [[nodiscard]] std::string table() const {
    std::size_t width = 0;
    for (const auto* topic : topics_) width = std::max(width, topic->name.size());
    auto text = fmt::format("{}: {} bytes\n{:<{}}{:>10}{:>10}\n", visible(options_.output), recording_->size(), "topic",
                            width, "samples", "missing");
    for (std::size_t i = 0; i < topics_.size(); ++i) {
      text +=
          fmt::format("{:<{}}{:>10}{:>10}\n", topics_[i]->name, width, recording_->written()[i], missing_text(i, "-"));
    }
    return text;
  }

  [[nodiscard]] std::string json() const {
    auto text =
        fmt::format("{{\"file\":{},\"bytes\":{},\"topics\":[", json_string(options_.output), recording_->size());
    for (std::size_t i = 0; i < topics_.size(); ++i) {
      text += fmt::format("{}{{\"name\":{},\"samples\":{},\"missing\":{}}}", i == 0 ? "" : ",",
                          json_string(topics_[i]->name), recording_->written()[i], missing_text(i, "null"));
    }
    return text + "]}\n";
  }

  const Options& options_;
  std::vector<const Topic*> topics_;
  std::vector<Gaps> gaps_;
  Subscription subscription_;
  std::unique_ptr<Recording> recording_;
  std::uint64_t samples_ = 0;
  Clock::time_point end_ = Clock::time_point::max();
  Clock::time_point flushed_ = Clock::now();
  Outcome<void> outcome_;
};

}  // namespace

Outcome<int> record(const Options& options) {
  if (options.output.empty()) return misused("--output names the file");
  const auto chosen =
      options.topics.empty() ? all_topics(!options.place.security.empty()) : select_topics(options.topics);
  if (!chosen) return tl::unexpected(chosen.error());
  auto subscription = Subscription::create(options.place, *chosen);
  if (!subscription) return tl::unexpected(subscription.error());
  auto recording = create_recording(options.output, options.force, *chosen);
  if (!recording) return tl::unexpected(recording.error());
  return Recorder(options, *chosen, std::move(*subscription), std::move(*recording)).run();
}

}  // namespace driveline::bridge::clients

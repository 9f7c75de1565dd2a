#include <fmt/format.h>

#include "client.hpp"
#include "driveline/rt/stop_signals.hpp"
#include "subscription.hpp"
#include "text.hpp"

namespace driveline::bridge::clients {
namespace {

/// Prints samples until the requested number is reached.
class Echo {
 public:
  explicit Echo(const Options& options) : options_(options) {}

  void sample(const Sample& sample) {
    if (done()) return;
    const auto value = decode(*sample.topic->structure, sample.bytes);
    if (!value) {
      omitted_.add(sample.topic->name, describe(value.error()));
      return;
    }
    outcome_ = print(options_.json ? json_text(*value) + '\n' : yaml_text(*value) + "---\n");
    ++printed_;
  }

  [[nodiscard]] bool done() const { return !outcome_ || (options_.count && printed_ >= *options_.count); }
  [[nodiscard]] const Outcome<void>& outcome() const { return outcome_; }
  [[nodiscard]] std::uint64_t printed() const { return printed_; }

 private:
  const Options& options_;
  std::uint64_t printed_ = 0;
  OmittedSamples omitted_{"echo"};
  Outcome<void> outcome_;
};

}  // namespace

Outcome<int> echo(const Options& options) {
  if (options.argument.empty()) return misused("a topic is expected: echo TOPIC");
  const auto chosen = select_topics({options.argument});
  if (!chosen) return tl::unexpected(chosen.error());
  auto subscription = Subscription::create(options.place, *chosen);
  if (!subscription) return tl::unexpected(subscription.error());
  Echo printer(options);
  const auto limit = [&] { return options.timeout_s ? after(*options.timeout_s) : Clock::time_point::max(); };
  auto patience = limit();
  while (!rt::stop_requested() && !printer.done()) {
    if (subscription->take(kWait, [&](const Sample& sample) { printer.sample(sample); }) > 0) {
      patience = limit();
    } else if (Clock::now() > patience) {
      if (printer.printed() > 0 && !options.count) break;
      return failed(fmt::format("{}: no sample arrived for {} s in {}", chosen->front()->name, *options.timeout_s,
                                options.place.text()));
    }
  }
  if (!printer.outcome()) return tl::unexpected(printer.outcome().error());
  return 0;
}

}  // namespace driveline::bridge::clients

#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "options.hpp"
#include "schema.hpp"
#include "value.hpp"

namespace driveline::bridge::clients {

/// A sample as received: not decoded, not converted.
struct Sample {
  const Topic* topic;
  Bytes bytes;                ///< CDR with its encapsulation header
  std::int64_t received_ns;   ///< time of reception in ns since 1970-01-01 UTC
  std::int64_t published_ns;  ///< time of publication in ns since 1970-01-01 UTC, by the writer's clock
};

/// Readers of topics. They treat all types as bytes, so samples arrive as the writer has serialised them.
class Subscription {
 public:
  /// Joins the domain. From here on the readers of `chosen` find their writers.
  [[nodiscard]] static Outcome<Subscription> create(const Place& place, std::span<const Topic* const> chosen);
  ~Subscription();
  /// Takes over the readers.
  Subscription(Subscription&& other) noexcept;
  Subscription& operator=(Subscription&&) = delete;

  /// Waits for samples, up to `limit`, and passes all available ones to `take`, in the order of their arrival. The
  /// bytes are invalid after `take` returns. Returns the number of samples.
  std::size_t take(std::chrono::milliseconds limit, const std::function<void(const Sample&)>& take);
  /// Number of writers of this topic at present.
  [[nodiscard]] int writers(const Topic& topic) const;

 private:
  struct Entities;
  explicit Subscription(std::unique_ptr<Entities> entities);
  std::unique_ptr<Entities> entities_;
};

}  // namespace driveline::bridge::clients

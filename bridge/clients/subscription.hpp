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

/// A sample as it came: nothing decoded, nothing converted.
struct Sample {
  const Topic* topic;
  Bytes bytes;                ///< CDR with its encapsulation header
  std::int64_t received_ns;   ///< since 1970-01-01 UTC
  std::int64_t published_ns;  ///< likewise, by the clock of the writer
};

/// Readers of topics. They know no type but bytes: what the writer has serialised is what arrives here.
class Subscription {
 public:
  /// Joins the domain. The readers of `chosen` find their writers from here on.
  [[nodiscard]] static Outcome<Subscription> create(const Place& place, std::span<const Topic* const> chosen);
  ~Subscription();
  /// Takes the readers over.
  Subscription(Subscription&& other) noexcept;
  Subscription& operator=(Subscription&&) = delete;

  /// Waits for samples, up to `limit`, and hands out all that are there, in the order of their arrival.
  /// The bytes are gone when `take` returns. How many there were.
  std::size_t take(std::chrono::milliseconds limit, const std::function<void(const Sample&)>& take);
  /// Writers of this topic that are there now.
  [[nodiscard]] int writers(const Topic& topic) const;

 private:
  struct Entities;
  explicit Subscription(std::unique_ptr<Entities> entities);
  std::unique_ptr<Entities> entities_;
};

}  // namespace driveline::bridge::clients

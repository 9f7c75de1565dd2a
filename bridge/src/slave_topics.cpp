#include "slave_topics.hpp"

#include <algorithm>
#include <cstring>

#include "idl_types.hpp"

namespace driveline::bridge {

bool differ(snapshot::FeedSlave before, snapshot::FeedSlave now) noexcept {
  before.read_at_ns = now.read_at_ns = 0;
  // Texts can be compared to the last byte, because they are padded with zeros.
  return std::memcmp(&before, &now, sizeof(now)) != 0;
}

void SlaveTopics::set(const snapshot::FeedCondition& condition, Time now) {
  newest_ = condition.slaves;
  for (std::size_t i = 0; i < newest_.size(); ++i) {
    if (i >= published_.size() || differ(published_[i].slave, newest_[i])) {
      publish(i, newest_[i], now);
    }
  }
  auto topology = topology_message(condition);
  if (!topology_ || *topology_ != topology) {
    topology_ = topology;
    entities_.write(TopicId::kTopology, &topology);
  }
}

void SlaveTopics::repeat(Time now) {
  for (std::size_t i = 0; i < newest_.size(); ++i) {
    if (now - published_[i].at >= period_) {
      publish(i, newest_[i], now);
    }
  }
}

void SlaveTopics::publish(std::size_t position, const snapshot::FeedSlave& slave, Time now) {
  published_.resize(std::max(published_.size(), position + 1));
  published_[position] = {slave, now};
  auto message = slave_message(slave, position);
  entities_.write(TopicId::kSlave, &message);
}

}  // namespace driveline::bridge

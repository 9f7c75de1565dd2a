#include "driveline/ecat_master/eoe/eoe_port.hpp"

#include <algorithm>

namespace driveline::ecat_master {

using wire::EoeHeader;
using wire::EoeType;

EoePort::EoePort(std::uint16_t position, EoeReceiver& receiver) : position_(position), receiver_(receiver) {}

bool EoePort::send(std::span<const std::byte> frame) noexcept {
  if (!up() || frame.size() < wire::kMinEoeFrame || frame.size() > wire::kMaxEoeFrame) {
    counters_.refused.add();
    return false;
  }
  EoeFrame copy;
  copy.size = static_cast<std::uint16_t>(frame.size());
  std::copy(frame.begin(), frame.end(), copy.bytes.begin());
  return queue_.try_push(copy);
}

void EoePort::opened(std::size_t room) {
  drop_all();
  openings_.add();
  open_.store(wire::EoeFragmenter::fragment_size(room) != 0, std::memory_order_relaxed);
}

void EoePort::closed() {
  open_.store(false, std::memory_order_relaxed);
  drop_all();
}

/// Drops all queued and partial frames in both directions.
void EoePort::drop_all() noexcept {
  forget();
  while (queue_.try_pop(sending_)) counters_.given_up.add();
  assembler_.reset();
}

void EoePort::given_up() {
  forget();
}

/// Drops the frames with unsent or untaken fragments.
void EoePort::forget() noexcept {
  const auto open = std::span(open_mails_).first(open_count_);
  counters_.given_up.add(
      static_cast<std::uint64_t>(std::count_if(open.begin(), open.end(), [](auto one) { return one != 0; })));
  if (!fragmenter_.done()) counters_.given_up.add();
  fragmenter_.abandon();
  open_count_ = 0;
}

void EoePort::taken() {
  if (open_count_ == 0) return;
  if (const auto size = open_mails_.front(); size != 0) {
    counters_.frames_out.add();
    counters_.bytes_out.add(size);
  }
  std::copy(open_mails_.begin() + 1, open_mails_.end(), open_mails_.begin());
  --open_count_;
}

std::size_t EoePort::next(std::span<std::byte> out) {
  if (!up()) {
    drop_all();
    return 0;
  }
  if (open_count_ == open_mails_.size()) return 0;
  if (fragmenter_.done()) {
    if (!queue_.try_pop(sending_)) return 0;
    if (!fragmenter_.begin(std::span<const std::byte>(sending_.bytes).first(sending_.size))) return 0;
  }
  const auto length = fragmenter_.next(out);
  if (length == 0) return 0;
  counters_.fragments_out.add();
  open_mails_.at(open_count_++) = fragmenter_.done() ? sending_.size : std::uint16_t{0};
  return length;
}

void EoePort::receive(std::span<const std::byte> service) noexcept {
  const auto header = EoeHeader::decode(service);
  if (!header) {
    counters_.malformed.add();
    return;
  }
  if (header->type != EoeType::kFragment) {
    counters_.stray.add();
    return;
  }
  const auto before = assembler_.seen();
  const auto frame = assembler_.take(*header, service.subspan(EoeHeader::kSize));
  const auto& seen = assembler_.seen();
  counters_.fragments_in.add();
  counters_.lost.add(seen.lost - before.lost);
  counters_.malformed.add(seen.malformed - before.malformed);
  counters_.stray.add(seen.stray - before.stray);
  if (!frame || !up()) return;
  counters_.frames_in.add();
  counters_.bytes_in.add(frame->size());
  receiver_.receive(position_, *frame);
}

EoePortStatistics EoePort::statistics() const noexcept {
  return {.frames_out = counters_.frames_out.value(),
          .frames_in = counters_.frames_in.value(),
          .bytes_out = counters_.bytes_out.value(),
          .bytes_in = counters_.bytes_in.value(),
          .fragments_out = counters_.fragments_out.value(),
          .fragments_in = counters_.fragments_in.value(),
          .full = queue_.dropped(),
          .refused = counters_.refused.value(),
          .given_up = counters_.given_up.value(),
          .lost = counters_.lost.value(),
          .malformed = counters_.malformed.value(),
          .stray = counters_.stray.value()};
}

}  // namespace driveline::ecat_master

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

/// Nothing of what was on its way is left, on either way.
void EoePort::drop_all() noexcept {
  given_up();
  while (queue_.try_pop(sending_)) counters_.given_up.add();
  assembler_.reset();
}

void EoePort::given_up() {
  if (!in_hand_) return;
  fragmenter_.abandon();
  in_hand_ = false;
  counters_.given_up.add();
}

/// The last fragment that was pulled has been taken when the next one is asked for.
void EoePort::note_taken() noexcept {
  if (!in_hand_ || !fragmenter_.done()) return;
  in_hand_ = false;
  counters_.frames_out.add();
  counters_.bytes_out.add(sending_.size);
}

std::size_t EoePort::next(std::span<std::byte> out) {
  note_taken();
  if (!up()) {
    drop_all();
    return 0;
  }
  if (!in_hand_) {
    if (!queue_.try_pop(sending_)) return 0;
    in_hand_ = fragmenter_.begin(std::span<const std::byte>(sending_.bytes).first(sending_.size));
  }
  const auto length = fragmenter_.next(out);
  if (length != 0) counters_.fragments_out.add();
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

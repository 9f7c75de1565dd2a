#include "driveline/ecat_master/process_data/process_image.hpp"

#include <algorithm>
#include <numeric>

#include "driveline/ecat_master/dc/drift_datagram.hpp"
#include "driveline/wire/registers.hpp"
#include "driveline/wire/wire_time.hpp"

namespace driveline::ecat_master {
namespace {

constexpr std::size_t kNone = ProcessDataPlace::kNone;
/// Bytes of datagrams that fit into a frame.
constexpr std::size_t kFrameBytes = wire::kMaxPayloadBytes - wire::EtherCatHeader::kSize;

wire::FmmuEntity make_fmmu(std::size_t offset, std::size_t bytes, std::uint16_t physical, std::uint8_t type) {
  wire::FmmuEntity fmmu;
  fmmu.logical_start = ProcessImage::logical_address(offset);
  fmmu.length = static_cast<std::uint16_t>(bytes);
  fmmu.physical_start = physical;
  fmmu.type = type;
  fmmu.active = true;
  return fmmu;
}

bool touches(const wire::FmmuEntity& fmmu, std::uint32_t start, std::size_t bytes) noexcept {
  return fmmu.active && fmmu.length > 0 && fmmu.logical_start < start + bytes &&
         start < std::uint64_t{fmmu.logical_start} + fmmu.length;
}

}  // namespace

std::size_t ProcessDataDemand::bytes(bool output) const noexcept {
  return std::accumulate(
      channels.begin(), channels.end(), std::size_t{0},
      [output](std::size_t sum, const ProcessDataChannel& c) { return c.output == output ? sum + c.bytes : sum; });
}

/// Builds the image slave by slave.
class ProcessImage::Builder {
 public:
  Builder(ProcessImage& image, std::span<const ProcessDataDemand> demands, const LayoutSettings& settings)
      : image_(image), demands_(demands), settings_(settings) {
    image_.places_.resize(demands.size());
    image_.fmmus_.resize(demands.size());
    std::size_t groups = settings.groups.size();
    for (const auto& demand : demands) groups = std::max(groups, demand.group + 1);
    image_.groups_ = settings.groups;
    image_.groups_.resize(groups);
    for (auto& group : image_.groups_) {
      group.divider = std::max<std::uint32_t>(group.divider, 1);
      group.phase %= group.divider;
    }
  }

  Result<void> build() {
    for (std::size_t i = 0; i < demands_.size(); ++i) {
      if (auto done = choose_status_bytes(i); !done) return done;
    }
    for (std::size_t group = 0; group < image_.groups_.size(); ++group) {
      if (auto done = place_group(group); !done) return done;
    }
    for (std::size_t i = 0; i < demands_.size(); ++i) make_fmmus(i);
    pack_frames();
    derive_working_counters();
    image_.outputs_.resize(end_);
    image_.inputs_.resize(end_);
    return {};
  }

 private:
  [[nodiscard]] bool separate(std::size_t slave) const noexcept {
    return settings_.layout == ImageLayout::kSeparate || !demands_[slave].lrw;
  }
  [[nodiscard]] std::size_t status_bytes(std::size_t slave) const noexcept {
    const auto& place = image_.places_[slave];
    return (place.al_status_offset != kNone ? 1U : 0U) + (place.mailbox_offset != kNone ? 1U : 0U);
  }

  /// Process data come first; status bytes get the remaining FMMUs, the AL status before the mailbox. Slaves without
  /// process data get none: the broadcast supervises them.
  Result<void> choose_status_bytes(std::size_t slave) {
    const auto& demand = demands_[slave];
    auto& place = image_.places_[slave];
    const auto needed = static_cast<std::size_t>(
        std::count_if(demand.channels.begin(), demand.channels.end(), [](const auto& c) { return c.bytes > 0; }));
    if (needed > demand.fmmus) {
      return tl::unexpected(Error{facts::TooFewFmmus{.needed = static_cast<std::uint32_t>(needed),
                                                     .present = static_cast<std::uint32_t>(demand.fmmus)},
                                  static_cast<std::uint16_t>(slave)});
    }
    std::size_t left = needed == 0 ? 0 : demand.fmmus - needed;
    if (demand.al_status && left > 0) {
      place.al_status_offset = 0;
      --left;
    }
    if (demand.mailbox_status != 0 && left > 0) place.mailbox_offset = 0;
    return {};
  }

  Result<void> place_group(std::size_t group) {
    for (const auto& [command, wanted] : {std::pair{wire::Command::kLrw, false}, std::pair{wire::Command::kLwr, true},
                                          std::pair{wire::Command::kLrd, true}}) {
      bool open = false;  // the last datagram has this command and group
      for (std::size_t slave = 0; slave < demands_.size(); ++slave) {
        if (demands_[slave].group != group || separate(slave) != wanted) continue;
        if (auto done = place_slave(slave, command, open); !done) return done;
      }
    }
    return {};
  }

  Result<void> place_slave(std::size_t slave, wire::Command command, bool& open) {
    const auto& demand = demands_[slave];
    auto& place = image_.places_[slave];
    const bool write = command != wire::Command::kLrd;
    const bool read = command != wire::Command::kLwr;
    const std::size_t out = write ? demand.output_bytes() : 0;
    const std::size_t in = read ? demand.input_bytes() : 0;
    const std::size_t status = read ? status_bytes(slave) : 0;
    const bool overlapped = settings_.layout == ImageLayout::kOverlapped;
    const std::size_t data = overlapped ? std::max(out, in) : out + in;
    place.group = demand.group;
    place.divider = image_.groups_[demand.group].divider;
    if (data + status == 0) return {};
    if (data + status > kMaxDatagramBytes)
      return tl::unexpected(
          Error{facts::ProcessDataSize{.bytes = static_cast<std::uint32_t>(data + status), .limit = kMaxDatagramBytes},
                static_cast<std::uint16_t>(slave)});
    if (!open || image_.datagrams_.back().bytes + data + status > kMaxDatagramBytes) {
      image_.datagrams_.push_back({command, demand.group, 0, end_, 0, 0});
      open = true;
    }
    const std::size_t number = image_.datagrams_.size() - 1;
    if (write) place.output_bytes = out;
    if (read) place.input_bytes = in;
    if (out > 0) {
      place.output_offset = end_;
      place.output_datagram = number;
    }
    if (in + status > 0) {
      place.input_offset = overlapped ? end_ : end_ + out;
      place.input_datagram = number;
      // Place status bytes behind both, so that outputs do not overlap them: those of a missing slave stay zero.
      std::size_t at = end_ + data;
      if (place.al_status_offset != kNone) place.al_status_offset = at++;
      if (place.mailbox_offset != kNone) place.mailbox_offset = at;
    }
    image_.datagrams_.back().bytes += data + status;
    end_ += data + status;
    return {};
  }

  void make_fmmus(std::size_t slave) {
    using esi::FmmuUse;
    const auto& demand = demands_[slave];
    const auto& place = image_.places_[slave];
    std::size_t output = place.output_offset;
    std::size_t input = place.input_offset;
    for (const auto& channel : demand.channels) {
      if (channel.bytes == 0) continue;
      auto& at = channel.output ? output : input;
      put_fmmu(slave, channel.output ? FmmuUse::kOutputs : FmmuUse::kInputs,
               make_fmmu(at, channel.bytes, channel.physical_start,
                         channel.output ? wire::FmmuEntity::kTypeWrite : wire::FmmuEntity::kTypeRead));
      at += channel.bytes;
    }
    if (place.al_status_offset != kNone) {
      put_fmmu(slave, FmmuUse::kUnused,
               make_fmmu(place.al_status_offset, 1, wire::reg::kAlStatus.address, wire::FmmuEntity::kTypeRead));
    }
    if (place.mailbox_offset != kNone) {
      put_fmmu(slave, FmmuUse::kMailboxState,
               make_fmmu(place.mailbox_offset, 1, demand.mailbox_status, wire::FmmuEntity::kTypeRead));
    }
  }

  /// There are enough FMMUs: choose_status_bytes() has counted them.
  void put_fmmu(std::size_t slave, esi::FmmuUse use, const wire::FmmuEntity& fmmu) {
    const auto& demand = demands_[slave];
    auto& fmmus = image_.fmmus_[slave];
    const auto meant_for = [&](std::size_t n) {
      return n < demand.fmmu_uses.size() ? demand.fmmu_uses[n] : esi::FmmuUse::kUnused;
    };
    const auto find = [&](auto fits) {
      std::size_t n = 0;
      while (n < demand.fmmus && ((n < fmmus.size() && fmmus[n].active) || !fits(n))) ++n;
      return n;
    };
    auto number = find([&](std::size_t n) { return meant_for(n) == use; });
    if (number == demand.fmmus) number = find([&](std::size_t n) { return meant_for(n) == esi::FmmuUse::kUnused; });
    if (number == demand.fmmus) number = find([](std::size_t) { return true; });
    if (number >= fmmus.size()) fmmus.resize(number + 1);
    fmmus[number] = fmmu;
  }

  /// Datagrams of a group share frames; groups do not, because they are not always sent together. The first frame is
  /// sent in every cycle, since it carries the AL status broadcast: a group that pauses does not travel in it.
  void pack_frames() {
    auto& datagrams = image_.datagrams_;
    image_.frame_count_ = 1;
    const bool shares_first = !datagrams.empty() && image_.groups_[datagrams[0].group].divider == 1;
    std::size_t room = shares_first ? kFrameBytes - kReservedBytes : 0;
    std::size_t group = datagrams.empty() ? 0 : datagrams[0].group;
    for (auto& datagram : datagrams) {
      const std::size_t bytes = datagram.bytes + wire::DatagramHeader::kOverhead;
      if (datagram.group != group || bytes > room) {
        room = kFrameBytes;
        ++image_.frame_count_;
      }
      group = datagram.group;
      room -= bytes;
      datagram.frame = image_.frame_count_ - 1;
    }
  }

  void derive_working_counters() {
    for (std::size_t i = 0; i < image_.datagrams_.size(); ++i) {
      auto& datagram = image_.datagrams_[i];
      for (std::size_t slave = 0; slave < demands_.size(); ++slave) {
        const auto count = working_counter_share(image_.fmmus_[slave], datagram.command,
                                                 logical_address(datagram.offset), datagram.bytes);
        if (count == 0) continue;
        image_.shares_.push_back({i, slave, count});
        datagram.expected_working_counter = static_cast<std::uint16_t>(datagram.expected_working_counter + count);
      }
    }
  }

  ProcessImage& image_;
  std::span<const ProcessDataDemand> demands_;
  const LayoutSettings& settings_;
  std::size_t end_ = 0;
};

Result<ProcessImage> ProcessImage::lay_out(std::span<const ProcessDataDemand> demands, const LayoutSettings& settings) {
  ProcessImage image;
  if (auto done = Builder(image, demands, settings).build(); !done) return tl::unexpected(done.error());
  return image;
}

std::uint16_t working_counter_share(std::span<const wire::FmmuEntity> fmmus, wire::Command command,
                                    std::uint32_t logical_start, std::size_t bytes) noexcept {
  bool read = false;
  bool write = false;
  for (const auto& fmmu : fmmus) {
    if (!touches(fmmu, logical_start, bytes)) continue;
    read |= (fmmu.type & wire::FmmuEntity::kTypeRead) != 0;
    write |= (fmmu.type & wire::FmmuEntity::kTypeWrite) != 0;
  }
  const unsigned reads = read && command != wire::Command::kLwr ? 1 : 0;
  const unsigned writes = write && command != wire::Command::kLrd ? 1 : 0;
  return static_cast<std::uint16_t>(reads + (command == wire::Command::kLrw ? 2 * writes : writes));
}

std::uint64_t wire_time_ns(const ProcessImage& image, bool clocks) {
  // The first frame carries the broadcast read of the AL status, even without process data.
  std::vector<std::uint64_t> frames(std::max<std::size_t>(1, image.frame_count()), wire::kDatagramsOffset);
  std::vector<ExchangeGroupSettings> due(frames.size());
  frames[0] += wire::DatagramHeader::kOverhead + 2;
  if (clocks) frames[0] += wire::DatagramHeader::kOverhead + dc::DriftDatagram::kBytes;
  for (const auto& datagram : image.datagrams()) {
    frames[datagram.frame] += wire::DatagramHeader::kOverhead + datagram.bytes;
    due[datagram.frame] = image.groups()[datagram.group];
  }
  // Dividers and phases repeat after their least common multiple; for longer patterns assume that all groups meet.
  constexpr std::uint64_t kMaxPattern = 10'000;
  std::uint64_t pattern = 1;
  for (const auto& group : due) pattern = std::min(std::lcm(pattern, group.divider), kMaxPattern + 1);
  const bool all_meet = pattern > kMaxPattern;
  std::uint64_t busiest = 0;
  for (std::uint64_t cycle = 0; cycle < (all_meet ? 1 : pattern); ++cycle) {
    std::uint64_t bytes = 0;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (!all_meet && !due[i].due(cycle)) continue;
      bytes += std::max<std::uint64_t>(frames[i], wire::kMinFrameBytes) + wire::kPreambleFcsGap;
    }
    busiest = std::max(busiest, bytes);
  }
  return busiest * wire::kNsPerByte;
}

void ProcessImage::relocate(std::size_t slave, std::span<const ProcessDataChannel> from,
                            std::span<const ProcessDataChannel> to) {
  for (auto& fmmu : fmmus_[slave]) {
    for (std::size_t i = 0; i < from.size(); ++i) {
      if (fmmu.physical_start != from[i].physical_start) continue;
      fmmu.physical_start = to[i].physical_start;
      break;
    }
  }
}

}  // namespace driveline::ecat_master

// Datagram commands (ETG.1000.4 5.4): addressing, data transfer, working counter.
#include <algorithm>
#include <array>
#include <cstring>

#include "driveline/slaves/bit_copy.hpp"
#include "driveline/slaves/esc/esc.hpp"
#include "driveline/wire/datagram.hpp"

namespace driveline::slaves {

using wire::Command;

namespace {

/// Working counter increments of a successful read and write (ETG.1000.4 5.4.1.2); a write-only command adds one, the
/// write half of a read-write command adds two.
constexpr std::uint16_t kRead = 1;
constexpr std::uint16_t kWrite = 1;
constexpr std::uint16_t kWriteOfReadWrite = 2;

/// Maximum data length of a datagram.
constexpr std::size_t kMaxData = wire::DatagramHeader::kMaxLength;

void count(Datagram& datagram, bool success, std::uint16_t increment) noexcept {
  if (success) datagram.working_counter = static_cast<std::uint16_t>(datagram.working_counter + increment);
}

void merge_or(std::span<const std::byte> from, std::span<std::byte> into) noexcept {
  for (std::size_t i = 0; i < from.size(); ++i) into[i] |= from[i];
}

}  // namespace

void Esc::process(Datagram& datagram, Nanoseconds now) noexcept {
  datagram.irq |= events_.irq();
  switch (datagram.command) {
    case Command::kFprd:
    case Command::kFpwr:
    case Command::kFprw:
      if (at_station(datagram.adp)) process_addressed(datagram, now);
      return;
    case Command::kAprd:
    case Command::kApwr:
    case Command::kAprw: {
      const bool addressed = datagram.adp++ == 0;
      if (addressed) process_addressed(datagram, now);
      return;
    }
    case Command::kBrd:
    case Command::kBwr:
    case Command::kBrw:
      ++datagram.adp;
      return process_broadcast(datagram, now);
    case Command::kLrw:
      if (!options_.logical_read_write) return;
      [[fallthrough]];
    case Command::kLrd:
    case Command::kLwr:
      if (fmmus_.touches(datagram.logical_address(), datagram.data.size())) process_logical(datagram, now);
      return;
    case Command::kArmw: {
      const bool addressed = datagram.adp++ == 0;
      return addressed ? read_into(datagram, now) : write_from(datagram, now);
    }
    case Command::kFrmw:
      return at_station(datagram.adp) ? read_into(datagram, now) : write_from(datagram, now);
    case Command::kNop:
      return;
  }
}

void Esc::process_addressed(Datagram& datagram, Nanoseconds now) noexcept {
  switch (datagram.command) {
    case Command::kAprd:
    case Command::kFprd:
      return read_into(datagram, now);
    case Command::kApwr:
    case Command::kFpwr:
      return write_from(datagram, now);
    default:
      return exchange(datagram, false, now);
  }
}

void Esc::process_broadcast(Datagram& datagram, Nanoseconds now) noexcept {
  if (datagram.command == Command::kBwr) return write_from(datagram, now);
  if (datagram.command == Command::kBrw) return exchange(datagram, true, now);
  std::array<std::byte, kMaxData> own;
  const auto read = std::span(own).first(std::min(datagram.data.size(), own.size()));
  std::fill(read.begin(), read.end(), std::byte{0});
  count(datagram, ecat_read(datagram.ado, read, now), kRead);
  merge_or(read, datagram.data);
}

void Esc::read_into(Datagram& datagram, Nanoseconds now) noexcept {
  count(datagram, ecat_read(datagram.ado, datagram.data, now), kRead);
}

void Esc::write_from(Datagram& datagram, Nanoseconds now) noexcept {
  count(datagram, ecat_write(datagram.ado, datagram.data, now), kWrite);
}

void Esc::exchange(Datagram& datagram, bool merge, Nanoseconds now) noexcept {
  std::array<std::byte, kMaxData> own;
  const auto read = std::span(own).first(std::min(datagram.data.size(), own.size()));
  if (merge) {
    std::fill(read.begin(), read.end(), std::byte{0});
  } else {
    std::copy_n(datagram.data.begin(), read.size(), read.begin());
  }
  const bool was_read = ecat_read(datagram.ado, read, now);
  const std::size_t target = std::size_t{datagram.ado} + memory_.get(wire::reg::kPhysicalOffset);
  const bool was_written = ecat_write(target, datagram.data, now);
  if (merge) {
    merge_or(read, datagram.data);
  } else {
    std::copy(read.begin(), read.end(), datagram.data.begin());
  }
  count(datagram, was_read, kRead);
  count(datagram, was_written, kWriteOfReadWrite);
}

void Esc::process_logical(Datagram& datagram, Nanoseconds now) noexcept {
  const bool reads = datagram.command != Command::kLwr;
  const bool writes = datagram.command != Command::kLrd;
  const auto logical = datagram.logical_address();
  std::span<const std::byte> outputs = datagram.data;
  std::array<std::byte, kMaxData> incoming;
  // A write stores the frame's data; a read returns the memory before the write. Writing first gives the same result
  // unless a physical bit is mapped in both directions; in that case the frame's data are saved and reading comes
  // first.
  const bool read_first = reads && writes && fmmus_.exchanges() && outputs.size() <= incoming.size();
  if (read_first) {
    std::copy(outputs.begin(), outputs.end(), incoming.begin());
    outputs = std::span(incoming).first(outputs.size());
  }
  bool was_read = false;
  bool was_written = false;
  const auto read_all = [&] {
    for (const auto& mapping : fmmus_.reads()) was_read |= read_logical(mapping, logical, datagram.data, now);
  };
  const auto write_all = [&] {
    for (const auto& mapping : fmmus_.writes()) was_written |= write_logical(mapping, logical, outputs, now);
  };
  if (read_first) read_all();
  if (writes) write_all();
  if (reads && !read_first) read_all();
  count(datagram, was_read, kRead);
  count(datagram, was_written, reads ? kWriteOfReadWrite : kWrite);
}

namespace {

/// The part of a mapping in the data of a logical datagram.
struct Overlap {
  std::size_t data_bit;
  std::size_t physical_bit;
  std::size_t bits;
};

Overlap overlap(const LogicalMapping& mapping, std::uint32_t logical, std::size_t length) noexcept {
  const std::uint64_t data_begin = std::uint64_t{logical} * 8;
  const std::uint64_t begin = std::max(mapping.begin_bit, data_begin);
  const std::uint64_t end = std::min(mapping.end_bit, data_begin + std::uint64_t{length} * 8);
  if (begin >= end) return {0, 0, 0};
  return {begin - data_begin, mapping.physical_bit + (begin - mapping.begin_bit), end - begin};
}

}  // namespace

bool Esc::read_logical(const LogicalMapping& mapping, std::uint32_t logical, std::span<std::byte> data,
                       Nanoseconds now) noexcept {
  const auto part = overlap(mapping, logical, data.size());
  if (part.bits == 0) return false;
  const std::size_t address = part.physical_bit / 8;
  if (mapping.byte_aligned()) return ecat_read(address, data.subspan(part.data_bit / 8, part.bits / 8), now);
  std::array<std::byte, kMaxData + 1> physical;
  const std::size_t shift = part.physical_bit % 8;
  const auto bytes = std::span(physical).first(std::min((shift + part.bits + 7) / 8, physical.size()));
  // Bytes that cannot be read must not change the data: start with the current content.
  copy_bits(data, part.data_bit, bytes, shift, part.bits);
  if (!ecat_read(address, bytes, now)) return false;
  copy_bits(bytes, shift, data, part.data_bit, part.bits);
  return true;
}

bool Esc::write_logical(const LogicalMapping& mapping, std::uint32_t logical, std::span<const std::byte> data,
                        Nanoseconds now) noexcept {
  const auto part = overlap(mapping, logical, data.size());
  if (part.bits == 0) return false;
  const std::size_t address = part.physical_bit / 8;
  if (mapping.byte_aligned()) return ecat_write(address, data.subspan(part.data_bit / 8, part.bits / 8), now);
  std::array<std::byte, kMaxData + 1> physical{};
  const std::size_t shift = part.physical_bit % 8;
  const auto bytes = std::span(physical).first(std::min((shift + part.bits + 7) / 8, physical.size()));
  sync_managers_.peek(address, bytes);
  copy_bits(data, part.data_bit, bytes, shift, part.bits);
  return ecat_write(address, bytes, now);
}

}  // namespace driveline::slaves

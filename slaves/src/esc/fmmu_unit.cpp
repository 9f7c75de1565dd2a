#include "driveline/slaves/esc/fmmu_unit.hpp"

#include <algorithm>
#include <array>

namespace driveline::slaves {

namespace {

constexpr std::size_t kFmmuBase = wire::reg::kFmmu.address;
/// Existing bits of an FMMU's registers; bytes 13-15 are reserved (ETG.1000.4 Table 56).
constexpr std::array<std::uint8_t, 13> kBits = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x07,
                                                0x07, 0xFF, 0xFF, 0x07, 0x03, 0x01};
bool share_physical_bits(const LogicalMapping& a, const LogicalMapping& b) noexcept {
  return a.physical_bit < b.physical_bit + (b.end_bit - b.begin_bit) &&
         b.physical_bit < a.physical_bit + (a.end_bit - a.begin_bit);
}

}  // namespace

FmmuUnit::FmmuUnit(EscMemory& memory, unsigned count) : memory_(memory), count_(std::min(count, kMaxCount)) {
  // Each of n FMMUs adds at most n ranges beside those of lower numbers.
  reads_.reserve(std::size_t{count_} * count_);
  writes_.reserve(std::size_t{count_} * count_);
}

bool FmmuUnit::write_registers(std::size_t address, std::span<const std::byte> data) noexcept {
  bool any = false;
  for (std::size_t i = 0; i < data.size(); ++i) {
    const std::size_t offset = address + i - kFmmuBase;
    if (offset / wire::FmmuEntity::kSize >= count_) break;
    const std::size_t field = offset % wire::FmmuEntity::kSize;
    if (field >= kBits.size()) continue;
    memory_.at(address + i, 1)[0] = data[i] & std::byte{kBits[field]};
    any = true;
  }
  rebuild();
  return any;
}

void FmmuUnit::rebuild() noexcept {
  reads_.clear();
  writes_.clear();
  for (unsigned n = 0; n < count_; ++n) {
    const auto entity =
        *wire::FmmuEntity::decode(memory_.at(kFmmuBase + n * wire::FmmuEntity::kSize, wire::FmmuEntity::kSize));
    if (!entity.active || entity.length == 0) continue;
    const auto start = std::uint64_t{entity.logical_start} * 8;
    const auto last_byte = start + (std::uint64_t{entity.length} - 1) * 8;
    const LogicalMapping mapping{start + entity.logical_start_bit, last_byte + entity.logical_stop_bit + 1,
                                 std::uint32_t{entity.physical_start} * 8 + entity.physical_start_bit};
    if ((entity.type & wire::FmmuEntity::kTypeRead) != 0) add(reads_, mapping);
    if ((entity.type & wire::FmmuEntity::kTypeWrite) != 0) add(writes_, mapping);
  }
  begin_byte_ = ~std::uint64_t{0};
  end_byte_ = 0;
  for (const auto* mappings : {&reads_, &writes_}) {
    for (const auto& m : *mappings) {
      begin_byte_ = std::min(begin_byte_, m.begin_bit / 8);
      end_byte_ = std::max(end_byte_, (m.end_bit + 7) / 8);
    }
  }
  exchanges_ = std::any_of(reads_.begin(), reads_.end(), [this](const auto& r) {
    return std::any_of(writes_.begin(), writes_.end(), [&r](const auto& w) { return share_physical_bits(r, w); });
  });
}

void FmmuUnit::add(std::vector<LogicalMapping>& mappings, LogicalMapping mapping) noexcept {
  // Iterates over the existing ranges in ascending order and inserts the gaps between them.
  std::size_t i = 0;
  while (mapping.begin_bit < mapping.end_bit) {
    while (i < mappings.size() && mappings[i].end_bit <= mapping.begin_bit) ++i;
    const std::uint64_t taken_from = i < mappings.size() ? mappings[i].begin_bit : mapping.end_bit;
    if (mapping.begin_bit < taken_from) {
      LogicalMapping part = mapping;
      part.end_bit = std::min(mapping.end_bit, taken_from);
      if (mappings.size() == mappings.capacity()) return;
      mappings.insert(mappings.begin() + static_cast<std::ptrdiff_t>(i), part);
      ++i;
    }
    if (i == mappings.size()) return;
    const std::uint64_t next = std::min(mappings[i].end_bit, mapping.end_bit);
    if (next <= mapping.begin_bit) return;
    mapping.physical_bit += static_cast<std::uint32_t>(next - mapping.begin_bit);
    mapping.begin_bit = next;
  }
}

}  // namespace driveline::slaves

#include "driveline/ecat_master/bus/sii_cache.hpp"

#include <algorithm>

#include "driveline/bytes/endian.hpp"
#include "driveline/esi/sii.hpp"
#include "driveline/wire/sii_access.hpp"

namespace driveline::ecat_master {
namespace {

namespace sii = wire::sii_access;

constexpr std::size_t kHeadBytes = 2 * SiiCache::kHeadWords;
/// Word address of the serial number (ETG.1000.6 Table 16).
constexpr std::size_t kSerialWord = 14;

/// Whether the head identifies a single device.
bool tells_whose(std::span<const std::byte> content) {
  const auto checksum = bytes::load_le<std::uint16_t>(content.subspan(2 * sii::kChecksumWord, 2));
  if ((checksum & 0xFF) != esi::sii_checksum(content.first<esi::SiiConfigArea::kSize>())) return false;
  return bytes::load_le<std::uint16_t>(content.subspan(2 * sii::kAliasWord, 2)) != 0 ||
         bytes::load_le<std::uint32_t>(content.subspan(2 * kSerialWord, 4)) != 0;
}

const std::vector<std::byte>* with_head(std::span<const std::vector<std::byte>> contents,
                                        std::span<const std::byte> head) {
  const auto found = std::find_if(contents.begin(), contents.end(), [&](const std::vector<std::byte>& content) {
    return std::equal(content.begin(), content.begin() + kHeadBytes, head.begin());
  });
  return found == contents.end() ? nullptr : &*found;
}

}  // namespace

std::optional<std::vector<std::byte>> SiiCache::find(std::span<const std::byte> head) const {
  if (head.size() < kHeadBytes) return std::nullopt;
  const std::scoped_lock lock(mutex_);
  const auto* known = with_head(contents_, head);
  if (known == nullptr) return std::nullopt;
  return *known;
}

void SiiCache::keep(std::span<const std::byte> content) {
  if (content.size() < kHeadBytes || !tells_whose(content)) return;
  const std::scoped_lock lock(mutex_);
  if (with_head(contents_, content) != nullptr) return;
  if (contents_.size() == kMaxContents) contents_.clear();
  contents_.emplace_back(content.begin(), content.end());
}

void SiiCache::clear() {
  const std::scoped_lock lock(mutex_);
  contents_.clear();
}

std::size_t SiiCache::size() const {
  const std::scoped_lock lock(mutex_);
  return contents_.size();
}

}  // namespace driveline::ecat_master

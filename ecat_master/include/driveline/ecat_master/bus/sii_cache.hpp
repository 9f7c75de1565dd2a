#pragma once

#include <cstddef>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace driveline::ecat_master {

/// EEPROM contents that have been read through one bus. With it, another scan of the line or a returning slave costs
/// only reading the head of the EEPROM.
///
/// A content is identified by its head: the first kHeadWords words, which hold the configuration area with its checksum
/// and the alias, vendor, product, revision, serial number, mailboxes, size and the first category header (ETG.1000.6
/// Table 16). The cache never stores contents whose head may fit several devices (no serial number and no alias) or has
/// a wrong checksum. Clear it when an EEPROM is written (write_sii() does). It is not stored in a file, because another
/// tool might write the categories without changing the head.
///
/// All functions: any ordinary thread, not real-time safe.
class SiiCache {
 public:
  /// Words of the head, up to and including the header of the first category.
  static constexpr std::size_t kHeadWords = 0x42;
  /// Most contents stored; when it is exceeded, all are dropped.
  static constexpr std::size_t kMaxContents = 4096;

  /// The complete content that starts with `head`, kHeadWords words; empty: unknown.
  [[nodiscard]] std::optional<std::vector<std::byte>> find(std::span<const std::byte> head) const;
  /// Stores a completely read content if its head is new and identifies a single device.
  void keep(std::span<const std::byte> content);
  /// Drops all contents.
  void clear();
  /// Number of contents stored.
  [[nodiscard]] std::size_t size() const;

 private:
  mutable std::mutex mutex_;
  std::vector<std::vector<std::byte>> contents_;
};

}  // namespace driveline::ecat_master

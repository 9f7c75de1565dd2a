#pragma once

#include <cstddef>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace driveline::ecat_master {

/// EEPROM contents that have been read through one bus, so that a second look at the line and a slave that comes back
/// cost the head of the EEPROM only.
///
/// A content is known by its head: the first kHeadWords words, which hold the configuration area with its checksum and
/// the alias, vendor, product, revision, serial number, mailboxes, size and the first category header (ETG.1000.6 Table
/// 16). A head that would fit several devices, without serial number and without alias, and one with a wrong checksum
/// are never kept. To be cleared when an EEPROM is written (write_sii() does). It is not kept in a file, because
/// another tool might write the categories without changing the head.
///
/// All functions: any ordinary thread, not real-time safe.
class SiiCache {
 public:
  /// Words of the head, up to and including the header of the first category.
  static constexpr std::size_t kHeadWords = 0x42;
  /// Limit of contents; when it is exceeded, all are dropped.
  static constexpr std::size_t kMostContents = 4096;

  /// The whole content that begins with `head`, kHeadWords words; nothing: not known.
  [[nodiscard]] std::optional<std::vector<std::byte>> find(std::span<const std::byte> head) const;
  /// Keeps a content that has been read completely, if its head is new and identifies a single device.
  void keep(std::span<const std::byte> content);
  /// Forgets everything.
  void clear();
  /// Contents that are known.
  [[nodiscard]] std::size_t size() const;

 private:
  mutable std::mutex mutex_;
  std::vector<std::vector<std::byte>> contents_;
};

}  // namespace driveline::ecat_master

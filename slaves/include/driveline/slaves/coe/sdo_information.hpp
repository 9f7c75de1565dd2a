#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "driveline/slaves/od/object_dictionary.hpp"
#include "driveline/wire/coe.hpp"

namespace driveline::slaves {

/// SDO information service: object list, object and entry descriptions, all from the dictionary's table (ETG.1000.6
/// 5.6.3). A list that is longer than the mailbox is sent in fragments.
class SdoInformation {
 public:
  /// The dictionary must outlive this.
  explicit SdoInformation(const ObjectDictionary& dictionary);

  /// Handles a request (bytes after the CoE header) and writes the response (without CoE header) into `out`, which has
  /// at least 16 bytes. Returns the length of the response.
  [[nodiscard]] std::size_t handle(std::span<const std::byte> request, std::span<std::byte> out);
  /// Writes the next fragment of a list; returns its length, 0 when none is left.
  [[nodiscard]] std::size_t next_fragment(std::span<std::byte> out);
  /// Discards the remaining fragments.
  void cancel() noexcept;

 private:
  [[nodiscard]] std::size_t list(std::uint16_t type, std::span<std::byte> out);
  [[nodiscard]] std::size_t object(std::uint16_t index, std::span<std::byte> out) const;
  [[nodiscard]] std::size_t entry(std::uint16_t index, std::uint8_t subindex, std::uint8_t wanted,
                                  std::span<std::byte> out) const;
  void collect(std::uint16_t type);

  const ObjectDictionary* dictionary_;
  std::vector<std::byte> list_;  ///< the list being sent, as bytes
  std::size_t sent_ = 0;
};

}  // namespace driveline::slaves

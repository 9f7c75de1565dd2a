#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "driveline/ecat_master/coe/coe_client.hpp"

namespace driveline::ecat_master {

/// A list object of a slave (ETG.1000.6 5.6.7.4): number of elements in sub-index 0, then the elements. Lists of
/// several slaves are read in parallel: construct all, then request_elements() of each, then take() of each.
template <typename T>
class ListRead {
 public:
  /// Requests the number of elements of object `index`.
  ListRead(MailboxEngine& engine, std::uint16_t position, std::uint16_t index)
      : coe_(engine, position), position_(position), index_(index), count_(coe_.start_upload({index, 0, false})) {}

  /// The object.
  [[nodiscard]] std::uint16_t index() const noexcept { return index_; }

  /// Waits for the number of elements and requests all of them.
  void request_elements() {
    const auto count = number_of<std::uint8_t>(count_, 0);
    if (!count) {
      list_ = tl::unexpected(count.error());
      return;
    }
    for (unsigned n = 1; n <= *count; ++n) {
      elements_.push_back(coe_.start_upload({index_, static_cast<std::uint8_t>(n), false}));
    }
  }

  /// The elements. A list of which at least one element could be read ends at the first one that the slave aborts;
  /// `early` is then set to that error.
  Result<std::vector<T>> take(std::optional<Error>& early) {
    for (std::size_t n = 0; list_ && n < elements_.size(); ++n) {
      const auto element = number_of<T>(elements_[n], static_cast<std::uint8_t>(n + 1));
      if (element) {
        list_->push_back(*element);
      } else if (n > 0 && element.error().template is<facts::SdoAbort>()) {
        early = element.error();
        break;
      } else {
        list_ = tl::unexpected(element.error());
      }
    }
    return std::move(list_);
  }
  /// Number of elements by sub-index 0.
  [[nodiscard]] std::uint8_t elements() const noexcept { return static_cast<std::uint8_t>(elements_.size()); }

 private:
  template <typename Number>
  [[nodiscard]] Result<Number> number_of(const SdoFuture& future, std::uint8_t subindex) const {
    const auto& data = future.get();
    if (!data) return tl::unexpected(data.error());
    if (data->size() == sizeof(Number)) return bytes::load_le<Number>(*data);
    return tl::unexpected(Error{facts::SdoSize{.object = {index_, subindex},
                                               .expected = sizeof(Number),
                                               .received = static_cast<std::uint32_t>(data->size())},
                                position_});
  }

  CoeClient coe_;
  std::uint16_t position_;
  std::uint16_t index_;
  SdoFuture count_;
  std::vector<SdoFuture> elements_;
  Result<std::vector<T>> list_;
};

}  // namespace driveline::ecat_master

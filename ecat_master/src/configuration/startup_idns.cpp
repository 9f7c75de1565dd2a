// Writes the operation data that drives get at start-up.
#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <utility>

#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/soe/soe_client.hpp"
#include "driveline/ecat_master/soe/soe_value.hpp"

namespace driveline::ecat_master {
namespace {

using wire::SoeCommandState;
using wire::SoeElement;
using wire::SoeListHeader;
using Bytes = std::vector<std::byte>;

Bytes characters_of(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

/// The bytes of a value as in a mailbox message, of a list behind its header.
std::optional<Bytes> content_of(const Bytes& raw, const wire::SoeAttribute& attribute) {
  auto content = std::span(raw);
  if (attribute.list) {
    const auto header = SoeListHeader::decode(raw);
    if (!header || header->length > raw.size() - SoeListHeader::kSize) return std::nullopt;
    content = content.subspan(SoeListHeader::kSize, header->length);
  }
  if (!is_whole(content, attribute)) return std::nullopt;
  return Bytes(content.begin(), content.end());
}

/// The value as bytes, of a list without its header; empty: its form is not that of the attribute.
std::optional<Bytes> encode(const StartupIdn& idn, const wire::SoeAttribute& attribute) {
  if (const auto* raw = std::get_if<StartupIdn::Raw>(&idn.value)) return content_of(*raw, attribute);
  if (const auto* single = std::get_if<StartupIdn::Single>(&idn.value)) {
    if (attribute.list) return is_soe_text(attribute) ? std::optional(characters_of(*single)) : std::nullopt;
    const auto element = encode_soe_element(*single, attribute);
    return element ? std::optional(*element) : std::nullopt;
  }
  if (!attribute.list) return std::nullopt;
  Bytes bytes;
  for (const auto& text : std::get<StartupIdn::List>(idn.value)) {
    const auto element = encode_soe_element(text, attribute);
    if (!element) return std::nullopt;
    bytes.insert(bytes.end(), element->begin(), element->end());
  }
  return bytes;
}

/// The writes to the drives of one slave: one transfer at a time.
class IdnRun {
 public:
  IdnRun(MailboxEngine& engine, std::uint16_t position, std::vector<const StartupIdn*> idns)
      : soe_(engine, position), exchange_(engine.bus().exchange()), position_(position), idns_(std::move(idns)) {
    start();
  }

  [[nodiscard]] bool open() const noexcept { return transfer_ != nullptr; }
  [[nodiscard]] const Result<void>& result() const noexcept { return result_; }

  /// Takes the result of the present transfer and starts the next one. Returns false when it is still in progress.
  bool advance() {
    if (!transfer_->done()) return false;
    const auto transfer = std::move(transfer_);
    transfer_.reset();
    const auto& answer = transfer->result();
    if (answer) {
      take(*answer);
    } else {
      take_failure(answer.error());
    }
    return true;
  }

 private:
  enum class Phase : std::uint8_t {
    kAttribute,  ///< reads the attribute
    kCapacity,   ///< reads the present list, because of its maximum length
    kWrite,      ///< writes
    kReadBack,   ///< reads the value that was written
    kLimit,      ///< reads the limit that the refused value violates
    kAwaitEnd,   ///< reads the data state of a procedure command
    kCancel,     ///< cancels the command that has ended
  };

  [[nodiscard]] const StartupIdn& idn() const { return *idns_[next_]; }
  [[nodiscard]] facts::SoeDatum at() const { return idn().at; }
  void read(Phase phase, SoeElement element) {
    phase_ = phase;
    transfer_ = soe_.start_read(at(), element);
  }
  void write(Phase phase, Bytes data) {
    phase_ = phase;
    transfer_ = soe_.start_write(at(), SoeElement::kValue, std::move(data));
  }
  void fail(const ErrorFacts& facts) { result_ = tl::unexpected(Error{facts, position_}); }

  void start() {
    failure_.reset();
    if (next_ < idns_.size()) read(Phase::kAttribute, SoeElement::kAttribute);
  }
  void finish() {
    ++next_;
    start();
  }

  void take(const SoeReading& answer) {
    switch (phase_) {
      case Phase::kAttribute:
        return take_attribute(answer);
      case Phase::kCapacity:
        return take_capacity(answer);
      case Phase::kWrite:
        return take_written();
      case Phase::kReadBack:
        return take_read_back(answer);
      case Phase::kLimit:
        return take_limit(answer);
      case Phase::kAwaitEnd:
        return take_command_state(answer);
      case Phase::kCancel:
        if (failure_) return fail(*failure_);
        return finish();
    }
  }

  void take_failure(const Error& error) {
    const auto* refused = error.as<facts::SoeRefused>();
    if (phase_ == Phase::kLimit) return fail(facts::SoeRefused{at(), refusal_});
    if (phase_ == Phase::kWrite && refused != nullptr && !attribute_.list &&
        (refused->code == wire::SoeError::kValueTooSmall || refused->code == wire::SoeError::kValueTooLarge)) {
      refusal_ = refused->code;
      return read(Phase::kLimit, refusal_ == wire::SoeError::kValueTooSmall ? SoeElement::kMin : SoeElement::kMax);
    }
    result_ = tl::unexpected(error);
  }

  void take_attribute(const SoeReading& answer) {
    const auto part = decode_parameter(answer);
    if (!part || !part->attribute) return fail(content_of(answer));
    attribute_ = *part->attribute;
    auto value = encode(idn(), attribute_);
    if (!value) {
      return fail(facts::SoeForm{at(), attribute_.list, static_cast<std::uint8_t>(attribute_.element_size()),
                                 attribute_.display});
    }
    value_ = std::move(*value);
    if (attribute_.list) return read(Phase::kCapacity, SoeElement::kValue);
    write(Phase::kWrite, value_);
  }

  void take_capacity(const SoeReading& answer) {
    const auto header = SoeListHeader::decode(answer.data);
    if (!header) return fail(content_of(answer));
    if (value_.size() > header->capacity) {
      return fail(facts::SoeListLength{at(), static_cast<std::uint32_t>(value_.size()), header->capacity});
    }
    Bytes list(SoeListHeader::kSize + value_.size());
    SoeListHeader{static_cast<std::uint16_t>(value_.size()), header->capacity}.encode(
        std::span(list).first<SoeListHeader::kSize>());
    std::copy(value_.begin(), value_.end(), list.begin() + SoeListHeader::kSize);
    write(Phase::kWrite, std::move(list));
  }

  void take_written() {
    const bool starts = attribute_.command && unsigned_number(value_) == wire::kSoeCommandStart;
    if (starts) {
      deadline_ = exchange_.now() + SoeCommandSettings{}.limit;
      return read(Phase::kAwaitEnd, SoeElement::kState);
    }
    if (attribute_.command || !idn().read_back) return finish();
    read(Phase::kReadBack, SoeElement::kValue);
  }

  void take_read_back(const SoeReading& answer) {
    const auto part = decode_parameter(answer, attribute_);
    if (!part || !part->value) return fail(content_of(answer));
    const auto& kept = *part->value;
    if (kept == value_) return finish();
    const auto size = attribute_.element_size();
    const auto same = static_cast<std::size_t>(
        std::mismatch(kept.begin(), kept.end(), value_.begin(), value_.end()).first - kept.begin());
    const auto element = same / size;
    const auto number = [&](const Bytes& bytes) {
      return soe_number(std::span(bytes).subspan(std::min(bytes.size(), element * size)), attribute_);
    };
    fail(facts::SoeNotKept{at(), static_cast<std::uint16_t>(element), number(value_), number(kept)});
  }

  void take_limit(const SoeReading& answer) {
    const bool above = refusal_ == wire::SoeError::kValueTooLarge;
    fail(facts::SoeLimit{at(), above, soe_number(value_, attribute_), soe_number(answer.data, attribute_)});
  }

  void take_command_state(const SoeReading& answer) {
    if (answer.data.size() < sizeof(std::uint16_t)) return fail(content_of(answer));
    const auto state = static_cast<SoeCommandState>(bytes::load_le<std::uint16_t>(answer.data));
    const bool ended = state == SoeCommandState::kExecuted || state == SoeCommandState::kFailed ||
                       state == SoeCommandState::kInterrupted;
    if (!ended && exchange_.now() < deadline_) return read(Phase::kAwaitEnd, SoeElement::kState);
    if (!ended) failure_ = facts::SoeCommandTimeout{at(), SoeCommandSettings{}.limit};
    if (ended && state != SoeCommandState::kExecuted) failure_ = facts::SoeCommandEnded{at(), state};
    // The drive keeps the command active until it is cancelled.
    const auto cancel = bytes::to_le_bytes(wire::kSoeCommandCancel);
    write(Phase::kCancel, {cancel.begin(), cancel.end()});
  }

  [[nodiscard]] facts::SoeContent content_of(const SoeReading& answer) const {
    return {at(), static_cast<std::uint32_t>(answer.data.size())};
  }

  SoeClient soe_;
  DatagramExchange& exchange_;
  std::uint16_t position_;
  std::vector<const StartupIdn*> idns_;
  std::size_t next_ = 0;
  Phase phase_ = Phase::kAttribute;
  std::shared_ptr<SoeTransfer> transfer_{};
  wire::SoeAttribute attribute_{};
  Bytes value_{};  ///< encoded value, of a list without its header
  wire::SoeError refusal_{};
  std::chrono::nanoseconds deadline_{0};  ///< end of the time of a procedure command
  std::optional<ErrorFacts> failure_{};   ///< of a procedure command
  Result<void> result_{};
};

}  // namespace

Result<void> write_startup_idns(MailboxEngine& engine, std::span<const ConfiguredSlave> slaves,
                                motion::StartupState in) {
  std::vector<IdnRun> runs;
  for (const auto& slave : slaves) {
    if (!slave.present) continue;
    std::vector<const StartupIdn*> idns;
    for (const auto& idn : slave.plan.startup_idns) {
      if (idn.in == in) idns.push_back(&idn);
    }
    if (idns.empty()) continue;
    const auto position = slave.info.ref.position;
    if (!slave.mailbox || !slave.info.description.mailbox.soe) {
      return tl::unexpected(Error{facts::NoMailbox{wire::MailboxType::kSoe}, position});
    }
    runs.emplace_back(engine, position, std::move(idns));
  }
  for (bool open = true; open;) {
    open = false;
    bool moved = false;
    for (auto& run : runs) {
      if (!run.open()) continue;
      open = true;
      moved = run.advance() || moved;
    }
    if (open && !moved) engine.drive();
  }
  for (const auto& run : runs) {
    if (!run.result()) return run.result();
  }
  return {};
}

}  // namespace driveline::ecat_master

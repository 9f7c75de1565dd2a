#include "driveline/ecat_master/soe/soe_client.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "soe/soe_write.hpp"

namespace driveline::ecat_master {
namespace {

using wire::SoeCommandState;
using wire::SoeElement;

/// Elements that an operation datum may have in addition to its attribute.
constexpr std::array kBesideAttribute = {SoeElement::kState, SoeElement::kName,  SoeElement::kUnit,   SoeElement::kMin,
                                         SoeElement::kMax,   SoeElement::kValue, SoeElement::kDefault};

void take_over(SoeParameter& whole, SoeParameter&& part) {
  if (part.state) whole.state = part.state;
  if (part.name) whole.name = std::move(part.name);
  if (part.unit) whole.unit = std::move(part.unit);
  if (part.min) whole.min = std::move(part.min);
  if (part.max) whole.max = std::move(part.max);
  if (part.value) whole.value = std::move(part.value);
  if (part.preset) whole.preset = std::move(part.preset);
}

bool over(SoeCommandState state) {
  return state == SoeCommandState::kExecuted || state == SoeCommandState::kFailed ||
         state == SoeCommandState::kInterrupted;
}

}  // namespace

std::shared_ptr<SoeTransfer> SoeClient::start_read(facts::SoeDatum at, wire::SoeElementSet elements) {
  auto transfer = std::make_shared<SoeTransfer>(at, elements);
  engine_.submit(position_, transfer);
  return transfer;
}

std::shared_ptr<SoeTransfer> SoeClient::start_write(facts::SoeDatum at, SoeElement element,
                                                    std::vector<std::byte> data) {
  auto transfer = std::make_shared<SoeTransfer>(at, element, std::move(data), kSoeFollowingPriority);
  engine_.submit(position_, std::make_shared<SoeWriteBeginning>(engine_, transfer));
  return transfer;
}

Result<SoeReading> SoeClient::read(facts::SoeDatum at, wire::SoeElementSet elements) {
  const auto transfer = start_read(at, elements);
  engine_.wait(*transfer);
  return transfer->result();
}

Result<void> SoeClient::write(facts::SoeDatum at, SoeElement element, std::span<const std::byte> data) {
  const auto transfer = start_write(at, element, {data.begin(), data.end()});
  engine_.wait(*transfer);
  if (!transfer->result()) return tl::unexpected(transfer->result().error());
  return {};
}

/// Reads and decodes all `elements`.
Result<SoeParameter> SoeClient::read_apart(facts::SoeDatum at, wire::SoeElementSet elements,
                                           std::optional<wire::SoeAttribute> attribute) {
  const auto reading = read(at, elements);
  if (!reading) return tl::unexpected(reading.error());
  auto parameter = decode_parameter(*reading, attribute);
  if (!parameter || reading->elements != elements) {
    return tl::unexpected(Error{facts::SoeContent{at, static_cast<std::uint32_t>(reading->data.size())}, position_});
  }
  return std::move(*parameter);
}

Result<wire::SoeAttribute> SoeClient::attribute(facts::SoeDatum at) {
  return read_apart(at, SoeElement::kAttribute, std::nullopt).map([](const auto& part) { return *part.attribute; });
}

Result<std::string> SoeClient::name(facts::SoeDatum at) {
  return read_apart(at, SoeElement::kName, std::nullopt).map([](auto&& part) { return std::move(*part.name); });
}

Result<std::vector<std::byte>> SoeClient::value(facts::SoeDatum at) {
  const auto known = attribute(at);
  if (!known) return tl::unexpected(known.error());
  return read_apart(at, SoeElement::kValue, *known).map([](auto&& part) { return std::move(*part.value); });
}

Result<void> SoeClient::write_value(facts::SoeDatum at, std::span<const std::byte> value) {
  const auto known = attribute(at);
  if (!known) return tl::unexpected(known.error());
  if (!known->list) return write(at, SoeElement::kValue, value);
  if (value.size() > 0xFFFF) {
    return tl::unexpected(
        Error{facts::ProcessDataSize{.bytes = static_cast<std::uint32_t>(value.size()), .limit = 0xFFFF}, position_});
  }
  const auto length = static_cast<std::uint16_t>(value.size());
  std::vector<std::byte> data(wire::SoeListHeader::kSize + value.size());
  wire::SoeListHeader{length, length}.encode(std::span(data).first<wire::SoeListHeader::kSize>());
  std::copy(value.begin(), value.end(), data.begin() + wire::SoeListHeader::kSize);
  return write(at, SoeElement::kValue, data);
}

Result<std::vector<wire::Idn>> SoeClient::idn_list(facts::SoeDatum at) {
  const auto list = value(at);
  if (!list) return tl::unexpected(list.error());
  auto idns = idns_of(*list);
  if (!idns) {
    return tl::unexpected(Error{facts::SoeContent{at, static_cast<std::uint32_t>(list->size())}, position_});
  }
  return std::move(*idns);
}

Result<SoeParameter> SoeClient::parameter(facts::SoeDatum at) {
  const auto known = attribute(at);
  if (!known) return tl::unexpected(known.error());
  SoeParameter whole;
  whole.attribute = *known;
  for (const auto element : kBesideAttribute) {
    auto part = read_apart(at, element, *known);
    if (part) {
      take_over(whole, std::move(*part));
    } else if (!part.error().is<facts::SoeRefused>()) {
      return tl::unexpected(part.error());
    }
  }
  return whole;
}

Result<void> SoeClient::execute(facts::SoeDatum command, const SoeCommandSettings& settings) {
  const auto started = write(command, SoeElement::kValue, bytes::to_le_bytes(wire::kSoeCommandStart));
  if (!started) return started;
  const auto state = await_end(command, settings);
  // Whatever the outcome: the drive keeps the command active until it is cancelled.
  const auto cancelled = write(command, SoeElement::kValue, bytes::to_le_bytes(wire::kSoeCommandCancel));
  if (!state) return tl::unexpected(state.error());
  if (*state != SoeCommandState::kExecuted) {
    return tl::unexpected(Error{facts::SoeCommandEnded{command, *state}, position_});
  }
  return cancelled;
}

/// Polls the data state until the command has ended.
Result<SoeCommandState> SoeClient::await_end(facts::SoeDatum command, const SoeCommandSettings& settings) {
  auto& exchange = engine_.bus().exchange();
  const auto deadline = exchange.now() + settings.limit;
  while (exchange.now() < deadline) {
    const auto part = read_apart(command, SoeElement::kState, std::nullopt);
    if (!part) return tl::unexpected(part.error());
    const auto state = static_cast<SoeCommandState>(*part->state);
    if (over(state)) return state;
    const auto next = exchange.now() + settings.interval;
    while (exchange.now() < next) engine_.drive();
  }
  return tl::unexpected(Error{facts::SoeCommandTimeout{command, settings.limit}, position_});
}

}  // namespace driveline::ecat_master

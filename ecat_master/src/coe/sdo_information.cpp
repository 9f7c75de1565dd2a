#include "driveline/ecat_master/coe/sdo_information.hpp"

#include <algorithm>
#include <array>

#include "coe/about_object.hpp"

namespace driveline::ecat_master {
namespace {

using wire::CoeHeader;
using wire::SdoInfoHeader;
using wire::SdoInfoOpCode;

/// Value information bits of an entry description (ETG.1000.6 Table 53).
constexpr std::uint8_t kUnit = 0x08;
constexpr std::uint8_t kDefault = 0x10;
constexpr std::uint8_t kMinimum = 0x20;
constexpr std::uint8_t kMaximum = 0x40;
constexpr std::uint8_t kEverything = 0x7F;

constexpr std::size_t kObjectHeader = 6;
constexpr std::size_t kEntryHeader = 10;

Error malformed() {
  return {facts::MailboxMalformed{}};
}

std::string text_of(std::span<const std::byte> bytes) {
  std::string text;
  for (const auto byte : bytes) {
    // Some slaves terminate the name with a zero, although its length is known.
    if (byte == std::byte{0}) break;
    text += static_cast<char>(byte);
  }
  return text;
}

/// Op-code of the answer: that of the query plus 1.
SdoInfoOpCode answer_to(SdoInfoOpCode question) {
  return static_cast<SdoInfoOpCode>(static_cast<std::uint8_t>(question) + 1);
}

}  // namespace

std::shared_ptr<SdoInformationQuery> SdoInformationQuery::list(ObjectList list) {
  const auto type = static_cast<std::uint16_t>(list);
  return std::make_shared<SdoInformationQuery>(SdoInfoOpCode::kListRequest, type, std::uint8_t{0},
                                               bytes::to_le_bytes(type));
}

std::shared_ptr<SdoInformationQuery> SdoInformationQuery::object(std::uint16_t index) {
  return std::make_shared<SdoInformationQuery>(SdoInfoOpCode::kObjectRequest, index, std::uint8_t{0},
                                               bytes::to_le_bytes(index));
}

std::shared_ptr<SdoInformationQuery> SdoInformationQuery::entry(std::uint16_t index, std::uint8_t subindex) {
  std::array<std::byte, 4> parameters{};
  bytes::store_le(std::span(parameters).first<2>(), index);
  parameters[2] = static_cast<std::byte>(subindex);
  parameters[3] = std::byte{kEverything};
  return std::make_shared<SdoInformationQuery>(SdoInfoOpCode::kEntryRequest, index, subindex, parameters);
}

SdoInformationQuery::SdoInformationQuery(SdoInfoOpCode question, std::uint16_t about, std::uint8_t subindex,
                                         std::span<const std::byte> parameters)
    : MailboxDialogue(wire::MailboxType::kCoe, 0), question_(question), about_(about), subindex_(subindex) {
  constexpr std::size_t kHeaders = CoeHeader::kSize + SdoInfoHeader::kSize;
  outgoing_.resize(kHeaders + parameters.size());
  CoeHeader{0, wire::CoeService::kSdoInformation}.encode(std::span(outgoing_).first<CoeHeader::kSize>());
  SdoInfoHeader{question, false, 0}.encode(std::span(outgoing_).subspan<CoeHeader::kSize, SdoInfoHeader::kSize>());
  std::copy(parameters.begin(), parameters.end(), outgoing_.begin() + kHeaders);
}

void SdoInformationQuery::begin(std::uint16_t position, MailboxRoom /*room*/) {
  position_ = position;
}

facts::ObjectAddress SdoInformationQuery::object() const noexcept {
  return {question_ == SdoInfoOpCode::kListRequest ? std::uint16_t{0} : about_, subindex_};
}

MailboxDialogue::Reaction SdoInformationQuery::end(ErrorFacts facts) {
  result_ = tl::unexpected(Error{facts, position_});
  return Reaction::kDone;
}

/// The first fragment starts with the index (and sub-index) of the query.
bool SdoInformationQuery::is_about_this(std::span<const std::byte> data) const {
  if (data.size() < 2 || bytes::load_le<std::uint16_t>(data) != about_) return false;
  return question_ != SdoInfoOpCode::kEntryRequest ||
         (data.size() >= 3 && std::to_integer<std::uint8_t>(data[2]) == subindex_);
}

MailboxDialogue::Reaction SdoInformationQuery::receive(std::span<const std::byte> service) {
  const auto coe = CoeHeader::decode(service);
  if (!coe || coe->service != wire::CoeService::kSdoInformation) return Reaction::kForeign;
  const auto header = SdoInfoHeader::decode(service.subspan(CoeHeader::kSize));
  if (!header) return end(facts::MailboxMalformed{object()});
  const auto data = service.subspan(CoeHeader::kSize + SdoInfoHeader::kSize);
  if (header->op_code == SdoInfoOpCode::kError) {
    if (data.size() < 4) return end(facts::MailboxMalformed{object()});
    return end(facts::SdoAbort{object(), static_cast<wire::SdoAbort>(bytes::load_le<std::uint32_t>(data))});
  }
  if (header->op_code != answer_to(question_)) return Reaction::kForeign;
  if (!fragments_left_) {
    if (!is_about_this(data)) return Reaction::kForeign;
  } else if (header->fragments_left + 1 != *fragments_left_) {
    return end(facts::MailboxMalformed{object()});
  }
  if (data_.size() + data.size() > kMaxAnswerBytes) return end(facts::MailboxMalformed{object()});
  data_.insert(data_.end(), data.begin(), data.end());
  fragments_left_ = header->fragments_left;
  if (header->fragments_left != 0) return Reaction::kAwait;
  result_ = std::move(data_);
  return Reaction::kDone;
}

void SdoInformationQuery::fail(const Error& failure) {
  result_ = tl::unexpected(about_object(failure, object()));
}

Result<std::vector<std::uint16_t>> decode_object_list(std::span<const std::byte> answer) {
  if (answer.size() < 2 || answer.size() % 2 != 0) return tl::unexpected(malformed());
  std::vector<std::uint16_t> indices;
  for (std::size_t at = 2; at < answer.size(); at += 2) {
    indices.push_back(bytes::load_le<std::uint16_t>(answer.subspan(at, 2)));
  }
  return indices;
}

Result<ObjectDescription> decode_object_description(std::span<const std::byte> answer) {
  if (answer.size() < kObjectHeader) return tl::unexpected(malformed());
  ObjectDescription object;
  object.index = bytes::load_le<std::uint16_t>(answer);
  object.data_type = bytes::load_le<std::uint16_t>(answer.subspan(2));
  object.max_subindex = bytes::load_le<std::uint8_t>(answer.subspan(4));
  object.object_code = bytes::load_le<std::uint8_t>(answer.subspan(5));
  object.name = text_of(answer.subspan(kObjectHeader));
  return object;
}

Result<EntryDescription> decode_entry_description(std::span<const std::byte> answer) {
  if (answer.size() < kEntryHeader) return tl::unexpected(malformed());
  EntryDescription entry;
  entry.index = bytes::load_le<std::uint16_t>(answer);
  entry.subindex = bytes::load_le<std::uint8_t>(answer.subspan(2));
  const auto flags = bytes::load_le<std::uint8_t>(answer.subspan(3));
  entry.data_type = bytes::load_le<std::uint16_t>(answer.subspan(4));
  entry.bit_length = bytes::load_le<std::uint16_t>(answer.subspan(6));
  entry.access = bytes::load_le<std::uint16_t>(answer.subspan(8));
  auto rest = answer.subspan(kEntryHeader);
  if ((flags & kUnit) != 0) {
    if (rest.size() < 4) return tl::unexpected(malformed());
    entry.unit = bytes::load_le<std::uint32_t>(rest);
    rest = rest.subspan(4);
  }
  const std::size_t bytes = (std::size_t{entry.bit_length} + 7) / 8;
  for (const auto& [bit, value] : {std::pair{kDefault, &entry.default_value}, std::pair{kMinimum, &entry.minimum},
                                   std::pair{kMaximum, &entry.maximum}}) {
    if ((flags & bit) == 0) continue;
    if (rest.size() < bytes) return tl::unexpected(malformed());
    value->emplace(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(bytes));
    rest = rest.subspan(bytes);
  }
  entry.name = text_of(rest);
  return entry;
}

}  // namespace driveline::ecat_master

#include "driveline/ecat_master/coe/coe_client.hpp"

namespace driveline::ecat_master {

Error CoeClient::size_error(std::uint16_t index, std::uint8_t subindex, std::size_t expected,
                            std::size_t received) const noexcept {
  return {facts::SdoSize{.object = {index, subindex},
                         .expected = static_cast<std::uint32_t>(expected),
                         .received = static_cast<std::uint32_t>(received)},
          position_};
}

SdoFuture CoeClient::start_upload(SdoAddress at, Callback callback, std::uint8_t priority) {
  auto transfer = std::make_shared<SdoTransfer>(at, priority);
  transfer->on_completion(std::move(callback));
  engine_.submit(position_, transfer);
  return {engine_, std::move(transfer)};
}

SdoFuture CoeClient::start_download(SdoAddress at, std::span<const std::byte> data, Callback callback,
                                    std::uint8_t priority) {
  auto transfer = std::make_shared<SdoTransfer>(at, std::vector<std::byte>(data.begin(), data.end()), priority);
  transfer->on_completion(std::move(callback));
  engine_.submit(position_, transfer);
  return {engine_, std::move(transfer)};
}

Result<std::vector<std::byte>> CoeClient::upload(std::uint16_t index, std::uint8_t subindex, bool complete) {
  return start_upload({index, subindex, complete}).get();
}

Result<void> CoeClient::download(std::uint16_t index, std::uint8_t subindex, std::span<const std::byte> data,
                                 bool complete) {
  const auto future = start_download({index, subindex, complete}, data);
  if (const auto& done = future.get(); !done) return tl::unexpected(done.error());
  return {};
}

Result<std::vector<std::byte>> CoeClient::ask(const std::shared_ptr<SdoInformationQuery>& query) {
  engine_.submit(position_, query);
  engine_.wait(*query);
  return query->result();
}

namespace {

/// Adds slave and object to the error of an answer that is too short.
template <typename T>
Result<T> named(Result<T> result, std::uint16_t position, facts::ObjectAddress object) {
  if (!result) result.error() = {facts::MailboxMalformed{object}, position};
  return result;
}

}  // namespace

Result<std::vector<std::uint16_t>> CoeClient::object_list(ObjectList list) {
  const auto answer = ask(SdoInformationQuery::list(list));
  if (!answer) return tl::unexpected(answer.error());
  return named(decode_object_list(*answer), position_, {});
}

Result<ObjectDescription> CoeClient::object_description(std::uint16_t index) {
  const auto answer = ask(SdoInformationQuery::object(index));
  if (!answer) return tl::unexpected(answer.error());
  return named(decode_object_description(*answer), position_, {index, 0});
}

Result<EntryDescription> CoeClient::entry_description(std::uint16_t index, std::uint8_t subindex) {
  const auto answer = ask(SdoInformationQuery::entry(index, subindex));
  if (!answer) return tl::unexpected(answer.error());
  return named(decode_entry_description(*answer), position_, {index, subindex});
}

}  // namespace driveline::ecat_master

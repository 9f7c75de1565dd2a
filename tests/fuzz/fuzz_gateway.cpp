// Bytes from clients of the mailbox gateway. Input: a first byte with the number of bytes that arrive at a time; then
// the bytes of a TCP client. Its messages then go to an exchange with a slave that answers with them.

#include <algorithm>

#include "driveline/ecat_master/mailbox/mail_exchange.hpp"
#include "fuzz_target.hpp"
#include "gateway/gateway_frame.hpp"

namespace driveline::fuzz {
namespace {

using ecat_master::MailboxDialogue;

/// Sends each message as it was received, and processes it as an answer of the slave.
void pass_on(const runtime::GatewayMail& mail) {
  const auto bytes = runtime::encode_gateway_mail(mail);
  const auto length = runtime::gateway_mail_length(bytes);
  if (!length || *length + runtime::kGatewayHeader != bytes.size()) std::abort();
  const auto again = runtime::decode_gateway_mail(std::span(bytes).subspan(runtime::kGatewayHeader));
  if (!again || again->service != mail.service || again->header.address != mail.header.address) std::abort();
  ecat_master::MailExchange exchange(mail.header.type, mail.service, std::chrono::seconds{1});
  exchange.begin(0, {});
  const auto reaction = exchange.receive(mail.service);
  const bool taken = reaction != MailboxDialogue::Reaction::kForeign;
  if (taken != (exchange.answers()->size() == 1)) std::abort();
}

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  if (input.empty()) return;
  const auto step = std::to_integer<std::size_t>(input[0]) + 1;
  input = input.subspan(1);
  runtime::GatewayStream stream;
  std::size_t taken = 0;
  for (std::size_t at = 0; at < input.size(); at += step) {
    stream.push(input.subspan(at, std::min(step, input.size() - at)));
    while (const auto mail = stream.next()) {
      taken += runtime::kGatewayHeader + wire::MailboxHeader::kSize + mail->service.size();
      if (taken > input.size()) std::abort();
      pass_on(*mail);
    }
  }
}

std::vector<Bytes> seeds() {
  std::vector<Bytes> all;
  for (const std::size_t step : {0U, 6U, 255U}) {
    Bytes input = {static_cast<std::byte>(step)};
    for (const auto type : {wire::MailboxType::kCoe, wire::MailboxType::kSoe, wire::MailboxType::kVoe}) {
      runtime::GatewayMail mail;
      mail.header.type = type;
      mail.header.address = 0x1001;
      mail.service = Bytes{std::byte{0x08}, std::byte{0x80}, std::byte{0x82}, std::byte{0x01}};
      const auto bytes = runtime::encode_gateway_mail(mail);
      input.insert(input.end(), bytes.begin(), bytes.end());
    }
    all.push_back(std::move(input));
  }
  return all;
}

}  // namespace driveline::fuzz

#include "driveline/ecat_master/mailbox/mailbox_writer.hpp"

namespace driveline::ecat_master {

MailboxWriter::MailboxWriter(SlaveRef slave, const MailboxWindow& window)
    : slave_(slave), address_(window.out_address), length_(window.out_length), counter_(window.last_counter) {}

std::span<std::byte> MailboxWriter::blank() {
  // The whole buffer is written: only the access to its last byte hands a mailbox over.
  mail_.assign(length_, std::byte{0});
  return std::span(mail_).last(room());
}

void MailboxWriter::seal(wire::MailboxType type, std::uint8_t priority, std::size_t length) {
  counter_ = wire::next_mailbox_counter(counter_);
  wire::MailboxHeader header;
  header.length = static_cast<std::uint16_t>(length);
  header.priority = priority;
  header.type = type;
  header.counter = counter_;
  header.encode(std::span(mail_).first<wire::MailboxHeader::kSize>());
}

void MailboxWriter::append(std::vector<Request>& batch) {
  wire_ = mail_;
  batch.push_back({wire::Command::kFpwr, wire::DatagramAddress::physical(slave_.station, address_), wire_, 0, false});
}

}  // namespace driveline::ecat_master

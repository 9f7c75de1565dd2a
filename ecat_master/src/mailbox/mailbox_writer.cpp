#include "driveline/ecat_master/mailbox/mailbox_writer.hpp"

namespace driveline::ecat_master {

MailboxWriter::MailboxWriter(SlaveRef slave, const MailboxWindow& window)
    : slave_(slave), address_(window.out_address), length_(window.out_length), counter_(window.last_counter) {}

std::span<std::byte> MailboxWriter::blank() {
  ahead_ = false;
  return blank(current_);
}

std::span<std::byte> MailboxWriter::blank_ahead() {
  ahead_ = false;
  return blank(1 - current_);
}

std::span<std::byte> MailboxWriter::blank(std::size_t mail) {
  blanked_ = mail;
  // Write the whole buffer: only the access to its last byte hands a mailbox over.
  mails_.at(mail).assign(length_, std::byte{0});
  return std::span(mails_.at(mail)).last(room());
}

void MailboxWriter::seal(wire::MailboxType type, std::uint8_t priority, std::size_t length, std::uint16_t source) {
  counter_ = wire::next_mailbox_counter(counter_);
  seal_again(type, priority, length, source);
}

void MailboxWriter::seal_again(wire::MailboxType type, std::uint8_t priority, std::size_t length,
                               std::uint16_t source) {
  wire::MailboxHeader header;
  header.length = static_cast<std::uint16_t>(length);
  header.address = source;
  header.priority = priority;
  header.type = type;
  header.counter = counter_;
  header.encode(std::span(mails_.at(blanked_)).first<wire::MailboxHeader::kSize>());
  ahead_ = blanked_ != current_;
}

bool MailboxWriter::advance() noexcept {
  if (!ahead_) return false;
  ahead_ = false;
  current_ = 1 - current_;
  return true;
}

void MailboxWriter::append(std::vector<Request>& batch) {
  append(current_, batch);
}

void MailboxWriter::append_ahead(std::vector<Request>& batch) {
  append(1 - current_, batch);
}

void MailboxWriter::append(std::size_t mail, std::vector<Request>& batch) {
  side_ = 1 - side_;
  auto& copy = wire_.at(side_);
  copy = mails_.at(mail);
  batch.push_back({wire::Command::kFpwr, wire::DatagramAddress::physical(slave_.station, address_), copy, 0, false});
}

}  // namespace driveline::ecat_master

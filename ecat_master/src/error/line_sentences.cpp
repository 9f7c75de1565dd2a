// Messages for errors of frames and of the line as a whole.
#include <fmt/format.h>

#include "error/sentence.hpp"

namespace driveline::ecat_master {
namespace {

std::string answering(std::uint32_t count) {
  return count == 1 ? std::string("1 slave answers") : fmt::format("{} slaves answer", count);
}

std::string_view to_text(IdentityNumber number) {
  switch (number) {
    case IdentityNumber::kVendor:
      return "vendor id";
    case IdentityNumber::kProduct:
      return "product code";
    case IdentityNumber::kRevision:
      return "revision";
    case IdentityNumber::kSerial:
      return "serial number";
    case IdentityNumber::kAlias:
      return "alias";
    case IdentityNumber::kDeviceId:
      return "device ID";
  }
  return "identity";
}

std::string known_by_text(KnownBy known_by, std::uint16_t number) {
  return fmt::format("{} {}", known_by == KnownBy::kAlias ? "alias" : "device ID", number);
}

/// The numbers of planned and found slaves if they differ.
std::string slave_counts(std::uint32_t planned, std::uint32_t found) {
  if (planned == found) return {};
  return fmt::format("; {}, {} planned", answering(found),
                     planned == 1 ? std::string("1 is") : fmt::format("{} are", planned));
}

}  // namespace

std::string describe(const Error& error) {
  return std::visit(Sentence(error.slave), error.facts);
}

std::string Sentence::who() const {
  return slave_ == Error::kNoSlave ? std::string("the line") : fmt::format("slave {}", slave_);
}

std::string Sentence::operator()(const facts::NoAnswer& facts) const {
  return fmt::format("{}: no answer to a frame after {} tries", who(), facts.tries);
}

std::string Sentence::operator()(const facts::LinkDown& /*facts*/) const {
  return "the port has no link";
}

std::string Sentence::operator()(const facts::WorkingCounter& facts) const {
  return fmt::format("{}: working counter {} instead of {} at address 0x{:04X}", who(), facts.received, facts.expected,
                     facts.address);
}

std::string Sentence::operator()(const facts::NoExchange& facts) const {
  return fmt::format(
      "no cyclic frame returned within the {} us of waiting per cycle, in {} cycles; {} frames came later",
      facts.window.count() / 1000, facts.cycles, facts.late);
}

std::string Sentence::operator()(const facts::Cancelled& /*facts*/) const {
  return "stopped on request";
}

std::string Sentence::operator()(const facts::ExchangeFull& /*facts*/) const {
  return "the queue to the cycle is full of abandoned frames; the cycle may have stopped";
}

std::string Sentence::operator()(const facts::NoSlaves& /*facts*/) const {
  return "no slave answers on the line";
}

std::string Sentence::operator()(const facts::TooManySlaves& facts) const {
  return fmt::format("{}, the limit is {}", answering(facts.found), facts.limit);
}

std::string Sentence::operator()(const facts::PortsFitNoTree& facts) const {
  return fmt::format("{}: its {} open ports do not match any tree of the slaves that answer", who(), facts.open_ports);
}

std::string Sentence::operator()(const facts::IdentityMismatch& facts) const {
  return fmt::format("{}: {} is 0x{:08X} but {}0x{:08X} {}", who(), to_text(facts.number), facts.found,
                     facts.at_least ? ">= " : "", facts.expected, facts.at_start ? "was there at start" : "is planned");
}

std::string Sentence::operator()(const facts::SlaveMissing& facts) const {
  return fmt::format("planned slave {}{} is not on the line{}", facts.plan,
                     facts.known_by == KnownBy::kPosition
                         ? std::string{}
                         : fmt::format(" ({})", known_by_text(facts.known_by, facts.number)),
                     slave_counts(facts.planned, facts.found));
}

std::string Sentence::operator()(const facts::SlaveExtra& facts) const {
  return fmt::format("{} is not planned{}", who(), slave_counts(facts.planned, facts.found));
}

std::string Sentence::operator()(const facts::SlavesSwapped& facts) const {
  return fmt::format("{} and slave {} have changed places", who(), facts.other);
}

std::string Sentence::operator()(const facts::InOutSwapped& facts) const {
  return fmt::format("{}: IN and OUT are swapped, frames come in at port {}", who(), facts.port);
}

std::string Sentence::operator()(const facts::DuplicateAlias& facts) const {
  return fmt::format("{} and slave {} both answer to {}", who(), facts.other,
                     known_by_text(facts.known_by, facts.number));
}

std::string Sentence::operator()(const facts::PlaceUnknown& facts) const {
  return fmt::format("{}: of {} missing slaves {} came back, and neither wiring nor serial number identifies them",
                     who(), facts.missing, facts.returned);
}

}  // namespace driveline::ecat_master

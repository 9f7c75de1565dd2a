#pragma once

#include "driveline/ecat_master/error.hpp"

namespace driveline::ecat_master {

/// Visitor that makes the message of an error about `slave`.
class Sentence {
 public:
  explicit Sentence(std::uint16_t slave) noexcept : slave_(slave) {}

  // line_sentences.cpp
  std::string operator()(const facts::NoAnswer& facts) const;
  std::string operator()(const facts::LinkDown& facts) const;
  std::string operator()(const facts::WorkingCounter& facts) const;
  std::string operator()(const facts::NoExchange& facts) const;
  std::string operator()(const facts::Cancelled& facts) const;
  std::string operator()(const facts::ExchangeFull& facts) const;
  std::string operator()(const facts::NoSlaves& facts) const;
  std::string operator()(const facts::TooManySlaves& facts) const;
  std::string operator()(const facts::PortsFitNoTree& facts) const;
  std::string operator()(const facts::IdentityMismatch& facts) const;
  std::string operator()(const facts::SlaveMissing& facts) const;
  std::string operator()(const facts::SlaveExtra& facts) const;
  std::string operator()(const facts::SlavesSwapped& facts) const;
  std::string operator()(const facts::InOutSwapped& facts) const;
  std::string operator()(const facts::DuplicateAlias& facts) const;
  std::string operator()(const facts::PlaceUnknown& facts) const;

  // slave_sentences.cpp
  std::string operator()(const facts::SiiBusy& facts) const;
  std::string operator()(const facts::SiiError& facts) const;
  std::string operator()(const facts::SiiContent& facts) const;
  std::string operator()(const facts::SiiBlank& facts) const;
  std::string operator()(const facts::SiiVerify& facts) const;
  std::string operator()(const facts::SiiChecksum& facts) const;
  std::string operator()(const facts::StateRefused& facts) const;
  std::string operator()(const facts::StateTimeout& facts) const;
  std::string operator()(const facts::NoMailbox& facts) const;
  std::string operator()(const facts::NoBootMailbox& facts) const;
  std::string operator()(const facts::MailboxTimeout& facts) const;
  std::string operator()(const facts::MailboxError& facts) const;
  std::string operator()(const facts::MailboxMalformed& facts) const;
  std::string operator()(const facts::SdoAbort& facts) const;
  std::string operator()(const facts::SdoSize& facts) const;
  std::string operator()(const facts::FileRefused& facts) const;
  std::string operator()(const facts::FilePacket& facts) const;
  std::string operator()(const facts::FileSize& facts) const;
  std::string operator()(const facts::FileBusy& facts) const;
  std::string operator()(const facts::NoEoe& facts) const;
  std::string operator()(const facts::EoeRefused& facts) const;
  std::string operator()(const facts::SoeRefused& facts) const;
  std::string operator()(const facts::SoeOther& facts) const;
  std::string operator()(const facts::SoeFragments& facts) const;
  std::string operator()(const facts::SoeContent& facts) const;
  std::string operator()(const facts::SoeForm& facts) const;
  std::string operator()(const facts::SoeListLength& facts) const;
  std::string operator()(const facts::SoeLimit& facts) const;
  std::string operator()(const facts::SoeNotKept& facts) const;
  std::string operator()(const facts::SoeCommandEnded& facts) const;
  std::string operator()(const facts::SoeCommandTimeout& facts) const;
  std::string operator()(const facts::ProcessDataSize& facts) const;
  std::string operator()(const facts::TooFewFmmus& facts) const;

  // clock_sentences.cpp
  std::string operator()(const facts::NoClocks& facts) const;
  std::string operator()(const facts::NoClock& facts) const;
  std::string operator()(const facts::ReferenceWithoutClock& facts) const;
  std::string operator()(const facts::BeforeReference& facts) const;
  std::string operator()(const facts::NoClockMode& facts) const;
  std::string operator()(const facts::NotInPreOp& facts) const;
  std::string operator()(const facts::ContradictingDelays& facts) const;
  std::string operator()(const facts::NoReceiveTimes& facts) const;
  std::string operator()(const facts::StartTimePast& facts) const;
  std::string operator()(const facts::SyncRegister& facts) const;
  std::string operator()(const facts::SyncObject& facts) const;
  std::string operator()(const facts::SyncCycleRange& facts) const;
  std::string operator()(const facts::SyncCycleBase& facts) const;
  std::string operator()(const facts::SyncCycleAndPeriod& facts) const;
  std::string operator()(const facts::SyncShift& facts) const;
  std::string operator()(const facts::Sync1WithoutSync0& facts) const;
  std::string operator()(const facts::Sync1Cycle& facts) const;
  std::string operator()(const facts::Sync1Shift& facts) const;
  std::string operator()(const facts::NoCommonCycle& facts) const;
  std::string operator()(const facts::FrameLead& facts) const;
  std::string operator()(const facts::NotLocked& facts) const;
  std::string operator()(const facts::NotSynchronised& facts) const;

 private:
  /// "slave 3", or "the line".
  [[nodiscard]] std::string who() const;

  std::uint16_t slave_;
};

}  // namespace driveline::ecat_master

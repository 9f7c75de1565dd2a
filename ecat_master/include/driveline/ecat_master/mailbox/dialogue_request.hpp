#pragma once

#include <cstdint>
#include <memory>

#include "driveline/ecat_master/mailbox/dialogue.hpp"

namespace driveline::ecat_master {

/// A request that becomes a dialogue, for example from the cycle, which cannot create a dialogue itself. The engine
/// polls it on every step (MailboxEngine::watch()).
class DialogueRequest {
 public:
  virtual ~DialogueRequest() = default;
  /// Position of the slave that it addresses. \rtsafe
  [[nodiscard]] virtual std::uint16_t position() const noexcept = 0;
  /// The dialogue that executes the request, once per request; else null.
  [[nodiscard]] virtual std::shared_ptr<MailboxDialogue> take() = 0;
};

}  // namespace driveline::ecat_master

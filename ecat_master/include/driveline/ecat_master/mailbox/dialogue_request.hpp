#pragma once

#include <cstdint>
#include <memory>

#include "driveline/ecat_master/mailbox/dialogue.hpp"

namespace driveline::ecat_master {

/// Something that becomes a dialogue when it is asked for, by the cycle say, which cannot make one itself. The engine
/// looks whenever it steps (MailboxEngine::watch()).
class DialogueRequest {
 public:
  virtual ~DialogueRequest() = default;
  /// Position of the slave whose mailbox it goes to. \rtsafe
  [[nodiscard]] virtual std::uint16_t position() const noexcept = 0;
  /// The dialogue that carries the request out, once for every time it is asked for; else null.
  [[nodiscard]] virtual std::shared_ptr<MailboxDialogue> take() = 0;
};

}  // namespace driveline::ecat_master

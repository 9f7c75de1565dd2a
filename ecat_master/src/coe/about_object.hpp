#pragma once

#include "driveline/ecat_master/error.hpp"

namespace driveline::ecat_master {

/// What the mailbox channel tells, with the object that it was about; other errors name what they are about themselves.
[[nodiscard]] inline Error about_object(Error error, facts::ObjectAddress object) noexcept {
  if (auto* timeout = std::get_if<facts::MailboxTimeout>(&error.facts)) timeout->object = object;
  if (auto* refused = std::get_if<facts::MailboxError>(&error.facts)) refused->object = object;
  if (auto* malformed = std::get_if<facts::MailboxMalformed>(&error.facts)) malformed->object = object;
  return error;
}

}  // namespace driveline::ecat_master

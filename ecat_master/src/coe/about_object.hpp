#pragma once

#include "driveline/ecat_master/error.hpp"

namespace driveline::ecat_master {

/// Adds the object to an error of the mailbox channel; other errors already name their object.
[[nodiscard]] inline Error about_object(Error error, facts::ObjectAddress object) noexcept {
  if (auto* timeout = std::get_if<facts::MailboxTimeout>(&error.facts)) timeout->object = object;
  if (auto* refused = std::get_if<facts::MailboxError>(&error.facts)) refused->object = object;
  if (auto* malformed = std::get_if<facts::MailboxMalformed>(&error.facts)) malformed->object = object;
  return error;
}

}  // namespace driveline::ecat_master

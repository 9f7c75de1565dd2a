#include "failure.hpp"

namespace driveline::cli {
namespace {

/// The option that overrides or avoids an error of this kind.
std::string_view remedy(runtime::ErrorKind kind) {
  switch (kind) {
    case runtime::ErrorKind::kInterfaceBusy:
    case runtime::ErrorKind::kLineDriven:
      return "; --force does it all the same";
    case runtime::ErrorKind::kFolderBusy:
      return "; --output FOLDER names one of its own";
    default:
      return "";
  }
}

/// Replaces names of settings by those of the command line's options.
std::string sentence_of(const runtime::Error& error) {
  if (error.place != "interface2") return runtime::describe(error).append(remedy(error.kind));
  return "--iface2: " + error.reason + " (--iface NAME)";
}

int status_of(runtime::ErrorKind kind) {
  using enum runtime::ErrorKind;
  return kind == kFile || kind == kSetting || kind == kCall ? 2 : 1;
}

}  // namespace

Failure::Failure(const runtime::Error& error) : status(status_of(error.kind)), text(sentence_of(error)) {}

}  // namespace driveline::cli

#include "failure.hpp"

namespace driveline::cli {
namespace {

/// The option that does it all the same, or that helps.
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

/// What is `interface2` in a line description is an option here.
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

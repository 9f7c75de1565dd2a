#include "failure.hpp"

namespace driveline::cli {
namespace {

/// Names the option that overrides or avoids an error of this kind; empty: there is none.
std::string_view remedy(runtime::ErrorKind kind) {
  switch (kind) {
    case runtime::ErrorKind::kInterfaceBusy:
    case runtime::ErrorKind::kLineDriven:
      return "; --force does it anyway";
    case runtime::ErrorKind::kFolderBusy:
      return "; --output FOLDER selects another folder";
    default:
      return "";
  }
}

/// Describes the error with the names of command-line options instead of those of settings.
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

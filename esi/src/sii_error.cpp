#include <fmt/format.h>

#include "driveline/esi/sii.hpp"

namespace driveline::esi {
namespace {

std::string_view problem(SiiErrorCode code) {
  switch (code) {
    case SiiErrorCode::kOddSize:
      return "the image is not a whole number of 16-bit words";
    case SiiErrorCode::kNoHeader:
      return "the image is shorter than the fixed area";
    case SiiErrorCode::kNoEnd:
      return "the image has no end category (0xFFFF)";
    case SiiErrorCode::kLongCategory:
      return "the category is longer than the image";
    case SiiErrorCode::kBadSize:
      return "the category's size does not fit its elements";
    case SiiErrorCode::kLongText:
      return "a string is longer than its category";
    case SiiErrorCode::kLongEntryList:
      return "a PDO has more entries than its category contains";
  }
  return "the image cannot be decoded";
}

}  // namespace

std::string to_text(const SiiError& error) {
  std::string text = fmt::format("SII word 0x{:04X}", error.word_offset);
  if (error.category != SiiCategoryType::kEnd) {
    text += fmt::format(", category {}", static_cast<unsigned>(error.category));
  }
  return text + fmt::format(": {} ({} bytes needed, {} there)", problem(error.code), error.needed_bytes,
                            error.available_bytes);
}

}  // namespace driveline::esi

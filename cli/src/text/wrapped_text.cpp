#include "text/wrapped_text.hpp"

#include <algorithm>

namespace driveline::cli {

std::string wrapped(std::string_view prefix, std::string_view text) {
  const std::size_t indent = prefix.size();
  std::string lines(prefix);
  std::size_t column = indent;
  for (bool first = true; !text.empty(); first = false) {
    const auto word = text.substr(0, std::min(text.find(' '), text.size()));
    text.remove_prefix(std::min(word.size() + 1, text.size()));
    const bool begins = column == indent;
    if (!begins && column + 1 + word.size() > kTextColumns) {
      lines += '\n' + std::string(indent, ' ');
      column = indent;
    } else if (!first) {
      lines += ' ';
      ++column;
    }
    lines += word;
    column += word.size();
  }
  return lines;
}

std::string shortened(std::string_view text, std::size_t columns) {
  constexpr std::string_view kRest = "...";
  // A character of UTF-8 has one byte that is not 10xxxxxx.
  const auto begins = [](char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U; };
  if (static_cast<std::size_t>(std::count_if(text.begin(), text.end(), begins)) <= columns) return std::string(text);
  std::size_t characters = 0;
  const auto end = std::find_if(text.begin(), text.end(),
                                [&](char byte) { return begins(byte) && ++characters > columns - kRest.size(); });
  return std::string(text.begin(), end).append(kRest);
}

}  // namespace driveline::cli

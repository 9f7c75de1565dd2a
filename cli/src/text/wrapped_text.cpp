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

}  // namespace driveline::cli

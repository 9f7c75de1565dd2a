#include "toml/toml_depth.hpp"

#include <algorithm>

namespace driveline::runtime {
namespace {

constexpr std::size_t kQuotesOfBlock = 3;  ///< quotes around a multi-line string

bool is_toml_blank(char c) noexcept {
  return c == ' ' || c == '\t';
}

bool is_toml_bare(char c) noexcept {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
         static_cast<unsigned char>(c) >= 0x80;  // non-ASCII letters and blanks
}

/// Scans TOML text and counts levels; knows only the parts of the language that may hide a dot or a bracket.
class DepthScan {
 public:
  explicit DepthScan(std::string_view text) noexcept : text_(text) {}

  std::optional<std::size_t> run() noexcept {
    while (at_ < text_.size()) {
      step(text_[at_]);
      if (dots_ >= kMaxTomlDepth || brackets_ > kMaxTomlDepth) return line_;
    }
    return std::nullopt;
  }

 private:
  void step(char c) noexcept {
    if (c == '#') {
      at_ = std::min(text_.find('\n', at_), text_.size());
    } else if (c == '"' || c == '\'') {
      skip_string(c);
    } else {
      count(c);
      ++at_;
    }
  }

  void count(char c) noexcept {
    if (c == '\n') ++line_;
    if (c == '.') ++dots_;
    // The parts of a dotted key may have blanks in between; any other character starts another key.
    if (c != '.' && !is_toml_bare(c) && !is_toml_blank(c)) dots_ = 0;
    if (c == '[' || c == '{') ++brackets_;
    if ((c == ']' || c == '}') && brackets_ > 0) --brackets_;
  }

  /// Skips a string that starts here with `quote`; an unterminated one extends to the end of its line, or of the text.
  void skip_string(char quote) noexcept {
    const bool block = text_.substr(at_).starts_with(std::string_view(quote == '"' ? "\"\"\"" : "'''"));
    at_ += block ? kQuotesOfBlock : 1;
    std::size_t quotes = 0;
    for (; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      if (c == '\n') {
        if (!block) return;
        ++line_;
      }
      quotes = c == quote ? quotes + 1 : 0;
      if (c == '\\' && quote == '"' && at_ + 1 < text_.size() && text_[at_ + 1] != '\n') ++at_;
      // Up to two quotes may precede the three that end a multi-line string.
      const bool more = at_ + 1 < text_.size() && text_[at_ + 1] == quote;
      if (quotes >= (block ? kQuotesOfBlock : 1) && !(block && more && quotes < kQuotesOfBlock + 2)) {
        ++at_;
        return;
      }
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
  std::size_t dots_ = 0;
  std::size_t brackets_ = 0;
};

}  // namespace

std::optional<std::size_t> too_deep_line(std::string_view toml) noexcept {
  return DepthScan(toml).run();
}

}  // namespace driveline::runtime

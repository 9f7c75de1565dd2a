// Texts of files and slaves cannot control the terminal.
#include "text/visible_text.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "text/json_text.hpp"

namespace driveline::cli {
namespace {

TEST(VisibleText, ControlCharactersAreShownAndNotObeyed) {
  EXPECT_EQ(visible_text("a\x1b[31mred\x1b]0;title\x07"), "a\\x1B[31mred\\x1B]0;title\\x07");
  EXPECT_EQ(visible_text("over\rwritten\b\x7f"), "over\\x0Dwritten\\x08\\x7F");
  EXPECT_EQ(visible_text("\xC2\x9B"
                         "2J"),
            "\\x9B2J")
      << "as one character, too";
  EXPECT_EQ(visible_text(std::string_view("\0", 1)), "\\x00");
}

TEST(VisibleText, TextStaysAsItIs) {
  for (const char* text :
       {"", "two\nlines\tand a tab", "Eing\xC3\xA4nge \xE2\x82\xAC \xF0\x9F\x98\x80", "\\x1B[0m", "\xC2\xA0"}) {
    EXPECT_EQ(visible_text(text), text);
  }
}

TEST(VisibleText, WhatIsNoUtf8IsShownByteByByte) {
  EXPECT_EQ(visible_text("\x9b"), "\\x9B") << "on a terminal of 8 bits";
  EXPECT_EQ(visible_text("\xC0\x9B"), "\\xC0\\x9B") << "a longer way to write ESC";
  EXPECT_EQ(visible_text("\xE0\x82\x9B"), "\\xE0\\x82\\x9B");
  EXPECT_EQ(visible_text("a\xC3"), "a\\xC3") << "cut off";
  EXPECT_EQ(visible_text("\xC3\x1b"), "\\xC3\\x1B");
  EXPECT_EQ(visible_text("\xED\xA0\x80"), "\\xED\\xA0\\x80") << "a surrogate";
  EXPECT_EQ(visible_text("\xF4\x90\x80\x80"), "\\xF4\\x90\\x80\\x80") << "beyond the last character";
}

TEST(VisibleText, JsonStaysJson) {
  const std::string name =
      "a\x1b[m\xC2\x9B"
      "2J\x7f\x9b\xC3\xA4";
  const auto text = json_text({{"name", name}});
  EXPECT_EQ(text, "{\n  \"name\": \"a\\u001b[m\\u009B2J\\u007F\xEF\xBF\xBD\xC3\xA4\"\n}\n");
  EXPECT_EQ(visible_text(text), text);
  EXPECT_EQ(nlohmann::json::parse(text)["name"],
            "a\x1b[m\xC2\x9B"
            "2J\x7f\xEF\xBF\xBD\xC3\xA4");
}

}  // namespace
}  // namespace driveline::cli

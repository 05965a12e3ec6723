#include "hal/base/text.hpp"

#include <gtest/gtest.h>

namespace onemap {
namespace {

using namespace std::string_literals;

TEST(Printable, PlainTextStaysAsItIs) {
  for (const std::string& text : {""s, "robot-1"s, "a\\b \"c\""s, "Küche"s, "日本"s, "🤖"s})
    EXPECT_EQ(printable(text), text);
}

TEST(Printable, ControlCharactersAreSpeltOut) {
  EXPECT_EQ(printable("a\nroot: x"), "a\\x0aroot: x");
  EXPECT_EQ(printable("\x1b[31m"), "\\x1b[31m");
  EXPECT_EQ(printable("a\0b"s), "a\\x00b");
  EXPECT_EQ(printable("\x7f"), "\\x7f");
  EXPECT_EQ(printable("\u0085"), "\\xc2\\x85") << "C1: a terminal may obey it";
}

TEST(Printable, WhatTurnsLinesAroundIsSpeltOut) {
  EXPECT_EQ(printable("\u202Etxt.exe"), "\\xe2\\x80\\xaetxt.exe");
  EXPECT_EQ(printable("\u2028"), "\\xe2\\x80\\xa8");
  EXPECT_EQ(printable("\u2066"), "\\xe2\\x81\\xa6");
  EXPECT_EQ(printable("\u200B"), "\\xe2\\x80\\x8b") << "a name that looks like another";
}

TEST(Printable, WhatIsNotUtf8IsSpeltOutByteByByte) {
  EXPECT_EQ(printable("!\xff\xfe"), "!\\xff\\xfe");
  EXPECT_EQ(printable("\xc0\xaf"), "\\xc0\\xaf") << "overlong";
  EXPECT_EQ(printable("\xe0\x80\xaf"), "\\xe0\\x80\\xaf") << "overlong";
  EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80") << "a surrogate";
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80") << "beyond the last code";
  EXPECT_EQ(printable("\xf5\x80\x80\x80"), "\\xf5\\x80\\x80\\x80");
  EXPECT_EQ(printable("K\xc3"), "K\\xc3") << "cut short";
  EXPECT_EQ(printable("\xc3(x"), "\\xc3(x");
}

}  // namespace
}  // namespace onemap

#include "common/base/utf8.h"

#include <string>

#include <gmock/gmock.h>

namespace cohort {
namespace {

TEST(IsValidUtf8, TakesEveryLengthOfCharacter) {
  for (const char* text : {"", "face.ply", "\xC3\xA9", "\xE2\x82\xAC", "\xF0\x9F\x98\x80"}) {
    EXPECT_TRUE(IsValidUtf8(text)) << text;
  }
}

TEST(IsValidUtf8, RefusesWhatIsNotWellFormed) {
  // Latin-1, a lone continuation, cut short, overlong, surrogate, beyond U+10FFFF.
  for (const char* text : {"\xE9.ply", "\x80", "\xE2\x82", "\xC0\xAF", "\xE0\x80\xAF",
                           "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xFF"}) {
    EXPECT_FALSE(IsValidUtf8(text)) << text;
  }
}

TEST(PrintableUtf8, KeepsWhatIsWellFormed) {
  EXPECT_EQ(PrintableUtf8("Žluťoučký kůň, 漢字 😀.ply"), "Žluťoučký kůň, 漢字 😀.ply");
}

TEST(PrintableUtf8, ReplacesBrokenBytesAndControls) {
  EXPECT_EQ(PrintableUtf8("a\xff"
                          "b"),
            "a\uFFFDb");
  EXPECT_EQ(PrintableUtf8("\xc3"), "\uFFFD");                      // Cut short.
  EXPECT_EQ(PrintableUtf8("\xc0\x80"), "\uFFFD\uFFFD");            // Overlong.
  EXPECT_EQ(PrintableUtf8("\xed\xa0\x80"), "\uFFFD\uFFFD\uFFFD");  // Surrogate.
  EXPECT_EQ(PrintableUtf8("\xf4\x90\x80\x80"), "\uFFFD\uFFFD\uFFFD\uFFFD");
  EXPECT_EQ(PrintableUtf8("a\tb\x7f"), "a\uFFFDb\uFFFD");
}

}  // namespace
}  // namespace cohort

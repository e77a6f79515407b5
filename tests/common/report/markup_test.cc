#include "common/report/markup.h"

#include <gtest/gtest.h>

namespace cohort {
namespace {

TEST(EscapeMarkup, NothingThatEndsATextOrAnAttributeIsLeft) {
  EXPECT_EQ(EscapeMarkup("<b a=\"1\" c='2'>&amp;"),
            "&lt;b a=&quot;1&quot; c=&#39;2&#39;&gt;&amp;amp;");
}

TEST(EscapeMarkup, KeepsForeignLettersAndReplacesWhatNoPageCanHold) {
  EXPECT_EQ(EscapeMarkup("Žofie 顔"), "Žofie 顔");
  EXPECT_EQ(EscapeMarkup("a\xff\nb"), "a\uFFFD\uFFFDb");
}

TEST(Base64, AgreesWithTheVectorsOfRfc4648) {
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Base64("f"), "Zg==");
  EXPECT_EQ(Base64("fo"), "Zm8=");
  EXPECT_EQ(Base64("foo"), "Zm9v");
  EXPECT_EQ(Base64("foob"), "Zm9vYg==");
  EXPECT_EQ(Base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(Base64("foobar"), "Zm9vYmFy");
}

TEST(Base64, TakesAllBytes) {
  EXPECT_EQ(Base64(std::string("\x00\xff\x80", 3)), "AP+A");
}

}  // namespace
}  // namespace cohort

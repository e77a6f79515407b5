#include "common/base/gmac.h"

#include <set>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

namespace cohort {
namespace {

std::string Of(std::string_view bytes) {
  Gmac gmac;
  gmac.Update(bytes);
  return gmac.Finish();
}

TEST(Gmac, IsThePublishedOneOfNothing) {
  // McGrew, Viega, "The Galois/Counter Mode of Operation", test case 1: no data, key and IV zero.
  EXPECT_EQ(Of(""),
            std::string("\x58\xe2\xfc\xce\xfa\x7e\x30\x61\x36\x7f\x1d\x57\xa4\xe7\x45\x5a"));
}

TEST(Gmac, DoesNotDependOnThePieces) {
  const std::string bytes(1000, 'x');
  for (const size_t first : {0, 1, 15, 16, 17, 999, 1000}) {
    Gmac gmac;
    gmac.Update(std::string_view(bytes).substr(0, first));
    gmac.Update(std::string_view(bytes).substr(first));
    EXPECT_EQ(gmac.Finish(), Of(bytes)) << first;
  }
}

TEST(Gmac, ChangesWithEveryBitAndWithTheLength) {
  std::string bytes(40, '\0');
  std::set<std::string> checks = {Of(bytes), Of(std::string(39, '\0')), Of(std::string(41, '\0')),
                                  Of("")};
  for (size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    std::string flipped = bytes;
    flipped[bit / 8] = static_cast<char>(1 << (bit % 8));
    checks.insert(Of(flipped));
  }
  EXPECT_EQ(checks.size(), 4 + 8 * bytes.size());
}

}  // namespace
}  // namespace cohort

#include "common/base/sha256.h"

#include <string>

#include <gtest/gtest.h>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOkAndHolds;
using testing::StatusIs;

constexpr char kOfNothing[] = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";

// Expected values: FIPS 180-4 example files of NIST.
TEST(Sha256, AgreesWithThePublishedExamples) {
  EXPECT_EQ(Sha256::Of("").Hex(), kOfNothing);
  EXPECT_EQ(Sha256::Of("abc").Hex(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(Sha256::Of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq").Hex(),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(Sha256::Of(std::string(1'000'000, 'a')).Hex(),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, OfPiecesIsThatOfTheWhole) {
  Sha256 hash;
  hash.Update("a");
  hash.Update("");
  hash.Update("bc");

  EXPECT_EQ(hash.Finish(), Sha256::Of("abc"));
}

TEST(Digest, ComesBackFromItsHex) {
  EXPECT_THAT(Digest::FromHex(Sha256::Of("abc").Hex()), IsOkAndHolds(Sha256::Of("abc")));
}

TEST(Digest, RefusesWhatIsNotSixtyFourLowerCaseHexDigits) {
  const std::string valid(kOfNothing);
  std::string upper = valid;
  upper[0] = 'E';

  EXPECT_THAT(Digest::FromHex(""), StatusIs(absl::StatusCode::kInvalidArgument, "''"));
  EXPECT_THAT(Digest::FromHex(valid.substr(1)),
              StatusIs(absl::StatusCode::kInvalidArgument, valid.substr(1)));
  EXPECT_THAT(Digest::FromHex(valid + "0"), StatusIs(absl::StatusCode::kInvalidArgument, valid));
  EXPECT_THAT(Digest::FromHex(upper), StatusIs(absl::StatusCode::kInvalidArgument, upper));
}

TEST(Digest, IsEmptyUntilItIsComputed) {
  EXPECT_TRUE(Digest().empty());
  EXPECT_FALSE(Sha256::Of("").empty());
}

}  // namespace
}  // namespace cohort

#include "common/store/memory_blob_store.h"

#include <gtest/gtest.h>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::IsOkAndHolds;
using testing::StatusIs;

TEST(MemoryBlobStore, GivesBackWhatWasPut) {
  MemoryBlobStore store;

  ASSERT_THAT(store.Put("abc"), IsOkAndHolds(Sha256::Of("abc")));

  EXPECT_THAT(store.Get(Sha256::Of("abc")), IsOkAndHolds(std::string("abc")));
  EXPECT_THAT(store.Contains(Sha256::Of("abc")), IsOkAndHolds(true));
}

TEST(MemoryBlobStore, NamesTheBlobThatIsMissing) {
  MemoryBlobStore store;
  const Digest digest = Sha256::Of("never put");

  EXPECT_THAT(store.Get(digest), StatusIs(absl::StatusCode::kNotFound, digest.Hex()));
  EXPECT_THAT(store.Contains(digest), IsOkAndHolds(false));
}

TEST(MemoryBlobStore, ReadsInPieces) {
  MemoryBlobStore store;
  const Digest digest = store.Put("abcdefgh").value();
  const std::unique_ptr<BlobReader> reader = store.Open(digest).value();

  EXPECT_EQ(reader->SizeBytes(), 8);
  EXPECT_THAT(reader->Read(5), IsOkAndHolds(std::string("abcde")));
  EXPECT_THAT(reader->Read(5), IsOkAndHolds(std::string("fgh")));
  EXPECT_THAT(reader->Read(5), IsOkAndHolds(std::string()));
}

TEST(MemoryBlobStore, ForgetsAnAbortedWrite) {
  MemoryBlobStore store;

  ASSERT_THAT(store.StartPut().value()->Append("abc"), IsOk());

  EXPECT_THAT(store.Contains(Sha256::Of("abc")), IsOkAndHolds(false));
}

}  // namespace
}  // namespace cohort

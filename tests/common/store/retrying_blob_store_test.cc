#include "common/store/retrying_blob_store.h"

#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "common/store/memory_blob_store.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::StatusIs;

/// A store that cannot be reached for some calls.
class AbsentStore final : public BlobStore {
 public:
  absl::StatusOr<std::unique_ptr<BlobWriter>> StartPut() override {
    if (absl::Status status = Answer(); !status.ok()) {
      return status;
    }
    return inner.StartPut();
  }
  absl::StatusOr<std::unique_ptr<BlobReader>> Open(const Digest& digest) override {
    if (absl::Status status = Answer(); !status.ok()) {
      return status;
    }
    return inner.Open(digest);
  }
  absl::StatusOr<bool> Contains(const Digest& digest) override {
    if (absl::Status status = Answer(); !status.ok()) {
      return status;
    }
    return inner.Contains(digest);
  }

  MemoryBlobStore inner;
  int calls = 0;
  int failures = 0;
  absl::Status failure = absl::UnavailableError("nobody answers");

 private:
  absl::Status Answer() {
    ++calls;
    return calls <= failures ? failure : absl::OkStatus();
  }
};

constexpr Patience kQuick{
    .first_pause_seconds = 0.001, .longest_pause_seconds = 0.004, .total_seconds = 5};

class RetryingBlobStoreTest : public ::testing::Test {
 protected:
  void Make(const Patience& patience) {
    auto absent = std::make_unique<AbsentStore>();
    absent_ = absent.get();
    store_ = std::make_unique<RetryingBlobStore>(std::move(absent), patience, stop_.get_token());
  }
  AbsentStore* absent_ = nullptr;
  std::stop_source stop_;
  std::unique_ptr<RetryingBlobStore> store_;
};

TEST_F(RetryingBlobStoreTest, WritesManyBlobsOnceTheStoreIsBack) {
  Make(kQuick);
  absent_->failures = 3;
  const std::vector<std::string_view> blobs = {"one", "two"};

  const auto digests = store_->PutAll(blobs);

  ASSERT_THAT(digests, IsOk());
  EXPECT_EQ(*digests, (std::vector<Digest>{Sha256::Of("one"), Sha256::Of("two")}));
  EXPECT_EQ(absent_->calls, 5);
}

TEST_F(RetryingBlobStoreTest, WritesAndReadsOnceTheStoreIsBack) {
  Make(kQuick);
  absent_->failures = 4;
  const auto digest = store_->Put("some bytes");
  ASSERT_THAT(digest, IsOk());
  EXPECT_EQ(*digest, Sha256::Of("some bytes"));
  EXPECT_EQ(absent_->calls, 5);
  absent_->calls = 0;
  EXPECT_EQ(*store_->Get(*digest), "some bytes");
  absent_->calls = 0;
  EXPECT_TRUE(*store_->Contains(*digest));
  EXPECT_EQ(absent_->calls, 5);
}

TEST_F(RetryingBlobStoreTest, DoesNotRepeatWhatCannotSucceed) {
  Make(kQuick);
  EXPECT_THAT(store_->Get(Sha256::Of("never written")), StatusIs(absl::StatusCode::kNotFound, ""));
  EXPECT_EQ(absent_->calls, 1);
  absent_->failures = 99;
  absent_->failure = absl::DataLossError("damaged");
  EXPECT_THAT(store_->Get(Sha256::Of("damaged")), StatusIs(absl::StatusCode::kDataLoss, ""));
  EXPECT_EQ(absent_->calls, 2);
}

TEST_F(RetryingBlobStoreTest, EndsWithTheLastErrorWhenPatienceEnds) {
  Make({.first_pause_seconds = 0.001, .longest_pause_seconds = 0.004, .total_seconds = 0.05});
  absent_->failures = 1'000'000;
  EXPECT_THAT(store_->Put("x"), StatusIs(absl::StatusCode::kUnavailable, "nobody answers"));
  EXPECT_GT(absent_->calls, 3);
}

TEST_F(RetryingBlobStoreTest, EndsAtOnceWhenItIsStopped) {
  Make({.first_pause_seconds = 1000, .longest_pause_seconds = 1000, .total_seconds = 100'000});
  absent_->failures = 1'000'000;
  std::thread stopping([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    stop_.request_stop();
  });
  EXPECT_THAT(store_->Put("x"), StatusIs(absl::StatusCode::kUnavailable, "nobody answers"));
  stopping.join();
}

}  // namespace
}  // namespace cohort

#include "worker/retry_pause.h"

#include <gtest/gtest.h>

namespace cohort {
namespace {

TEST(RetryPauseTest, DoublesUpToTenSeconds) {
  RetryPause pause;
  EXPECT_DOUBLE_EQ(pause.Next(60), 0.2);
  EXPECT_DOUBLE_EQ(pause.Next(60), 0.4);
  EXPECT_DOUBLE_EQ(pause.Next(60), 0.8);
  for (int i = 0; i < 20; ++i) {
    EXPECT_LE(pause.Next(60), 10);
  }
  EXPECT_DOUBLE_EQ(pause.Next(60), 10);
  EXPECT_DOUBLE_EQ(pause.Next(600), 10);
}

TEST(RetryPauseTest, TriesSeveralTimesInOneLease) {
  RetryPause pause;
  double waited = 0;
  for (int i = 0; i < 10; ++i) {
    const double next = pause.Next(5);
    EXPECT_LE(next, 5.0 / 6);
    waited += next;
  }
  EXPECT_GT(waited, 5);
}

TEST(RetryPauseTest, BeginsAnewOnceTheServerHasAnswered) {
  RetryPause pause;
  for (int i = 0; i < 5; ++i) {
    (void)pause.Next(60);
  }
  pause.Reset();
  EXPECT_DOUBLE_EQ(pause.Next(60), 0.2);
}

}  // namespace
}  // namespace cohort

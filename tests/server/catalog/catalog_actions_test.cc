// Results that are remembered, and completions that are saved together.

#include <chrono>
#include <iostream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "server/catalog/catalog.h"
#include "tests/server/catalog/catalog_fixture.h"

namespace cohort {
namespace {

using testing::CatalogTest;
using testing::DatabaseName;
using testing::EachDatabase;
using testing::IsOk;
using testing::SomeJob;
using testing::SomeMesh;
using testing::SomeResult;
using testing::SomeTask;
using testing::StatusIs;

class CatalogActionsTest : public CatalogTest {};

Completion Done(const Job& job, int64_t number, const std::string& action_key) {
  Completion completion{
      .job = job, .task = SomeTask(number), .ingested = {}, .action_key = action_key};
  completion.task.result = SomeResult();
  completion.task.result->output = Sha256::Of(std::to_string(number));
  return completion;
}

TEST_P(CatalogActionsTest, SavesCompletionsOfSeveralJobsAtOnce) {
  Job first = catalog_->CreateJob(SomeJob("s"), {SomeMesh("a")}, "", 1).value();
  Job second = catalog_->CreateJob(SomeJob("s"), {SomeMesh("a")}, "", 1).value();
  std::vector<Completion> completions;
  for (int64_t number = 1; number <= 3; ++number) {
    ++first.version;
    completions.push_back(Done(first, number, "first " + std::to_string(number)));
    ++second.version;
    completions.push_back(Done(second, number, ""));
  }

  ASSERT_THAT(catalog_->SaveCompletions(completions, 7), IsOk());
  Reopen();

  EXPECT_EQ(catalog_->GetJob(first.id)->version, 3);
  EXPECT_EQ(catalog_->GetJob(second.id)->version, 3);
  const std::vector<TaskRecord> tasks = testing::LoadTasks(*catalog_, second.id).value();
  ASSERT_EQ(tasks.size(), 3u);
  EXPECT_EQ(tasks[2].result->output, Sha256::Of("3"));
  EXPECT_EQ(testing::LoadTasks(*catalog_, first.id)->size(), 3u);
  const auto known = catalog_->FindActions({"first 1", "first 2", "first 3", ""}).value();
  EXPECT_EQ(known.size(), 3u);
}

TEST_P(CatalogActionsTest, SavesNoneWhenOneIsOfAMissingJob) {
  const Job job = catalog_->CreateJob(SomeJob("s"), {}, "", 1).value();
  Job missing = job;
  missing.id.value = "j-000077";

  EXPECT_THAT(catalog_->SaveCompletions({{Done(job, 1, "k"), Done(missing, 1, "l")}}, 1),
              StatusIs(absl::StatusCode::kNotFound, "j-000077"));

  EXPECT_TRUE(testing::LoadTasks(*catalog_, job.id)->empty());
  EXPECT_TRUE(catalog_->FindActions({"k", "l"})->empty());
}

TEST_P(CatalogActionsTest, SavesNothingOfNothing) {
  EXPECT_THAT(catalog_->SaveCompletions({}, 1), IsOk());
}

TEST_P(CatalogActionsTest, FindsWhatIsKnownOfManyKeysAndNothingElse) {
  const Job job = catalog_->CreateJob(SomeJob("s"), {}, "", 1).value();
  std::vector<Completion> completions;
  std::vector<std::string> keys;
  for (int64_t number = 0; number < 1'700; ++number) {
    keys.push_back(Sha256::Of("key " + std::to_string(number)).Hex());
    if (number % 2 == 0) {
      completions.push_back(Done(job, number, keys.back()));
    }
  }
  ASSERT_THAT(catalog_->SaveCompletions(completions, 1), IsOk());

  const auto found = catalog_->FindActions(keys).value();

  EXPECT_EQ(found.size(), 850u);
  EXPECT_EQ(ToJson(found.at(keys[1'698])), ToJson(*completions.back().task.result));
  EXPECT_EQ(found.count(keys[1'699]), 0u);
  EXPECT_TRUE(catalog_->FindActions({})->empty());
}

TEST_P(CatalogActionsTest, RemembersTheNewestResultOfAKey) {
  const Job job = catalog_->CreateJob(SomeJob("s"), {}, "", 1).value();
  ASSERT_THAT(catalog_->SaveCompletions({{Done(job, 1, "k")}}, 1), IsOk());
  ASSERT_THAT(catalog_->SaveCompletions({{Done(job, 2, "k")}}, 2), IsOk());

  EXPECT_EQ(catalog_->FindActions({"k"})->at("k").output, Sha256::Of("2"));
}

TEST_P(CatalogActionsTest, ForgetsResultsOlderThanATime) {
  const Job job = catalog_->CreateJob(SomeJob("s"), {}, "", 1).value();
  ASSERT_THAT(catalog_->SaveCompletions({{Done(job, 1, "old"), Done(job, 2, "used")}}, 10), IsOk());
  ASSERT_THAT(catalog_->SaveCompletions({{Done(job, 3, "new"), Done(job, 2, "used")}}, 20), IsOk());

  EXPECT_EQ(catalog_->ForgetActions(20).value(), 1);

  EXPECT_EQ(catalog_->FindActions({"old", "used", "new"})->size(), 2u);
  EXPECT_EQ(catalog_->ForgetActions(20).value(), 0);
}

TEST_P(CatalogActionsTest, TellsHowManyCompletionsASecondItSavesAloneAndTogether) {
  const Job job = catalog_->CreateJob(SomeJob("s"), {}, "", 1).value();
  int64_t number = 0;
  double rate = 0;
  for (const int together : {1, 10, 100}) {
    const auto start = std::chrono::steady_clock::now();
    std::chrono::duration<double> seconds(0);
    int64_t transactions = 0;
    for (; seconds.count() < 1; ++transactions) {
      std::vector<Completion> completions;
      for (int i = 0; i < together; ++i, ++number) {
        completions.push_back(Done(job, number, Sha256::Of(std::to_string(number)).Hex()));
      }
      ASSERT_THAT(catalog_->SaveCompletions(completions, 1), IsOk());
      seconds = std::chrono::steady_clock::now() - start;
    }
    rate = static_cast<double>(transactions * together) / seconds.count();
    std::cout << DatabaseName({GetParam(), 0}) << ": " << together
              << " together: " << static_cast<double>(transactions) / seconds.count()
              << " transactions/s, " << rate << " completions/s\n";
  }
  EXPECT_GT(rate, 0);
  EXPECT_EQ(std::ssize(*testing::LoadTasks(*catalog_, job.id)), number);
}

INSTANTIATE_TEST_SUITE_P(On, CatalogActionsTest, EachDatabase(), DatabaseName);

}  // namespace
}  // namespace cohort

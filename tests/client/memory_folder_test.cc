#include "client/memory_folder.h"

#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "tests/common/store/scratch_folder.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

/// The number of a process that has ended.
int DeadProcess() {
  const int child = fork();
  if (child == 0) {
    _exit(0);
  }
  waitpid(child, nullptr, 0);
  return child;
}

TEST(MemoryFolderTest, IsThereUntilItsObjectGoes) {
  const testing::ScratchFolder root;
  auto folder = MemoryFolder::Create(root.Path());
  ASSERT_NE(folder, nullptr);
  const fs::path path = folder->Path();
  EXPECT_EQ(path.parent_path(), root.Path());
  EXPECT_GE(folder->Megabytes(), 16);
  EXPECT_LE(folder->Megabytes(), 2048);
  std::ofstream(path / "file") << "kept";
  EXPECT_EQ(fs::status(path).permissions() & fs::perms::others_all, fs::perms::none);

  folder.reset();

  EXPECT_FALSE(fs::exists(path));
}

TEST(MemoryFolderTest, WhatDeadProcessesLeftIsRemovedAndNothingElse) {
  const testing::ScratchFolder root;
  const fs::path dead = root.Path() / ("cohort-run-" + std::to_string(DeadProcess()) + "-a1B2c3");
  const fs::path alive = root.Path() / ("cohort-run-" + std::to_string(getppid()) + "-a1B2c3");
  const fs::path other = root.Path() / "cohort-run-x";
  for (const fs::path& path : {dead, alive, other}) {
    fs::create_directories(path / "below");
  }

  const auto folder = MemoryFolder::Create(root.Path());

  ASSERT_NE(folder, nullptr);
  EXPECT_FALSE(fs::exists(dead));
  EXPECT_TRUE(fs::exists(alive));
  EXPECT_TRUE(fs::exists(other));
}

TEST(MemoryFolderTest, OneProcessMayHaveSeveral) {
  const testing::ScratchFolder root;
  const auto one = MemoryFolder::Create(root.Path());
  auto two = MemoryFolder::Create(root.Path());
  ASSERT_NE(two, nullptr);
  EXPECT_NE(one->Path(), two->Path());

  two.reset();

  EXPECT_TRUE(fs::exists(one->Path()));
}

TEST(MemoryFolderTest, NoRootIsNoFolder) {
  EXPECT_EQ(MemoryFolder::Create("/nowhere/at/all"), nullptr);
}

}  // namespace
}  // namespace cohort

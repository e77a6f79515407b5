#include "common/base/scratch.h"

#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

namespace cohort {
namespace {

constexpr size_t kLarge = kScratchFileBytes / sizeof(double);

/// The file that an address of this process lies in, or "".
std::string FileOf(const void* memory) {
  const auto address = reinterpret_cast<uintptr_t>(memory);
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    uintptr_t begin = 0;
    uintptr_t end = 0;
    if (std::sscanf(line.c_str(), "%" SCNxPTR "-%" SCNxPTR, &begin, &end) == 2 &&
        begin <= address && address < end) {
      const size_t path = line.find('/');
      return path == std::string::npos ? "" : line.substr(path);
    }
  }
  return "";
}

/// Sets an environment variable while it lives.
class ScopedVariable {
 public:
  ScopedVariable(const char* name, const std::string& value) : name_(name) {
    const char* before = std::getenv(name);
    was_set_ = before != nullptr;
    before_ = was_set_ ? before : "";
    setenv(name, value.c_str(), 1);
  }
  ~ScopedVariable() {
    if (was_set_) {
      setenv(name_, before_.c_str(), 1);
    } else {
      unsetenv(name_);
    }
  }
  ScopedVariable(const ScopedVariable&) = delete;
  ScopedVariable& operator=(const ScopedVariable&) = delete;

 private:
  const char* name_;
  bool was_set_ = false;
  std::string before_;
};

TEST(ScratchVector, LiesInAFileOfTheTemporaryFolderWhenItIsLarge) {
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / "scratch_vector";
  std::filesystem::create_directories(folder);
  const ScopedVariable tmpdir("TMPDIR", folder.string());
  ScratchVector<double> values;
  values.reserve(kLarge);
  EXPECT_EQ(FileOf(values.data()).rfind(folder.string(), 0), 0U) << FileOf(values.data());
  values.push_back(1.5);
  values.resize(kLarge);
  values.back() = 2.5;
  EXPECT_EQ(values.front(), 1.5);
  EXPECT_EQ(values[1], 0);
  EXPECT_EQ(values.back(), 2.5);
  EXPECT_TRUE(std::filesystem::is_empty(folder)) << "nothing is left there if the process dies";
}

TEST(ScratchVector, LiesInMemoryWhenItIsSmall) {
  const ScratchVector<double> values(1000, 3.0);
  EXPECT_EQ(FileOf(values.data()), "");
  EXPECT_EQ(values[999], 3);
}

TEST(ScratchVector, LiesInMemoryWhereThereIsNoFolderForIt) {
  const ScopedVariable tmpdir("TMPDIR", "/nowhere/at/all");
  ScratchVector<double> values;
  values.reserve(kLarge);
  EXPECT_EQ(FileOf(values.data()), "");
  values.push_back(4);
  EXPECT_EQ(values.front(), 4);
}

}  // namespace
}  // namespace cohort

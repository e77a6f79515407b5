#include "common/store/shared_folder.h"

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/store/scratch_folder.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

using testing::IsOk;

class SharedFolderTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<SharedFolder> Open(int64_t max_bytes = 1'000'000) const {
    return SharedFolder::Create(folder_.Path(), max_bytes).value();
  }
  static void Keep(SharedFolder& folder, const Digest& name, std::string_view bytes) {
    const std::array pieces = {bytes.substr(0, bytes.size() / 3), bytes.substr(bytes.size() / 3)};
    folder.Keep(name, pieces);
  }
  static std::optional<std::string> Get(SharedFolder& folder, const Digest& name) {
    std::optional<std::string> got;
    const bool found = folder.Get(name, [&](std::string_view bytes) { got = std::string(bytes); });
    EXPECT_EQ(found, got.has_value());
    return got;
  }
  [[nodiscard]] fs::path FileOf(const Digest& name) const {
    return folder_.Path() / "sha256" / name.Hex().substr(0, 2) / name.Hex();
  }
  void Overwrite(const Digest& name, const std::string& bytes) const {
    fs::permissions(FileOf(name), fs::perms::owner_all);
    std::ofstream(FileOf(name), std::ios::binary | std::ios::trunc) << bytes;
  }
  [[nodiscard]] std::string FileBytesOf(const Digest& name) const {
    std::ifstream file(FileOf(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  testing::ScratchFolder folder_;
  const Digest name_ = Digest(Sha256::Of("a name"));
  const Digest other_ = Digest(Sha256::Of("another name"));
};

TEST_F(SharedFolderTest, GivesAnotherWorkerTheSameBytes) {
  Keep(*Open(), name_, "what one has computed");

  EXPECT_EQ(Get(*Open(), name_), "what one has computed");
  EXPECT_EQ(Get(*Open(), other_), std::nullopt);
}

TEST_F(SharedFolderTest, BytesLieWhereVectorsMayBeReadFrom) {
  const auto folder = Open();
  Keep(*folder, name_, std::string(1000, 'x'));

  EXPECT_TRUE(folder->Get(name_, [](std::string_view bytes) {
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(bytes.data()) % 64, 0U);
  }));
}

TEST_F(SharedFolderTest, EveryFlippedByteIsFound) {
  const auto folder = Open();
  Keep(*folder, name_, "sixteen bytes...");
  const std::string whole = FileBytesOf(name_);
  ASSERT_FALSE(whole.empty());
  for (size_t place = 0; place < whole.size(); ++place) {
    Keep(*folder, name_, "sixteen bytes...");
    std::string damaged = whole;
    damaged[place] = static_cast<char>(damaged[place] ^ 4);
    Overwrite(name_, damaged);

    EXPECT_EQ(Get(*folder, name_), std::nullopt) << "byte " << place;
    EXPECT_FALSE(fs::exists(FileOf(name_))) << "byte " << place;
  }
}

TEST_F(SharedFolderTest, FilesCutShortEmptyOrUnderAnotherNameAreFound) {
  const auto folder = Open();
  Keep(*folder, name_, "some bytes");
  const std::string whole = FileBytesOf(name_);
  for (const std::string& bytes : {std::string(), whole.substr(0, 10), whole.substr(0, 64),
                                   whole.substr(0, whole.size() - 1)}) {
    Keep(*folder, name_, "some bytes");
    Overwrite(name_, bytes);
    EXPECT_EQ(Get(*folder, name_), std::nullopt) << bytes.size() << " bytes";
  }
  Keep(*folder, other_, "other bytes");
  Overwrite(other_, whole);
  EXPECT_EQ(Get(*folder, other_), std::nullopt);
}

TEST_F(SharedFolderTest, TheLeastRecentlyUsedGoesFirst) {
  const std::string bytes(1000, 'x');
  const auto folder = Open(4400);
  const auto name = [](int i) { return Sha256::Of(std::to_string(i)); };
  const auto now = fs::file_time_type::clock::now();
  for (int i = 0; i < 4; ++i) {
    Keep(*folder, name(i), bytes);
    fs::last_write_time(FileOf(name(i)), now - std::chrono::minutes(10 - i));
  }
  ASSERT_TRUE(Get(*folder, name(0)).has_value()) << "used now";

  Keep(*folder, name(4), bytes);

  EXPECT_TRUE(fs::exists(FileOf(name(0))));
  EXPECT_FALSE(fs::exists(FileOf(name(1))));
  EXPECT_TRUE(fs::exists(FileOf(name(4))));
}

TEST_F(SharedFolderTest, LargerThanTheLimitIsNotKept) {
  const auto folder = Open(1000);

  Keep(*folder, name_, std::string(1001, 'x'));

  EXPECT_FALSE(fs::exists(FileOf(name_)));
}

TEST_F(SharedFolderTest, AFolderThatCannotBeWrittenCostsNothingElse) {
  const auto folder = Open();
  fs::remove_all(folder_.Path());

  Keep(*folder, name_, "bytes");

  EXPECT_EQ(Get(*folder, name_), std::nullopt);
}

TEST_F(SharedFolderTest, NoFolderThereIsAnError) {
  std::ofstream(folder_.Path() / "file") << "x";
  EXPECT_THAT(SharedFolder::Create(folder_.Path() / "file" / "below", 1000),
              ::testing::Not(IsOk()));
}

}  // namespace
}  // namespace cohort

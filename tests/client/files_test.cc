#include "client/files.h"

#include <filesystem>
#include <fstream>
#include <iterator>

#include <gmock/gmock.h>
#include <unistd.h>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;
using testing::IsOk;
using testing::IsOkAndHolds;
using testing::StatusIs;

class FilesTest : public ::testing::Test {
 protected:
  FilesTest() : folder_(fs::temp_directory_path() / ("files_test-" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~FilesTest() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST_F(FilesTest, ListsMeshFilesByNameWhateverTheirCase) {
  for (const char* name : {"b.ply", "a.OBJ", "c.Stl", "notes.txt", "labels.csv"}) {
    std::ofstream(folder_ / name) << "x";
  }
  const auto files = ListMeshFiles(folder_);
  ASSERT_THAT(files, IsOk());
  EXPECT_THAT(*files,
              ::testing::ElementsAre(folder_ / "a.OBJ", folder_ / "b.ply", folder_ / "c.Stl"));
}

TEST_F(FilesTest, SaysWhenThereIsNothingToRead) {
  EXPECT_THAT(ListMeshFiles(folder_), StatusIs(absl::StatusCode::kFailedPrecondition, "no .obj"));
  EXPECT_THAT(ListMeshFiles(folder_ / "gone"), StatusIs(absl::StatusCode::kNotFound, "gone"));
  EXPECT_THAT(HashFile(folder_ / "gone"), StatusIs(absl::StatusCode::kNotFound, "gone"));
  EXPECT_THAT(ReadWholeFile(folder_ / "gone"), StatusIs(absl::StatusCode::kNotFound, "gone"));
}

TEST_F(FilesTest, WritesReadsAndHashesTheSameBytes) {
  const std::string bytes("a\0b\n", 4);
  ASSERT_THAT(WriteWholeFile(folder_ / "f", bytes), IsOk());
  EXPECT_THAT(ReadWholeFile(folder_ / "f"), IsOkAndHolds(bytes));
  const auto hashed = HashFile(folder_ / "f");
  ASSERT_THAT(hashed, IsOk());
  EXPECT_EQ(hashed->digest, Sha256::Of(bytes));
  EXPECT_EQ(hashed->size_bytes, 4);
  ASSERT_THAT(WriteWholeFile(folder_ / "f", ""), IsOk());
  EXPECT_THAT(ReadWholeFile(folder_ / "f"), IsOkAndHolds(std::string()));
}

TEST_F(FilesTest, AWriterThatIsNotFinishedLeavesTheOldFileAlone) {
  ASSERT_THAT(WriteWholeFile(folder_ / "f", "old"), IsOk());
  {
    auto writer = FileWriter::Create(folder_ / "f");
    ASSERT_THAT(writer, IsOk());
    ASSERT_THAT(writer->Append("new"), IsOk());
    EXPECT_THAT(ReadWholeFile(folder_ / "f"), IsOkAndHolds("old"));
  }
  EXPECT_THAT(ReadWholeFile(folder_ / "f"), IsOkAndHolds("old"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(FilesTest, AWriterPutsItsPartsTogether) {
  auto writer = FileWriter::Create(folder_ / "f");
  ASSERT_THAT(writer, IsOk());
  ASSERT_THAT(writer->Append("one "), IsOk());
  ASSERT_THAT(writer->Append("two"), IsOk());
  EXPECT_FALSE(fs::exists(folder_ / "f"));
  ASSERT_THAT(writer->Finish(), IsOk());
  EXPECT_THAT(ReadWholeFile(folder_ / "f"), IsOkAndHolds("one two"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(FilesTest, AWriterWithoutAFolderNamesItsFile) {
  EXPECT_THAT(FileWriter::Create(folder_ / "gone" / "f"),
              StatusIs(absl::StatusCode::kNotFound, "gone/f"));
}

TEST_F(FilesTest, AFolderThatCannotBeMadeIsNamed) {
  ASSERT_THAT(WriteWholeFile(folder_ / "f", "x"), IsOk());
  EXPECT_THAT(PrepareFolder(folder_ / "f" / "out"),
              StatusIs(absl::StatusCode::kNotFound, (folder_ / "f" / "out").string()));
  EXPECT_THAT(PrepareFolder(folder_ / "new" / "deep"), IsOk());
}

}  // namespace
}  // namespace cohort

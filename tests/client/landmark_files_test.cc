#include "client/landmark_files.h"

#include <unistd.h>

#include <filesystem>

#include <gmock/gmock.h>

#include "client/files.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using testing::IsOk;
using testing::StatusIs;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
constexpr char kCsv[] = "name,x,y,z\na,0,0,0\nb,1,0,0\nc,0,1,0\n";
constexpr char kPickedPoints[] =
    "<!DOCTYPE PickedPoints>\n<PickedPoints>\n"
    " <point name=\"a\" x=\"0\" y=\"0\" z=\"0\" active=\"1\"/>\n"
    " <point name=\"b\" x=\"1\" y=\"0\" z=\"0\" active=\"1\"/>\n"
    " <point name=\"c\" x=\"0\" y=\"2\" z=\"0\" active=\"1\"/>\n"
    "</PickedPoints>\n";
constexpr char kMarkups[] =
    R"({"markups": [{"type": "Fiducial", "coordinateSystem": "LPS", "controlPoints": [
      {"label": "a", "position": [0, 0, 0]}, {"label": "b", "position": [1, 0, 0]},
      {"label": "c", "position": [0, 3, 0]}]}]})";

class LandmarkFilesTest : public ::testing::Test {
 protected:
  LandmarkFilesTest() {
    folder_ = std::filesystem::temp_directory_path() /
              ("landmark_files_test-" + std::to_string(getpid()) + "-" +
               ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  ~LandmarkFilesTest() override { std::filesystem::remove_all(folder_); }

  std::string Write(const std::string& name, const std::string& text) {
    EXPECT_THAT(WriteWholeFile(folder_ / name, text), IsOk());
    return (folder_ / name).string();
  }
  absl::StatusOr<LandmarkTable> Match(const std::vector<std::string>& paths,
                                      const std::vector<std::string>& meshes) {
    const auto sets = ReadLandmarkFiles(paths);
    EXPECT_THAT(sets, IsOk());
    return MatchLandmarks(*sets, meshes);
  }

  std::filesystem::path folder_;
};

TEST_F(LandmarkFilesTest, FindTheMeshOfTheSameStemInAnyFormat) {
  Write("anna.csv", kCsv);
  Write("bea_picked_points.pp", kPickedPoints);
  Write("carl.mrk.json", kMarkups);
  Write("notes.txt", "not a landmark file");
  const auto table = Match({folder_.string()}, {"anna.ply", "bea.obj", "carl.stl"});
  ASSERT_THAT(table, IsOk());
  EXPECT_EQ(table->at("anna.ply").points(1, 2), 1);
  EXPECT_EQ(table->at("bea.obj").points(1, 2), 2);
  EXPECT_EQ(table->at("carl.stl").points(1, 2), 3);
}

TEST_F(LandmarkFilesTest, FindTheMeshesThatATableNamesAndPassOverTheOthers) {
  const std::string path = Write("all.csv",
                                 "file,landmark,x,y,z\n"
                                 "scans/anna.ply,a,1,0,0\n"
                                 "bea,a,2,0,0\n"
                                 "zoe.ply,a,3,0,0\n");
  const auto table = Match({path}, {"anna.ply", "bea.ply"});
  ASSERT_THAT(table, IsOk());
  EXPECT_EQ(table->size(), 2u);
  EXPECT_EQ(table->at("bea.ply").points(0, 0), 2);
}

TEST_F(LandmarkFilesTest, NameMeshesWithoutLandmarksAndWhatCouldBeMeant) {
  const std::string path = Write("all.csv", "file,landmark,x,y,z\nanna.ply,a,1,0,0\n");
  EXPECT_THAT(Match({path}, {"Anna.ply", "b.ply", "c.ply", "d.ply"}),
              StatusIs(kInvalid,
                       "4 of 4 meshes have none: Anna.ply, b.ply, c.ply and 1 more; no mesh has "
                       "the name of: "));
  EXPECT_THAT(Match({path}, {"Anna.ply"}), StatusIs(kInvalid, "all.csv (anna.ply)"));
}

TEST_F(LandmarkFilesTest, RefuseAFileAboutAMeshThatIsNotThere) {
  const std::string anna = Write("anna.csv", kCsv);
  const std::string bea = Write("bea.pp", kPickedPoints);
  EXPECT_THAT(Match({anna, bea}, {"anna.ply"}),
              StatusIs(kInvalid, "landmarks: no mesh has the name of: " + bea));
}

TEST_F(LandmarkFilesTest, RefuseTwoFilesForOneMesh) {
  const std::string csv = Write("anna.csv", kCsv);
  const std::string pp = Write("anna.pp", kPickedPoints);
  EXPECT_THAT(Match({csv, pp}, {"anna.ply"}),
              StatusIs(kInvalid, "anna.ply has them twice: in " + csv + " and " + pp));
}

TEST_F(LandmarkFilesTest, RefuseOneFileForTwoMeshes) {
  const std::string csv = Write("anna.csv", kCsv);
  EXPECT_THAT(Match({csv}, {"anna.obj", "anna.ply"}),
              StatusIs(kInvalid, "could belong to any of anna.obj, anna.ply"));
}

TEST_F(LandmarkFilesTest, NameTheFileOfAFolderThatHasNoLandmarks) {
  Write("people.csv", "file,person\na.ply,1\n");
  const std::vector<std::string> paths = {folder_.string()};
  EXPECT_THAT(ReadLandmarkFiles(paths),
              StatusIs(kInvalid, "people.csv: line 1: the columns must be named"));
  const std::vector<std::string> gone = {"/nowhere/x.csv"};
  EXPECT_THAT(ReadLandmarkFiles(gone), StatusIs(absl::StatusCode::kNotFound, "/nowhere/x.csv"));
  std::filesystem::remove(folder_ / "people.csv");
  EXPECT_THAT(ReadLandmarkFiles(paths),
              StatusIs(absl::StatusCode::kFailedPrecondition, "has no landmark file"));
}

TEST_F(LandmarkFilesTest, NeedThreeLandmarksInCommonWithTheBase) {
  LandmarkTable table;
  table["a.ply"] = {{"n", "o", "p", "q"}, Eigen::Matrix3Xd::Random(3, 4)};
  table["b.ply"] = {{"q", "o", "n"}, Eigen::Matrix3Xd::Random(3, 3)};
  EXPECT_THAT(CheckCommonLandmarks(table, "a.ply"), IsOk());
  table["c.ply"] = {{"x", "o", "n"}, Eigen::Matrix3Xd::Random(3, 3)};
  EXPECT_THAT(CheckCommonLandmarks(table, "a.ply"),
              StatusIs(kInvalid,
                       "3 are needed in common with the base mesh a.ply: c.ply has 2 (without p, "
                       "q)"));
  EXPECT_THAT(CheckCommonLandmarks(table, ""), IsOk());
  table["d.ply"] = {{"n"}, Eigen::Matrix3Xd::Random(3, 1)};
  EXPECT_THAT(CheckCommonLandmarks(table, ""),
              StatusIs(kInvalid, "landmarks: 3 are needed: d.ply has 1"));
}

TEST_F(LandmarkFilesTest, MakeTheBlobThatTheSpecNames) {
  const std::vector<std::string> paths = {Write("anna.csv", kCsv), Write("bea.csv", kCsv)};
  const std::vector<std::string> meshes = {"anna.ply", "bea.ply"};
  JobSpec spec;
  const auto blob = MakeLandmarkBlob(paths, meshes, spec);
  ASSERT_THAT(blob, IsOk());
  EXPECT_EQ(spec.landmarks, Sha256::Of(*blob));
  const auto table = DecodeLandmarkBlob(*blob);
  ASSERT_THAT(table, IsOk());
  EXPECT_THAT(table->at("bea.ply").names, ElementsAre("a", "b", "c"));
}

}  // namespace
}  // namespace cohort

#include "common/geometry/io/landmarks.h"

#include <filesystem>
#include <fstream>
#include <iterator>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using testing::IsOk;
using testing::IsOkAndHolds;
using testing::StatusIs;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

/// EXPECT_THAT(ReadLandmarks(...), HasPoint("nasion", x, y, z)).
MATCHER_P4(HasPoint, name, x, y, z, "") {
  if (!arg.ok()) {
    *result_listener << arg.status().ToString();
    return false;
  }
  const int64_t column = arg->IndexOf(name);
  return column >= 0 && arg->points.col(column) == Eigen::Vector3d(x, y, z);
}

std::vector<std::string> NamesOf(const absl::StatusOr<LandmarkSet>& set) {
  return set.ok() ? set->names : std::vector<std::string>{set.status().ToString()};
}

// ---- csv

TEST(LandmarkCsv, ReadsNamesAndPointsInTheirOrder) {
  const auto set = ReadLandmarks("name,x,y,z\nnasion,1,2.5,-3e1\nchin,4,5,6\n", "a.csv");
  EXPECT_THAT(NamesOf(set), ElementsAre("nasion", "chin"));
  EXPECT_THAT(set, HasPoint("nasion", 1, 2.5, -30));
  EXPECT_THAT(set, HasPoint("chin", 4, 5, 6));
}

TEST(LandmarkCsv, TakesColumnsByNameAndSkipsOthers) {
  const auto set = ReadLandmarks("Z;note; Y;X;Label\r\n3;hm;2;1;nose\r\n", "a.csv");
  EXPECT_THAT(set, HasPoint("nose", 1, 2, 3));
}

TEST(LandmarkCsv, ReadsQuotesTabsBlankLinesAndAByteOrderMark) {
  EXPECT_THAT(
      ReadLandmarks("\xEF\xBB\xBFname,x,y,z\n\n\"the \"\"tip\"\", left\" , 1,\"2\",3\n", "a"),
      HasPoint("the \"tip\", left", 1, 2, 3));
  EXPECT_THAT(ReadLandmarks("name\tx\ty\tz\na b\t1\t2\t3\n", "a.tsv"), HasPoint("a b", 1, 2, 3));
}

TEST(LandmarkCsv, LeavesMissingPointsOut) {
  const auto set = ReadLandmarks("name,x,y,z\na,1,2,3\nb,,,\nc,NA,NA,NA\nd,nan,NaN,\n", "a.csv");
  EXPECT_THAT(NamesOf(set), ElementsAre("a"));
}

TEST(LandmarkCsv, ReadsATableOfSeveralMeshes) {
  const auto meshes = ReadLandmarkTable(
      "file,landmark,x,y,z\nb.ply,nose,1,2,3\na.ply,nose,4,5,6\nb.ply,chin,7,8,9\n", "l.csv");
  ASSERT_THAT(meshes, IsOk());
  ASSERT_EQ(meshes->size(), 2U);
  EXPECT_EQ((*meshes)[0].mesh, "b.ply");
  EXPECT_THAT((*meshes)[0].landmarks.names, ElementsAre("nose", "chin"));
  EXPECT_EQ((*meshes)[0].landmarks.points.col(1), Eigen::Vector3d(7, 8, 9));
  EXPECT_EQ((*meshes)[1].mesh, "a.ply");
  EXPECT_THAT((*meshes)[1].landmarks.names, ElementsAre("nose"));
}

TEST(LandmarkCsv, RefusesATableWhereOneMeshIsWanted) {
  EXPECT_THAT(ReadLandmarks("file,landmark,x,y,z\nb.ply,nose,1,2,3\n", "l.csv"),
              StatusIs(kInvalid, "l.csv: has a column of files"));
}

TEST(LandmarkCsv, NamesFileLineAndReason) {
  const std::string header = "name,x,y,z\n";
  EXPECT_THAT(ReadLandmarks(header + "a,1,2,oops\n", "f.csv"),
              StatusIs(kInvalid, "f.csv: line 2: landmark 'a': z is 'oops', not a finite number"));
  EXPECT_THAT(
      ReadLandmarks("name;x;y;z\na;1,5;2;3\n", "f.csv"),
      StatusIs(kInvalid, "line 2: landmark 'a': x is '1,5', not a finite number (decimals"));
  EXPECT_THAT(ReadLandmarks(header + "a,1,2,inf\n", "f.csv"), StatusIs(kInvalid, "line 2"));
  EXPECT_THAT(ReadLandmarks(header + "a,1,,3\n", "f.csv"), StatusIs(kInvalid, "y is ''"));
  EXPECT_THAT(ReadLandmarks(header + "a,1,2\n", "f.csv"),
              StatusIs(kInvalid, "line 2: 3 fields, the header has 4"));
  EXPECT_THAT(ReadLandmarks(header + "a,1,2,3\nb,1,2,3\na,4,5,6\n", "f.csv"),
              StatusIs(kInvalid, "f.csv: line 4: landmark 'a' is there already (line 2)"));
  EXPECT_THAT(ReadLandmarks(header + "b,,,\nb,1,2,3\n", "f.csv"),
              StatusIs(kInvalid, "line 3: landmark 'b' is there already"));
  EXPECT_THAT(ReadLandmarks(header + ",1,2,3\n", "f.csv"),
              StatusIs(kInvalid, "line 2: the landmark has no name"));
  EXPECT_THAT(ReadLandmarks(header + "\"a,1,2,3\n", "f.csv"),
              StatusIs(kInvalid, "line 2: a quote"));
  EXPECT_THAT(ReadLandmarks(header + "\"a\"b,1,2,3\n", "f.csv"), StatusIs(kInvalid, "a quote"));
  EXPECT_THAT(ReadLandmarks("name,x,y\na,1,2\n", "f.csv"),
              StatusIs(kInvalid, "line 1: the columns must be named"));
  EXPECT_THAT(ReadLandmarks("name,label,x,y,z\na,a,1,2,3\n", "f.csv"),
              StatusIs(kInvalid, "line 1: columns 'name' and 'label' are the same"));
  EXPECT_THAT(ReadLandmarkTable("file,name,x,y,z\n,a,1,2,3\n", "f.csv"),
              StatusIs(kInvalid, "line 2: the landmark belongs to no file"));
  EXPECT_THAT(ReadLandmarks(header, "f.csv"), StatusIs(kInvalid, "f.csv: no landmarks in it"));
}

TEST(LandmarkCsv, WritesWhatItReads) {
  LandmarkSet set;
  set.names = {"plain", "a, \"b\"; c", " outer "};
  set.points.resize(3, 3);
  set.points << 0.1, 1e-300, -1.0 / 3, 1, 2, 3, 1e17, -0.0, 123456.789;
  const std::string csv = WriteLandmarksCsv(set);
  EXPECT_TRUE(csv.starts_with("name,x,y,z\r\nplain,0.1,1,1e+17\r\n\"a, ")) << csv;
  const auto read = ReadLandmarks(csv, "w.csv");
  ASSERT_THAT(read, IsOk());
  EXPECT_EQ(read->names, set.names);
  EXPECT_EQ(read->points, set.points);

  const std::vector<MeshLandmarks> table = {{.mesh = "x,1.ply", .landmarks = set},
                                            {.mesh = "y.ply", .landmarks = set}};
  const auto meshes = ReadLandmarkTable(WriteLandmarkTableCsv(table), "w.csv");
  ASSERT_THAT(meshes, IsOk());
  ASSERT_EQ(meshes->size(), 2U);
  EXPECT_EQ((*meshes)[0].mesh, "x,1.ply");
  EXPECT_EQ((*meshes)[1].landmarks.points, set.points);
}

TEST(LandmarkCsv, ReadsTheSharedTables) {
  const std::filesystem::path path = COHORT_SOURCE_DIR "/../shared/data/sets/faces_4x2_10k";
  if (!std::filesystem::exists(path)) {
    GTEST_SKIP() << path << " is not there";
  }
  std::ifstream file(path / "landmarks.csv", std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  const auto meshes = ReadLandmarkTable(bytes, "landmarks.csv");
  ASSERT_THAT(meshes, IsOk());
  ASSERT_EQ(meshes->size(), 8U);
  for (const MeshLandmarks& entry : *meshes) {
    EXPECT_TRUE(std::filesystem::exists(path / entry.mesh)) << entry.mesh;
    EXPECT_EQ(entry.landmarks.Count(), 14) << entry.mesh;
  }
}

// ---- MeshLab

constexpr std::string_view kPickedPoints = R"(<!DOCTYPE PickedPoints>
<PickedPoints>
 <DocumentData>
  <DateTime time="20:19:09" date="2017-07-23"/>
  <User name="someone"/>
  <DataFileName name="skull.ply"/>
  <templateName name="heads.pptpl"/>
 </DocumentData>
 <point name="Rhinion" x="4.86142" active="1" y="17.7876" z="3.90596"/>
 <point x="2" y="-1e-3" z="6" name="M2 (maxillary) &amp; more"/>
 <point x="0" y="0" z="0" active="0" name="unset"/>
</PickedPoints>
)";

TEST(PickedPoints, ReadsActivePoints) {
  const auto set = ReadLandmarks(kPickedPoints, "skull_picked_points.pp");
  EXPECT_THAT(NamesOf(set), ElementsAre("Rhinion", "M2 (maxillary) & more"));
  EXPECT_THAT(set, HasPoint("Rhinion", 4.86142, 17.7876, 3.90596));
  EXPECT_THAT(set, HasPoint("M2 (maxillary) & more", 2, -1e-3, 6));
}

TEST(PickedPoints, NamesFileLineAndReason) {
  const auto read = [](const std::string& points) {
    return ReadLandmarks("<PickedPoints>\n\n" + points + "\n</PickedPoints>", "p.pp");
  };
  EXPECT_THAT(read("<point x='1' y='2' z='a' name='n'/>"),
              StatusIs(kInvalid, "p.pp: line 3: point 'n': z is 'a', not a finite number"));
  EXPECT_THAT(read("<point x='1' z='3' name='n'/>"), StatusIs(kInvalid, "point 'n': it has no y"));
  EXPECT_THAT(read("<point x='1' y='2' z='3'/>"),
              StatusIs(kInvalid, "p.pp: line 3: the landmark has no name"));
  EXPECT_THAT(read("<point x='1' y='2' z='3' name='n' active='yes'/>"),
              StatusIs(kInvalid, "active is 'yes'"));
  EXPECT_THAT(read("<point x='1' y='2' z='3' name='n'/>\n<point x='1' y='2' z='3' name='n'/>"),
              StatusIs(kInvalid, "line 4: landmark 'n' is there already (line 3)"));
  EXPECT_THAT(read("<point x='1' y='2' z='3' name='a&#10;b'/>"),
              StatusIs(kInvalid, "control characters"));
  EXPECT_THAT(read(""), StatusIs(kInvalid, "p.pp: no landmarks"));
  EXPECT_THAT(ReadLandmarks("<PickedPoints>\n<point x=1/>\n</PickedPoints>", "p.pp"),
              StatusIs(kInvalid, "p.pp: line 2: not well-formed XML"));
  EXPECT_THAT(ReadLandmarks("<html><point/></html>", "p.pp"),
              StatusIs(kInvalid, "the XML is 'html', not MeshLab's"));
}

// ---- Slicer .fcsv

constexpr std::string_view kFcsvHeader =
    "# Markups fiducial file version = 4.11\n"
    "# CoordinateSystem = LPS\n"
    "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n";

TEST(Fcsv, ReadsPositionsInLps) {
  const auto set = ReadLandmarks(std::string(kFcsvHeader) +
                                     "1,-17.344,58.255,50.5,0,0,0,1,1,1,0,F-1,,\n"
                                     "2,1,2,3,0,0,0,1,1,1,0,\"a, b\",d,vtkMRMLModelNode4\n",
                                 "f.fcsv");
  EXPECT_THAT(NamesOf(set), ElementsAre("F-1", "a, b"));
  EXPECT_THAT(set, HasPoint("F-1", -17.344, 58.255, 50.5));
}

TEST(Fcsv, BringsRasToLps) {
  constexpr std::string_view kRow = "\n1,1,2,3,0,0,0,1,1,1,0,n,,\n";
  const std::string version = "# Markups fiducial file version = 4.4\n";
  EXPECT_THAT(ReadLandmarks(version + "# CoordinateSystem = RAS" + std::string(kRow), "f.fcsv"),
              HasPoint("n", -1, -2, 3));
  EXPECT_THAT(ReadLandmarks(version + "# CoordinateSystem = 0" + std::string(kRow), "f.fcsv"),
              HasPoint("n", -1, -2, 3));
  EXPECT_THAT(ReadLandmarks(version + "#CoordinateSystem=1" + std::string(kRow), "f.fcsv"),
              HasPoint("n", 1, 2, 3));
}

TEST(Fcsv, LeavesOutPointsWhosePositionIsNotDefined) {
  const auto set = ReadLandmarks(std::string(kFcsvHeader) +
                                     "1,1,2,3,0,0,0,1,1,1,0,a,,,2,0\n"
                                     "2,0,0,0,0,0,0,1,1,1,0,b,,,0,0\n"
                                     "3,0,0,0,0,0,0,1,1,1,0,c,,,1,0\n"
                                     "4,0,0,0,0,0,0,1,1,1,0,d,,,3,0\n"
                                     "5,4,5,6,0,0,0,1,1,1,0,e,,,\n",
                                 "f.fcsv");
  EXPECT_THAT(NamesOf(set), ElementsAre("a", "e"));
}

TEST(Fcsv, NamesFileLineAndReason) {
  const std::string header(kFcsvHeader);
  EXPECT_THAT(ReadLandmarks(header + "1,x,2,3,0,0,0,1,1,1,0,n,,\n", "f.fcsv"),
              StatusIs(kInvalid, "f.fcsv: line 4: landmark 'n': x is 'x'"));
  EXPECT_THAT(ReadLandmarks(header + "1,1,2,3\n", "f.fcsv"),
              StatusIs(kInvalid, "line 4: 4 fields, 14 columns are named"));
  EXPECT_THAT(ReadLandmarks(header + "1,1,2,3,0,0,0,1,1,1,0,n,,,7,0\n", "f.fcsv"),
              StatusIs(kInvalid, "line 4: position status '7'"));
  EXPECT_THAT(ReadLandmarks("# CoordinateSystem = IJK\n", "f.fcsv"),
              StatusIs(kInvalid, "line 1: coordinate system 'IJK'; LPS (1) and RAS (0)"));
  EXPECT_THAT(ReadLandmarks("# columns = id,x,y,z,label\n1,1,2,3,n\n", "f.fcsv"),
              StatusIs(kInvalid, "line 2: no '# CoordinateSystem = LPS'"));
  EXPECT_THAT(ReadLandmarks("# columns = id,x,y,label\n", "f.fcsv"),
              StatusIs(kInvalid, "line 1: the columns must be named"));
  EXPECT_THAT(ReadLandmarks("n,1,2,3,1,1\n", "f.fcsv"),
              StatusIs(kInvalid, "line 1: no '# Markups fiducial file version'"));
  EXPECT_THAT(ReadLandmarks(header, "f.fcsv"), StatusIs(kInvalid, "no landmarks"));
}

// ---- Slicer .mrk.json

std::string Markups(const std::string& list_fields, const std::string& points) {
  return R"({"@schema": "s", "markups": [{"type": "Fiducial", )" + list_fields +
         R"("controlPoints": [)" + points + "]}]}";
}

TEST(MarkupsJson, ReadsDefinedControlPoints) {
  const auto set = ReadLandmarks(
      Markups(R"("coordinateSystem": "LPS", "coordinateUnits": "mm", )",
              R"({"id": "1", "label": "F-1", "position": [-53.25, 1, 2e1], "locked": true},
                 {"label": "F-2", "position": [1, 2, 3], "positionStatus": "defined"},
                 {"label": "F-3", "position": "", "positionStatus": "undefined"},
                 {"label": "F-4", "position": [1, 2, 3], "positionStatus": "preview"},
                 {"label": "F-5", "positionStatus": "missing"})"),
      "f.mrk.json");
  EXPECT_THAT(NamesOf(set), ElementsAre("F-1", "F-2"));
  EXPECT_THAT(set, HasPoint("F-1", -53.25, 1, 20));
}

TEST(MarkupsJson, BringsRasToLps) {
  const std::string point = R"({"label": "n", "position": [1, 2, 3]})";
  EXPECT_THAT(ReadLandmarks(Markups(R"("coordinateSystem": "RAS", )", point), "f.mrk.json"),
              HasPoint("n", -1, -2, 3));
  EXPECT_THAT(ReadLandmarks(Markups("", point), "f.mrk.json"), HasPoint("n", 1, 2, 3));
}

TEST(MarkupsJson, ReadsUnitsAsACodeToo) {
  EXPECT_THAT(ReadLandmarks(Markups(R"("coordinateUnits": ["mm", "UCUM", "millimeter"], )",
                                    R"({"label": "n", "position": [1, 2, 3]})"),
                            "f.mrk.json"),
              HasPoint("n", 1, 2, 3));
}

TEST(MarkupsJson, ReadsAllListsOfAFile) {
  const auto set = ReadLandmarks(
      R"({"markups": [{"coordinateSystem": "RAS",
                       "controlPoints": [{"label": "a", "position": [1, 2, 3]}]},
                      {"type": "Curve"},
                      {"controlPoints": [{"label": "b", "position": [4, 5, 6]}]}]})",
      "f.mrk.json");
  EXPECT_THAT(set, HasPoint("a", -1, -2, 3));
  EXPECT_THAT(set, HasPoint("b", 4, 5, 6));
}

TEST(MarkupsJson, NamesFileFieldAndReason) {
  const auto read = [](const std::string& fields, const std::string& points) {
    return ReadLandmarks(Markups(fields, points), "f.mrk.json");
  };
  EXPECT_THAT(
      read("", R"({"label": "n", "position": [1, 2]})"),
      StatusIs(kInvalid, "f.mrk.json: markups[0].controlPoints[0].position: not three finite"));
  EXPECT_THAT(read("", R"({"label": "n"})"), StatusIs(kInvalid, "controlPoints[0].position"));
  EXPECT_THAT(read("", R"({"label": "n", "position": ["1", 2, 3]})"),
              StatusIs(kInvalid, "controlPoints[0].position"));
  EXPECT_THAT(read("", R"({"label": 7, "position": [1, 2, 3]})"),
              StatusIs(kInvalid, "markups[0].controlPoints[0].label: not a string"));
  EXPECT_THAT(read("", R"({"position": [1, 2, 3]})"),
              StatusIs(kInvalid, "markups[0].controlPoints[0]: the landmark has no name"));
  EXPECT_THAT(read("", R"(3)"), StatusIs(kInvalid, "markups[0].controlPoints[0]: not an object"));
  EXPECT_THAT(read("", R"({"label":"n","position":[1,2,3]},{"label":"n","position":[1,2,3]})"),
              StatusIs(kInvalid, "controlPoints[1]: landmark 'n' is there already (markups[0]."));
  EXPECT_THAT(read(R"("coordinateSystem": "IJK", )", ""),
              StatusIs(kInvalid, "f.mrk.json: markups[0].coordinateSystem: 'IJK'"));
  EXPECT_THAT(read(R"("coordinateUnits": "um", )", ""),
              StatusIs(kInvalid, "markups[0].coordinateUnits: only mm"));
  EXPECT_THAT(read("", ""), StatusIs(kInvalid, "no landmarks"));
  EXPECT_THAT(ReadLandmarks(R"({"markups": [{"controlPoints": {}}]})", "f.mrk.json"),
              StatusIs(kInvalid, "markups[0].controlPoints: not an array"));
  EXPECT_THAT(ReadLandmarks(R"({"markups": [1]})", "f.mrk.json"),
              StatusIs(kInvalid, "markups[0]: not an object"));
  EXPECT_THAT(ReadLandmarks(R"({"a": 1})", "f.mrk.json"), StatusIs(kInvalid, "no array 'markups'"));
  EXPECT_THAT(ReadLandmarks("{\"markups\": [}", "f.mrk.json"),
              StatusIs(kInvalid, "f.mrk.json: byte 14: parse error"));
}

TEST(MarkupsJson, RefusesDeepNesting) {
  EXPECT_THAT(ReadLandmarks("{\"markups\": " + std::string(1'000'000, '['), "f.mrk.json"),
              StatusIs(kInvalid, "nested too deeply"));
}

// ---- all formats

TEST(DetectLandmarkFormat, GoesByContentThenByName) {
  EXPECT_THAT(DetectLandmarkFormat("\n {\"markups\"", "a.csv"),
              IsOkAndHolds(LandmarkFormat::kMarkupsJson));
  EXPECT_THAT(DetectLandmarkFormat("<!DOCTYPE PickedPoints>", "a"),
              IsOkAndHolds(LandmarkFormat::kPickedPoints));
  EXPECT_THAT(DetectLandmarkFormat("# Markups", "a"), IsOkAndHolds(LandmarkFormat::kFcsv));
  EXPECT_THAT(DetectLandmarkFormat("n,1,2,3,1,1", "a.FCSV"), IsOkAndHolds(LandmarkFormat::kFcsv));
  EXPECT_THAT(DetectLandmarkFormat("name,x,y,z", "a.txt"), IsOkAndHolds(LandmarkFormat::kCsv));
  EXPECT_THAT(DetectLandmarkFormat("oops", "a.csv"), IsOkAndHolds(LandmarkFormat::kCsv));
  EXPECT_THAT(DetectLandmarkFormat("ply\nformat ascii 1.0\n", "a.ply"),
              StatusIs(kInvalid, "a.ply: neither content nor name"));
  EXPECT_THAT(DetectLandmarkFormat(" \n", "a.csv"), StatusIs(kInvalid, "a.csv: the file is empty"));
}

TEST(ReadLandmarks, KeepsToItsLimits) {
  LandmarkLimits limits;
  limits.max_landmarks = 2;
  limits.max_name_bytes = 4;
  EXPECT_THAT(ReadLandmarks("name,x,y,z\na,1,2,3\nb,1,2,3\nc,,,\n", "f.csv", limits),
              StatusIs(absl::StatusCode::kResourceExhausted, "f.csv: line 4: more landmarks than"));
  EXPECT_THAT(ReadLandmarks("name,x,y,z\nabcde,1,2,3\n", "f.csv", limits),
              StatusIs(absl::StatusCode::kResourceExhausted, "line 2: a name of 5 bytes"));
  limits.max_bytes = 10;
  EXPECT_THAT(ReadLandmarks("name,x,y,z\na,1,2,3\n", "f.csv", limits),
              StatusIs(absl::StatusCode::kResourceExhausted, "f.csv: 19 bytes; the limit is 10"));
  limits.max_bytes = 0;
  EXPECT_THAT(ReadLandmarks("name,x,y,z\na,1,2,3\n", "f.csv", limits),
              StatusIs(kInvalid, "limits must be positive"));
}

TEST(ReadLandmarks, RefusesWhatIsNotUtf8) {
  EXPECT_THAT(ReadLandmarks("name,x,y,z\n\xE9,1,2,3\n", "f.csv"),
              StatusIs(kInvalid, "f.csv: is not UTF-8"));
}

}  // namespace
}  // namespace cohort

#include "common/report/csv.h"

#include <charconv>
#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "common/report/job_meshes.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using ::testing::StartsWith;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
using Table = std::vector<std::vector<std::string>>;

// A reader of RFC 4180 that shares nothing with the writer.
Table ParseCsv(const std::string& csv) {
  Table table(1, {""});
  bool is_quoted = false;
  for (size_t i = 0; i < csv.size(); ++i) {
    std::string& field = table.back().back();
    if (is_quoted && csv[i] == '"' && i + 1 < csv.size() && csv[i + 1] == '"') {
      field += csv[i++];
    } else if (csv[i] == '"') {
      is_quoted = !is_quoted;
    } else if (!is_quoted && csv[i] == ',') {
      table.back().emplace_back();
    } else if (!is_quoted && csv.compare(i, 2, "\r\n") == 0) {
      table.push_back({""});
      ++i;
    } else {
      field += csv[i];
    }
  }
  table.pop_back();
  return table;
}

double Number(const std::string& text) {
  double value = kNaN;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

MetricMatrix ThreeMeshes() {
  MetricMatrix matrix;
  matrix.labels = {"a.ply", "b,1.ply", "č \"x\".ply"};
  matrix.values.resize(3, 3);
  matrix.values << 0, 0.1, 1e-7, 1.0 / 3, 0, kNaN, 12, 1e21, 0;
  return matrix;
}

JobMesh Mesh(const std::string& name, std::map<std::string, std::string> labels) {
  JobMesh mesh;
  mesh.mesh.name = name;
  mesh.mesh.raw = Sha256::Of(name);
  mesh.mesh.size_bytes = 1234;
  mesh.mesh.labels = std::move(labels);
  return mesh;
}

JobMesh AcceptedMesh() {
  JobMesh mesh = Mesh("a.ply", {{"person", "1"}, {"sex", "f"}});
  IngestedMesh ingested;
  ingested.vertices = 10;
  ingested.faces = 16;
  ingested.health = {.vertices = 12,
                     .faces = 17,
                     .duplicate_vertices = 1,
                     .unreferenced_vertices = 2,
                     .degenerate_faces = 3,
                     .duplicate_faces = 4,
                     .non_manifold_edges = 5,
                     .components = 6,
                     .largest_component_share = 0.97,
                     .boundary_share = 0.125,
                     .diagonal = 200.5,
                     .rms_radius = 70.25,
                     .surface_area = 3e4,
                     .point_cloud = false,
                     .warnings = {"6 components; the largest has 97 %", "small, torn"}};
  mesh.ingested = ingested;
  return mesh;
}

MeshAlignment QuarterTurn(int32_t mesh) {
  MeshAlignment alignment;
  alignment.mesh = mesh;
  alignment.alignment.iterations = 17;
  alignment.alignment.converged = true;
  alignment.alignment.rms_residual = 0.5;
  alignment.alignment.mean_residual = 0.25;
  alignment.alignment.at_scale_limit = true;
  alignment.alignment.overlap = 0.75;
  alignment.alignment.kept_share = 0.875;
  alignment.alignment.T_target_source.scale = 1.5;
  alignment.alignment.T_target_source.rotation << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  alignment.alignment.T_target_source.translation << 10, -20.5, 0.1;
  return alignment;
}

TEST(CsvRow, QuotesWhatRfc4180Asks) {
  const std::vector<std::string> fields = {
      "plain", "a,b", "say \"hi\"", "two\nlines", "cr\rhere", "", " outer ", "in side", "=1+1"};
  EXPECT_EQ(CsvRow(fields),
            "plain,\"a,b\",\"say \"\"hi\"\"\",\"two\nlines\",\"cr\rhere\",,\" outer \",in side,"
            "=1+1\r\n");
}

TEST(CsvRow, ReadsBackAsItWas) {
  const std::vector<std::string> fields = {"\"", ",", "\r\n", "\"\"", "žluťoučký kůň",
                                           "'",  ";", ""};
  EXPECT_EQ(ParseCsv(CsvRow(fields)), Table{fields});
}

TEST(MatrixCsv, HasTheMetricInTheCornerAndShortestNumbers) {
  EXPECT_EQ(MatrixCsv(ThreeMeshes(), Metric::kRms),
            "rms,a.ply,\"b,1.ply\",\"č \"\"x\"\".ply\"\r\n"
            "a.ply,0,0.1,1e-07\r\n"
            "\"b,1.ply\",0.3333333333333333,0,NA\r\n"
            "\"č \"\"x\"\".ply\",12,1e+21,0\r\n");
}

TEST(MatrixCsv, GivesBackEveryBitOfTheNumbers) {
  MetricMatrix matrix;
  matrix.values.resize(4, 4);
  for (int i = 0; i < 16; ++i)
    matrix.values(i / 4, i % 4) = std::sin(i + 1.0) * std::pow(10, i - 8);
  matrix.labels = {"a", "b", "c", "d"};
  const Table table = ParseCsv(MatrixCsv(matrix, Metric::kPercentile75));
  ASSERT_EQ(table.size(), 5U);
  EXPECT_THAT(table[0], ElementsAre("p75", "a", "b", "c", "d"));
  for (size_t i = 0; i < 16; ++i) {
    EXPECT_EQ(Number(table[1 + i / 4][1 + i % 4]),
              matrix.values(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4)))
        << "entry " << i;
  }
}

TEST(MatrixCsv, OfNoMeshesIsOnlyTheCorner) {
  EXPECT_EQ(MatrixCsv({}, Metric::kMean), "mean\r\n");
}

TEST(NeighboursCsv, RanksFromOneWithoutPersons) {
  const std::vector<std::vector<Neighbour>> neighbours = {{{2, 1e-7}, {1, 0.1}}, {{0, 0.25}}, {}};
  EXPECT_EQ(NeighboursCsv(ThreeMeshes(), neighbours, {}),
            "mesh,rank,neighbour,value\r\n"
            "a.ply,1,\"č \"\"x\"\".ply\",1e-07\r\n"
            "a.ply,2,\"b,1.ply\",0.1\r\n"
            "\"b,1.ply\",1,a.ply,0.25\r\n");
}

TEST(NeighboursCsv, SaysWhetherTheNeighbourIsTheSamePerson) {
  const std::vector<std::vector<Neighbour>> neighbours = {{{2, 1}, {1, 2}}, {{0, 3}}, {{1, 4}}};
  const std::vector<std::string> persons = {"7", "", "7"};
  EXPECT_EQ(
      ParseCsv(NeighboursCsv(ThreeMeshes(), neighbours, persons)),
      (Table{{"mesh", "rank", "neighbour", "value", "person", "neighbour_person", "same_person"},
             {"a.ply", "1", "č \"x\".ply", "1", "7", "7", "TRUE"},
             {"a.ply", "2", "b,1.ply", "2", "7", "NA", "NA"},
             {"b,1.ply", "1", "a.ply", "3", "NA", "7", "NA"},
             {"č \"x\".ply", "1", "b,1.ply", "4", "7", "NA", "NA"}}));
}

TEST(NeighboursCsv, TellsDifferentPeopleApart) {
  const std::vector<std::vector<Neighbour>> neighbours = {{{1, 2}}, {}, {}};
  const std::vector<std::string> persons = {"7", "8", "7"};
  EXPECT_EQ(ParseCsv(NeighboursCsv(ThreeMeshes(), neighbours, persons))[1].back(), "FALSE");
}

TEST(NeighboursCsv, HasNoPersonColumnsWhenNobodyIsKnown) {
  const std::vector<std::vector<Neighbour>> neighbours(3);
  const std::vector<std::string> persons(3);
  EXPECT_EQ(NeighboursCsv(ThreeMeshes(), neighbours, persons), "mesh,rank,neighbour,value\r\n");
}

TEST(MeshesCsv, HasARowForEveryMeshAlsoForRejectedOnes) {
  JobMesh rejected = Mesh("b.ply", {{"age", "30"}});
  rejected.rejection = "b.ply: face 17 uses vertex 5120 of 5000";
  std::vector<JobMesh> meshes = {AcceptedMesh(), rejected};
  meshes[0].copy = SymmetricCopy{.index = 0, .blob = {}, .asymmetry = 0.375};
  MeshAlignment pose;
  pose.alignment.rms_residual = 2.5;
  EXPECT_EQ(
      MeshesCsv(meshes, std::vector{QuarterTurn(0)}, std::vector{pose}),
      "file,status,reason,age,person,sex,sha256,size_bytes,vertices,faces,file_vertices,file_faces,"
      "duplicate_vertices,unreferenced_vertices,degenerate_faces,duplicate_faces,"
      "non_manifold_edges,components,largest_component_share,boundary_share,diagonal,rms_radius,"
      "surface_area,point_cloud,warnings,iterations,converged,rms_residual,mean_residual,scale,"
      "at_scale_limit,overlap,kept_share,pose_rms,asymmetry\r\n"
      "a.ply,ok,,NA,1,f," +
          Sha256::Of("a.ply").Hex() +
          ",1234,10,16,12,17,1,2,3,4,5,6,0.97,0.125,200.5,70.25,30000,FALSE,"
          "\"6 components; the largest has 97 %; small, "
          "torn\",17,TRUE,0.5,0.25,1.5,TRUE,0.75,0.875,2.5,0.375\r\n"
          "b.ply,rejected,b.ply: face 17 uses vertex 5120 of 5000,30,NA,NA," +
          Sha256::Of("b.ply").Hex() +
          ",1234,NA,NA,NA,NA,NA,NA,NA,NA,NA,NA,NA,NA,NA,NA,NA,NA,NA,NA,NA,NA,NA,NA,NA,NA,NA,NA,"
          "NA\r\n");
}

TEST(MeshesCsv, RenamesLabelsThatAreColumnsAlready) {
  const std::vector<JobMesh> meshes = {Mesh("a.ply", {{"scale", "x"}, {"file", "y"}})};
  EXPECT_THAT(MeshesCsv(meshes, {}, {}),
              StartsWith("file,status,reason,label_file,label_scale,sha256"));
}

TEST(MeshesCsv, FindsTheAlignmentByTheIndexOfTheMesh) {
  const std::vector<JobMesh> meshes = {AcceptedMesh(), AcceptedMesh()};
  const Table table = ParseCsv(MeshesCsv(meshes, std::vector{QuarterTurn(1)}, {}));
  EXPECT_EQ(table[1].end()[-3], "NA");
  EXPECT_EQ(table[2].end()[-3], "0.875");
}

TEST(TransformsCsv, WritesTheRotationRowByRow) {
  const std::vector<JobMesh> meshes = {Mesh("a.ply", {}), Mesh("b.ply", {}), Mesh("c.ply", {})};
  EXPECT_EQ(TransformsCsv(meshes, std::vector{QuarterTurn(2), QuarterTurn(0)}),
            "file,scale,r11,r12,r13,r21,r22,r23,r31,r32,r33,tx,ty,tz\r\n"
            "a.ply,1.5,0,-1,0,1,0,0,0,0,1,10,-20.5,0.1\r\n"
            "c.ply,1.5,0,-1,0,1,0,0,0,0,1,10,-20.5,0.1\r\n");
}

TEST(TransformsCsv, MovesPointsAsTheAlignmentDoes) {
  const std::vector<JobMesh> meshes = {Mesh("a.ply", {})};
  const MeshAlignment alignment = QuarterTurn(0);
  const std::vector<std::string> row =
      ParseCsv(TransformsCsv(meshes, std::vector{alignment})).at(1);
  Eigen::Matrix3d R;
  R << Number(row[2]), Number(row[3]), Number(row[4]), Number(row[5]), Number(row[6]),
      Number(row[7]), Number(row[8]), Number(row[9]), Number(row[10]);
  const Eigen::Vector3d t(Number(row[11]), Number(row[12]), Number(row[13]));
  const Eigen::Vector3d point(1, 2, 3);
  // The quarter turn about z maps (1, 2, 3) to (-2, 1, 3).
  const Eigen::Vector3d moved = Number(row[1]) * R * point + t;
  EXPECT_TRUE(moved.isApprox(Eigen::Vector3d(-3 + 10, 1.5 - 20.5, 4.5 + 0.1), 1e-15));
}

TEST(PersonsOf, FindsPersonsByMeshName) {
  const std::vector<JobMesh> meshes = {Mesh("b", {{"person", "2"}}), Mesh("a", {{"person", "1"}}),
                                       Mesh("c", {{"sex", "f"}})};
  const std::vector<std::string> names = {"a", "b", "c", "d"};
  EXPECT_THAT(PersonsOf(names, meshes), ElementsAre("1", "2", "", ""));
}

}  // namespace
}  // namespace cohort

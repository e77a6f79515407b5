#include "common/report/html/report_html.h"

#include <limits>

#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/base/executor.h"
#include "tests/common/geometry/mesh/shapes.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::cohort::testing::IsOk;
using ::cohort::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// A job of meshes on a line: mesh i lies at i*i.
struct Example {
  Job job;
  std::vector<JobMesh> meshes;
  std::vector<MeshAlignment> alignments;
  MetricMatrix matrix;
  MatrixDescription description;
  std::vector<std::string> persons;
  std::vector<std::vector<Neighbour>> neighbours;
  TriangleMesh shape = testing::WavySheet(8);
  VariationSummary variation;
  std::vector<std::string> thumbnails;
  std::string thumbnails_note;
  std::vector<std::string> notes;

  explicit Example(int count) {
    job.set = "brno";
    variation.mesh_count = count;
    for (int64_t i = 0; i < shape.VertexCount(); ++i) {
      variation.values.push_back({0.1 * static_cast<double>(i), 1, 1, 1, 1, 1, 1});
    }
    matrix.values.resize(count, count);
    for (int i = 0; i < count; ++i) {
      JobMesh mesh;
      mesh.mesh.name = absl::StrCat("m", i, ".ply");
      mesh.ingested = IngestedMesh{};
      matrix.labels.push_back(mesh.mesh.name);
      meshes.push_back(mesh);
      alignments.push_back({i, {}});
      alignments.back().alignment.converged = true;
      persons.emplace_back();
      for (int j = 0; j < count; ++j) matrix.values(i, j) = std::abs(i * i - j * j);
    }
    neighbours = NearestNeighbours(matrix, 3);
  }

  void SetPersons(const std::vector<std::string>& names) {
    persons = names;
    for (size_t i = 0; i < names.size(); ++i) meshes[i].mesh.labels["person"] = names[i];
  }

  void Reject(const std::string& name, const std::string& reason) {
    JobMesh mesh;
    mesh.mesh.name = name;
    mesh.rejection = reason;
    meshes.push_back(mesh);
  }

  [[nodiscard]] absl::StatusOr<std::string> Html() const {
    SerialExecutor executor;
    return ReportHtml({.job = job,
                       .meshes = meshes,
                       .alignments = alignments,
                       .matrix = matrix,
                       .description = description,
                       .persons = persons,
                       .neighbours = neighbours,
                       .mean_shape = shape,
                       .variation_shape = shape,
                       .variation = variation,
                       .thumbnails = thumbnails,
                       .thumbnails_note = thumbnails_note,
                       .notes = notes,
                       .software_version = "cohort 9"},
                      executor);
  }
};

std::string HtmlOf(const Example& example) {
  const absl::StatusOr<std::string> html = example.Html();
  EXPECT_THAT(html, IsOk());
  return html.value_or("");
}

// What lies between two parts of a text.
std::string Between(const std::string& text, const std::string& open, const std::string& close) {
  const size_t begin = text.find(open);
  if (begin == std::string::npos) return "";
  const size_t end = text.find(close, begin + open.size());
  return text.substr(begin + open.size(), end - begin - open.size());
}

std::string Section(const std::string& html, const std::string& id) {
  return Between(html, absl::StrCat("<section id=\"", id, "\">"), "</section>");
}

nlohmann::json EmbeddedMatrix(const std::string& html) {
  return nlohmann::json::parse(
      Between(html, "<script type=\"application/json\" id=\"matrix-data\">", "</script>"));
}

int Base64Digit(char c) {
  return static_cast<int>(
      std::string("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/").find(c));
}

std::vector<int> CodesOf(const nlohmann::json& matrix) {
  std::vector<int> bytes;
  const std::string text = matrix["cells"];
  for (size_t i = 0; i + 3 < text.size(); i += 4) {
    int group = 0;
    for (size_t k = 0; k < 4; ++k) group = group * 64 + std::max(0, Base64Digit(text[i + k]));
    bytes.insert(bytes.end(), {group >> 16, (group >> 8) & 255, group & 255});
  }
  std::vector<int> codes;
  for (size_t i = 0; i + 1 < bytes.size(); i += 2) codes.push_back(bytes[i] + 256 * bytes[i + 1]);
  return codes;
}

TEST(ReportHtml, HasEveryPartOfALabelledSet) {
  Example example(6);
  example.SetPersons({"p1", "p1", "p2", "p2", "p3", "p3"});
  const std::string html = HtmlOf(example);
  for (const char* id :
       {"summary", "health", "matrix", "neighbours", "distribution", "identification", "dendrogram",
        "ordination", "shape", "registration", "parameters"}) {
    EXPECT_NE(Section(html, id), "") << id;
    EXPECT_THAT(html, HasSubstr(absl::StrCat("href=\"#", id, "\"")));
  }
  EXPECT_THAT(Section(html, "ordination"), HasSubstr("Coloured by person"));
}

TEST(ReportHtml, WithoutPersonsThereIsNoIdentification) {
  const std::string html = HtmlOf(Example(6));
  EXPECT_EQ(Section(html, "identification"), "");
  EXPECT_THAT(Section(html, "matrix"), Not(HasSubstr("by person")));
  EXPECT_NE(Section(html, "dendrogram"), "");
}

TEST(ReportHtml, ForeignTextsAreEscapedEverywhere) {
  Example example(4);
  const std::string evil = "</script><script>alert(1)</script>\"'&.ply";
  example.meshes[0].mesh.name = evil;
  example.matrix.labels[0] = evil;
  example.SetPersons({evil, evil, "b", "b"});
  example.meshes[2].mesh.labels[evil] = evil;
  example.meshes[3].mesh.labels[evil] = evil;
  example.meshes[1].mesh.labels[evil] = "c";
  example.meshes[1].ingested->health.warnings = {evil};
  example.Reject(evil + "2", evil);
  example.job.set = evil;
  example.job.spec.base = evil;
  example.notes = {evil};
  example.thumbnails = {"png", "", "", ""};
  example.thumbnails_note = evil;
  const std::string html = HtmlOf(example);
  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(html, HasSubstr("&lt;script&gt;alert(1)"));
  EXPECT_EQ(EmbeddedMatrix(html)["names"][0], evil);
}

TEST(ReportHtml, AsksForNothingFromElsewhere) {
  const std::string html = HtmlOf(Example(4));
  EXPECT_THAT(html, AllOf(Not(HasSubstr("src=\"http")), Not(HasSubstr("href=\"http")),
                          Not(HasSubstr("url(http")), Not(HasSubstr("@import")),
                          HasSubstr("default-src 'none'")));
}

TEST(ReportHtml, TheEmbeddedMatrixReadsBackToItsPrecision) {
  const Example example(5);
  const nlohmann::json matrix = EmbeddedMatrix(HtmlOf(example));
  EXPECT_EQ(matrix["bits"], 16);
  EXPECT_TRUE(matrix["symmetric"]);
  const std::vector<int> codes = CodesOf(matrix);
  const double low = matrix["low"];
  const double high = matrix["high"];
  EXPECT_EQ(low, 1);    // |0 - 1|
  EXPECT_EQ(high, 16);  // |0 - 16|
  size_t place = 0;
  for (int row = 0; row < 5; ++row) {
    for (int column = 0; column < row; ++column) {
      const double value = low + (codes.at(place++) - 1) / 65534.0 * (high - low);
      EXPECT_NEAR(value, example.matrix.values(row, column), (high - low) / 65534 / 2 + 1e-12);
    }
  }
}

TEST(ReportHtml, ADirectedMatrixKeepsBothDirections) {
  Example example(4);
  example.description.symmetrization = Symmetrization::kDirected;
  example.matrix.values(1, 2) = 9;
  const std::string html = HtmlOf(example);
  const nlohmann::json matrix = EmbeddedMatrix(html);
  EXPECT_FALSE(matrix["symmetric"]);
  EXPECT_EQ(CodesOf(matrix).at(0), 0);  // The diagonal.
  EXPECT_EQ(CodesOf(matrix).at(1 * 4 + 2), 65535);
  EXPECT_THAT(Section(html, "dendrogram"), HasSubstr("mean of both directions"));
}

TEST(ReportHtml, MeshesWithoutValuesAreLeftOutOfTheTreeAndSaidSo) {
  Example example(6);
  for (int i = 0; i < 6; ++i) example.matrix.values(2, i) = example.matrix.values(i, 2) = kNaN;
  example.neighbours = NearestNeighbours(example.matrix, 3);
  const std::string html = HtmlOf(example);
  EXPECT_THAT(Section(html, "dendrogram"), HasSubstr("Without 1 mesh that"));
  EXPECT_THAT(Section(html, "ordination"), HasSubstr("Without 1 mesh that"));
  EXPECT_THAT(Section(html, "health"), HasSubstr("no value to any other mesh"));
  EXPECT_EQ(EmbeddedMatrix(html)["clusters"].size(), 6);
  EXPECT_EQ(EmbeddedMatrix(html)["clusters"][5], 2);
}

TEST(ReportHtml, SignedValuesHaveNoNeighboursAndNoTree) {
  Example example(5);
  example.description.sign = DistanceSign::kSigned;
  example.matrix.values *= -1;
  example.neighbours.clear();
  const std::string html = HtmlOf(example);
  EXPECT_THAT(Section(html, "neighbours"), HasSubstr("Left out"));
  EXPECT_THAT(Section(html, "dendrogram"), HasSubstr("no clustering"));
  EXPECT_EQ(Section(html, "ordination"), "");
}

TEST(ReportHtml, OneMeshStillHasAReport) {
  Example example(1);
  example.Reject("broken.ply", "no faces");
  const std::string html = HtmlOf(example);
  EXPECT_THAT(Section(html, "matrix"), HasSubstr("no pair"));
  EXPECT_THAT(Section(html, "health"), HasSubstr("no faces"));
  EXPECT_NE(Section(html, "shape"), "");
}

TEST(ReportHtml, RejectedAndFlaggedMeshesComeFirst) {
  Example example(5);
  example.meshes[3].ingested->health.warnings = {"2 components"};
  example.Reject("zz.ply", "no faces");
  const std::string health = Section(HtmlOf(example), "health");
  EXPECT_LT(health.find("zz.ply"), health.find("m3.ply"));
  EXPECT_LT(health.find("m3.ply"), health.find("m0.ply"));
  EXPECT_THAT(health, HasSubstr("2 components"));
}

TEST(ReportHtml, AlignmentsThatStandOutAreFlagged) {
  Example example(12);
  example.matrix.values.setConstant(2);
  example.matrix.values.diagonal().setZero();
  for (size_t i = 0; i < 12; ++i) {
    example.alignments[i].alignment.rms_residual = 1 + 0.01 * static_cast<double>(i);
  }
  example.alignments[4].alignment.rms_residual = 9;
  example.alignments[5].alignment.converged = false;
  example.alignments[5].alignment.iterations = 200;
  example.alignments[6].alignment.overlap = 0.5;
  example.alignments[7].alignment.at_scale_limit = true;
  const std::string html = HtmlOf(example);
  const std::string registration = Section(html, "registration");
  EXPECT_THAT(registration, AllOf(HasSubstr("residual far above the others: 9.00 mm"),
                                  HasSubstr("not converged after 200 iterations"),
                                  HasSubstr("overlap 50 %"), HasSubstr("scale at its limit")));
  EXPECT_THAT(Section(html, "summary"), HasSubstr("<dt>flagged</dt><dd>4</dd>"));
}

TEST(ReportHtml, ReachingTheIterationsThatWereAskedForIsNoFlag) {
  Example example(6);
  for (MeshAlignment& one : example.alignments) one.alignment.converged = false;
  EXPECT_THAT(HtmlOf(example), Not(HasSubstr("not converged after")));
}

TEST(ReportHtml, EachThumbnailIsEmbeddedOnce) {
  Example example(6);
  example.thumbnails = {"one", "two", "", "four", "five", "six"};
  const std::string html = HtmlOf(example);
  EXPECT_THAT(html, HasSubstr(".t0{background-image:url(data:image/png;base64,b25l)}"));
  EXPECT_EQ(html.find("b25l"), html.rfind("b25l"));
  EXPECT_THAT(html, Not(HasSubstr("class=\"thumb t2\"")));
  EXPECT_THAT(Section(html, "neighbours"), HasSubstr("class=\"thumb t1\""));
}

TEST(ReportHtml, MoreThanAThousandMeshesHaveOneByteACell) {
  const std::string html = HtmlOf(Example(1001));
  EXPECT_EQ(EmbeddedMatrix(html)["bits"], 8);
  EXPECT_THAT(Section(html, "matrix"), HasSubstr("reduced"));
  EXPECT_THAT(Section(html, "ordination"), HasSubstr("more than 1000 meshes"));
}

TEST(ReportHtml, SaysNothingOfWhenWhereOrUnderWhichIdTheJobRan) {
  Example a(4);
  Example b(4);
  b.job.id = {"j-000099"};
  b.job.created_unix_ms = 1772368496000;
  b.job.finished_unix_ms = 1772368499000;
  b.job.spec.priority = 5;
  b.job.spec.reference_job = "j-000007";
  b.job.progress.tasks_reused = 7;
  EXPECT_EQ(HtmlOf(a), HtmlOf(b));
}

TEST(ReportHtml, RefusesSizesThatDisagree) {
  Example example(4);
  example.persons.pop_back();
  EXPECT_THAT(example.Html(), StatusIs(absl::StatusCode::kInvalidArgument, "3 persons"));
}

TEST(ReportHtml, SaysWhatIsLeftOutOfThousandsOfMeshes) {
  Example example(5001);
  std::vector<std::string> persons;
  persons.reserve(5001);
  for (int i = 0; i < 5001; ++i) persons.push_back(absl::StrCat("p", i / 2));
  example.SetPersons(persons);
  const std::string html = HtmlOf(example);
  EXPECT_THAT(Section(html, "dendrogram"), HasSubstr("more than 5000 meshes"));
  EXPECT_THAT(Section(html, "ordination"), HasSubstr("more than 1000 meshes"));
  EXPECT_THAT(Section(html, "identification"), HasSubstr("more than 5000 meshes"));
  EXPECT_THAT(Section(html, "distribution"), HasSubstr("<svg"));
}

}  // namespace
}  // namespace cohort

#include "client/matrix_files.h"

#include <cmath>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/files.h"
#include "common/report/csv.h"
#include "common/report/npy.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using testing::IsOk;
using testing::StatusIs;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

MetricMatrix Three() {
  MetricMatrix matrix;
  matrix.labels = {"a, \"b\".ply", "=c.ply", " d "};
  matrix.values.resize(3, 3);
  matrix.values << 0, 0.1, 1e-300, 0.1, 0, std::nan(""), 1e-300, std::nan(""), 0;
  return matrix;
}

TEST(ParseMatrixCsv, ReadsWhatWeWrite) {
  const MetricMatrix written = Three();
  const auto read = ParseMatrixCsv(MatrixCsv(written, Metric::kRms), "matrix.csv");
  ASSERT_THAT(read, IsOk());
  EXPECT_EQ(read->labels, written.labels);
  EXPECT_EQ(read->values(0, 1), 0.1);
  EXPECT_EQ(read->values(2, 0), 1e-300);
  EXPECT_TRUE(std::isnan(read->values(1, 2)));
}

TEST(ParseMatrixCsv, ReadsWhatRWrites) {
  // write.csv, write.csv2 (decimal commas) and write.table.
  for (const char* text : {"\"\",\"a\",\"b\"\n\"a\",0,1.5\n\"b\",1.5,NA\n",
                           "\"\";\"a\";\"b\"\r\n\"a\";0;1,5\r\n\"b\";1,5;NA\r\n",
                           "\"a\"\t\"b\"\n\"a\"\t0\t1.5\n\"b\"\t1.5\tNA\n"}) {
    const auto read = ParseMatrixCsv(text, "r.csv");
    ASSERT_THAT(read, IsOk()) << text;
    EXPECT_THAT(read->labels, ElementsAre("a", "b"));
    EXPECT_EQ(read->values(0, 1), 1.5);
    EXPECT_TRUE(std::isnan(read->values(1, 1)));
  }
}

TEST(ParseMatrixCsv, NamesFileLineAndReason) {
  const auto parse = [](const char* text) { return ParseMatrixCsv(text, "m.csv").status(); };
  EXPECT_THAT(parse(""), StatusIs(kInvalid, "m.csv: is no matrix"));
  EXPECT_THAT(parse(",a,b\na,0,1\n"), StatusIs(kInvalid, "2 columns have a name, there are 1"));
  EXPECT_THAT(parse(",a,b\na,0,x\nb,1,0\n"), StatusIs(kInvalid, "line 2: 'x' under b"));
  EXPECT_THAT(parse(",a,b\na,0,1\nc,1,0\n"), StatusIs(kInvalid, "line 3: row 2 is 'c'"));
  EXPECT_THAT(parse(",a,b\na,0,1\nb,1\n"), StatusIs(kInvalid, "line 3: 2 fields, expected a name"));
  EXPECT_THAT(parse(",a,b\na,0,1\nb,1,0,9\n"), StatusIs(kInvalid, "line 3: 4 fields"));
}

TEST(ParseMatrixNpy, ReadsWhatWeWrite) {
  const auto read = ParseMatrixNpy(MatrixNpy(Three().values), "matrix.npy");
  ASSERT_THAT(read, IsOk());
  EXPECT_EQ((*read)(0, 1), 0.1);
  EXPECT_TRUE(std::isnan((*read)(1, 2)));
}

TEST(ParseMatrixNpy, RefusesOtherArraysAndShortFiles) {
  const std::string bytes = MatrixNpy(Three().values);
  const auto parse = [](const std::string& npy) { return ParseMatrixNpy(npy, "m.npy").status(); };
  EXPECT_THAT(parse(bytes.substr(0, bytes.size() - 1)), StatusIs(kInvalid, "3 x 3 need 8"));
  EXPECT_THAT(parse("PK"), StatusIs(kInvalid, "no NumPy file"));
  std::string changed = bytes;
  changed.replace(changed.find("<f8"), 3, "<f4");
  EXPECT_THAT(parse(changed), StatusIs(kInvalid, "float64"));
  changed = bytes;
  changed.replace(changed.find("(3, 3)"), 6, "(3, 2)");
  EXPECT_THAT(parse(changed), StatusIs(kInvalid, "square"));
  changed = bytes;
  changed.replace(changed.find("(3, 3), }"), 9, "(9999999,");
  EXPECT_THAT(parse(changed), StatusIs(kInvalid, "square"));
}

TEST(ReadMatrixFile, TakesNamesOfAnNpyFromLabelsTxt) {
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / "cohort_matrix_files";
  std::filesystem::remove_all(folder);
  ASSERT_THAT(PrepareFolder(folder), IsOk());
  const RowMajorMatrix values = Three().values;
  ASSERT_THAT(WriteWholeFile(folder / "m.npy", MatrixNpy(values)), IsOk());
  EXPECT_THAT(ReadMatrixFile(folder / "m.npy"),
              StatusIs(absl::StatusCode::kNotFound, "needs the names of its rows"));
  ASSERT_THAT(WriteWholeFile(folder / "labels.txt", "a\nb\n"), IsOk());
  EXPECT_THAT(ReadMatrixFile(folder / "m.npy"), StatusIs(kInvalid, "2 names"));
  ASSERT_THAT(WriteWholeFile(folder / "labels.txt", "a\nb\nc\n"), IsOk());
  const auto read = ReadMatrixFile(folder / "m.npy");
  ASSERT_THAT(read, IsOk());
  EXPECT_THAT(read->labels, ElementsAre("a", "b", "c"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace cohort

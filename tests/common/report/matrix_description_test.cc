#include "common/report/matrix_description.h"

#include <gtest/gtest.h>

namespace cohort {
namespace {

TEST(MatrixDescription, SaysWhoseNumbersTheyAreAndWhetherTheyAreSigned) {
  MatrixDescription description;
  EXPECT_EQ(MethodText(description), "Aligned to the mean shape (method average)");
  EXPECT_EQ(MetricText(description), "RMS distance");
  EXPECT_EQ(ValueTitle(description), "RMS distance (mm)");
  description.method = Method::kEach;
  description.arithmetic = Arithmetic::kFidentis;
  description.sign = DistanceSign::kSigned;
  EXPECT_EQ(MethodText(description),
            "Each pair aligned, source to target (method each, preset fidentis)");
  EXPECT_EQ(MetricText(description), "RMS distance (signed)");
  EXPECT_EQ(ValueTitle(description), "RMS distance (signed, mm)");
  description.unit.clear();
  EXPECT_EQ(ValueTitle(description), "RMS distance (signed)");
}

TEST(MatrixDescription, NamesEveryMethod) {
  const auto text = [](Method method) {
    MatrixDescription description;
    description.method = method;
    return MethodText(description);
  };
  EXPECT_EQ(text(Method::kOne), "Aligned to the base mesh (method one)");
  EXPECT_EQ(text(Method::kNone), "Not aligned (method none)");
}

}  // namespace
}  // namespace cohort

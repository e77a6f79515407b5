#include "common/report/canvas.h"

#include <array>

#include <gmock/gmock.h>

#include "tests/common/report/png_pixels.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::DecodePng;
using testing::IsOk;
using testing::Pixels;
using testing::StatusIs;

TEST(Canvas, RefusesPagesThatCannotBeDrawn) {
  EXPECT_THAT(Canvas::Create(0, 10), StatusIs(absl::StatusCode::kInvalidArgument, "0."));
  EXPECT_THAT(Canvas::Create(20000, 10), StatusIs(absl::StatusCode::kInvalidArgument, "40000"));
}

TEST(Canvas, PutsBoxesWhereTheyBelong) {
  absl::StatusOr<Canvas> canvas = Canvas::Create(20, 10);
  ASSERT_THAT(canvas, IsOk());
  constexpr Rgb kRed = {200, 10, 20};
  canvas->Fill({4, 2, 6, 3}, kRed);
  const Pixels pixels = DecodePng(*canvas->Png());
  ASSERT_EQ(pixels.width, 40);
  ASSERT_EQ(pixels.height, 20);
  EXPECT_EQ(pixels.Count(kRed), 12 * 6);
  EXPECT_EQ(pixels.At(8, 4), kRed);
  EXPECT_EQ(pixels.At(19, 9), kRed);
  EXPECT_EQ(pixels.At(7, 4), kWhite);
}

TEST(Canvas, StretchesCellsWithSharpEdges) {
  absl::StatusOr<Canvas> canvas = Canvas::Create(8, 8);
  ASSERT_THAT(canvas, IsOk());
  constexpr std::array<Rgb, 4> kColors = {{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}}};
  canvas->Cells({1, 1, 6, 6}, 2, kColors);
  const Pixels pixels = DecodePng(*canvas->Png());
  for (const Rgb color : kColors) EXPECT_EQ(pixels.Count(color), 6 * 6);
  EXPECT_EQ(pixels.At(7, 7), kColors[0]);
  EXPECT_EQ(pixels.At(8, 7), kColors[1]);
  EXPECT_EQ(pixels.At(7, 8), kColors[2]);
}

TEST(Canvas, WritesTextBesideItsPoint) {
  absl::StatusOr<Canvas> canvas = Canvas::Create(100, 100);
  ASSERT_THAT(canvas, IsOk());
  canvas->Text({50, 50}, "HHH", {12}, Anchor::kEnd);
  const Pixels pixels = DecodePng(*canvas->Png());
  int64_t left = 0;
  int64_t right = 0;
  for (int y = 0; y < pixels.height; ++y) {
    for (int x = 0; x < pixels.width; ++x) {
      (x < 100 ? left : right) += pixels.At(x, y) == kWhite ? 0 : 1;
    }
  }
  EXPECT_GT(left, 100);
  EXPECT_EQ(right, 0);
}

TEST(TextWidth, GrowsWithTheTextAndTheSize) {
  const double width = TextWidth("mesh", {10});
  EXPECT_GT(width, 15);
  EXPECT_NEAR(TextWidth("meshmesh", {10}), 2 * width, 1e-9);
  EXPECT_NEAR(TextWidth("mesh", {20}), 2 * width, 1e-2 * width);
  EXPECT_EQ(TextWidth("", {10}), 0);
}

}  // namespace
}  // namespace cohort

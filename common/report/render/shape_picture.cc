#include "common/report/render/shape_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "common/base/status_macros.h"
#include "common/report/axis_ticks.h"
#include "common/report/canvas.h"
#include "common/report/decimal.h"
#include "common/report/plot_style.h"
#include "common/report/render/camera.h"
#include "common/report/render/rasterizer.h"

namespace cohort {
namespace {

// Seen from the viewer's left to right: the face's right side comes first.
constexpr std::array<View, 3> kViews = {View::kRightThreeQuarter, View::kFront,
                                        View::kLeftThreeQuarter};
constexpr std::array<const char*, 3> kViewNames = {"right", "front", "left"};
constexpr double kCaption = 22;      // Height, points.
constexpr double kLegendWidth = 96;  // With its space on the left.
constexpr double kBarWidth = 14;
constexpr int kShades = 256;
constexpr int kLegendTicks = 6;
// Height of a picture for a width of one, whatever the shape.
constexpr double kFlattest = 0.6;
constexpr double kTallest = 1.8;

struct Views {
  std::array<Camera, 3> cameras;
  double aspect = 1;  // Width / height of each.
};

// The three views at one scale.
Views FitViews(const TriangleMesh& mesh) {
  const Facing facing = FacingOf(mesh);
  Views views;
  double half_width = 0;
  double half_height = 0;
  for (size_t i = 0; i < kViews.size(); ++i) {
    views.cameras[i] = FitCamera(mesh.vertices, facing, kViews[i]);
    half_width = std::max(half_width, views.cameras[i].half_width);
    half_height = std::max(half_height, views.cameras[i].half_height);
  }
  views.aspect = 1 / std::clamp(half_height / half_width, kFlattest, kTallest);
  for (Camera& camera : views.cameras) {
    camera.half_width = half_width;
    camera.half_height = half_height;
    camera = WithAspect(camera, views.aspect);
  }
  return views;
}

struct Page {
  Views views;
  double view_width = 0;  // Points.
  double view_height = 0;
  double legend_width = 0;
};

absl::StatusOr<Canvas> DrawViews(const TriangleMesh& mesh,
                                 std::span<const Rgb> colors,
                                 const ShapePictureOptions& options,
                                 const Page& page) {
  COHORT_ASSIGN_OR_RETURN(Canvas canvas, Canvas::Create(3 * page.view_width + page.legend_width,
                                                        page.view_height + kCaption));
  const auto pixels = [](double points) {
    return static_cast<int>(std::lround(points * Canvas::kPixelsPerPoint));
  };
  const RenderOptions render{.width = pixels(page.view_width),
                             .height = pixels(page.view_height),
                             .samples = options.samples};
  for (size_t i = 0; i < kViews.size(); ++i) {
    const Image image = RenderMesh(mesh, colors, page.views.cameras[i], render);
    const double x = static_cast<double>(i) * page.view_width;
    canvas.Cells({x, 0, page.view_width, page.view_height}, image.width, image.pixels);
    canvas.Text({x + page.view_width / 2, page.view_height + kCaption / 2}, kViewNames[i],
                kAxisStyle, Anchor::kMiddle);
  }
  return canvas;
}

bool HasGrey(const ShapeValues& values) {
  const ColorScale& scale = values.scale;
  return std::any_of(values.values.begin(), values.values.end(), [&](double value) {
    return !(value >= scale.lower_threshold && value <= scale.upper_threshold);
  });
}

void DrawLegend(const ShapeValues& values, const Page& page, Canvas& canvas) {
  const ColorScale& scale = values.scale;
  const double first = scale.First();
  const double last = scale.Last();
  const Box bar{3 * page.view_width + 22, 44, kBarWidth, page.view_height - 44 - 34};
  std::vector<Rgb> shades;
  shades.reserve(kShades);
  for (int i = kShades - 1; i >= 0; --i) {
    shades.push_back(scale.ColorOf(first + (last - first) * i / (kShades - 1.0)));
  }
  canvas.Cells(bar, 1, shades);
  canvas.Frame(bar, {kSoftInk, 0.5});
  canvas.Text({bar.x, 12}, values.title, kNoteStyle, Anchor::kStart);
  canvas.Text({bar.x, 28}, values.unit, kAxisStyle, Anchor::kStart);
  if (last > first) {
    const AxisTicks ticks = NiceTicks(first, last, kLegendTicks);
    for (const double tick : ticks.values) {
      const double y = bar.y + (1 - (tick - first) / (last - first)) * bar.height;
      const double right = bar.x + bar.width;
      canvas.Line(std::array<Spot, 2>{{{right, y}, {right + kTickLength, y}}}, {kInk, 0.75});
      canvas.Text({right + kTickLength + 4, y}, ticks.Text(tick), kTickStyle, Anchor::kStart);
    }
  } else {
    canvas.Text({bar.x + bar.width + kTickLength + 4, bar.y + bar.height / 2},
                ReadableDecimal(first, 3), kTickStyle, Anchor::kStart);
  }
  if (!HasGrey(values)) return;
  const double y = bar.y + bar.height + 16;
  canvas.Fill({bar.x, y - 6, kBarWidth, 12}, kNoValueColor);
  canvas.Text({bar.x + kBarWidth + kTickLength + 4, y}, values.grey, kTickStyle, Anchor::kStart);
}

Page LayOut(const TriangleMesh& mesh, const ShapePictureOptions& options) {
  Page page;
  page.views = FitViews(mesh);
  // Whole pixels, so that the pictures are not stretched.
  page.view_width = std::round(options.view_width);
  page.view_height = std::round(options.view_width / page.views.aspect);
  return page;
}

absl::Status CheckShape(const TriangleMesh& mesh) {
  if (mesh.VertexCount() < 1) return absl::InvalidArgumentError("picture: a shape of no vertex");
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::string> ShapeViewsPng(const TriangleMesh& mesh,
                                          const ShapePictureOptions& options) {
  COHORT_RETURN_IF_ERROR(CheckShape(mesh));
  COHORT_ASSIGN_OR_RETURN(Canvas canvas, DrawViews(mesh, {}, options, LayOut(mesh, options)));
  return canvas.Png();
}

absl::StatusOr<std::string> ShapeViewsPng(const TriangleMesh& mesh,
                                          const ShapeValues& values,
                                          const ShapePictureOptions& options) {
  COHORT_RETURN_IF_ERROR(CheckShape(mesh));
  if (std::ssize(values.values) != mesh.VertexCount()) {
    return absl::InvalidArgumentError("picture: " + std::to_string(values.values.size()) +
                                      " values for " + std::to_string(mesh.VertexCount()) +
                                      " vertices");
  }
  std::vector<Rgb> colors;
  colors.reserve(values.values.size());
  for (const double value : values.values) colors.push_back(values.scale.ColorOf(value));
  Page page = LayOut(mesh, options);
  page.legend_width = kLegendWidth;
  COHORT_ASSIGN_OR_RETURN(Canvas canvas, DrawViews(mesh, colors, options, page));
  DrawLegend(values, page, canvas);
  return canvas.Png();
}

}  // namespace cohort

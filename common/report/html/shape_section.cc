#include <array>

#include "common/base/status_macros.h"
#include "common/report/html/html_table.h"
#include "common/report/html/sections.h"
#include "common/report/render/shape_picture.h"
#include "common/report/render/variation_picture.h"

namespace cohort {
absl::StatusOr<std::string> ShapeSection(const ReportInput& input, Executor& executor) {
  std::array<absl::StatusOr<std::string>, 2> pictures;
  executor.ParallelFor(2, [&](int64_t i) {
    if (i == 0) {
      pictures[0] = ShapeViewsPng(input.mean_shape, ShapePictureOptions{});
    } else {
      pictures[1] = VariationPng(input.variation_shape, input.variation);
    }
  });
  COHORT_RETURN_IF_ERROR(pictures[0].status());
  COHORT_RETURN_IF_ERROR(pictures[1].status());
  const std::string meshes = Counted(input.variation.mesh_count, "mesh", "meshes");
  return HtmlSection(
      "shape", "Mean shape and variation",
      HtmlPicture(*pictures[0], "Mean shape from three views", "The mean shape (mean_shape.ply).") +
          HtmlPicture(*pictures[1], "Variation on the mean shape from three views",
                      "Where the set varies: RMS over " + meshes +
                          " of the distance of each vertex to the aligned mesh. The colours run "
                          "from the 2nd to the 98th percentile of the vertices (variation.ply has "
                          "all metrics)."));
}

}  // namespace cohort

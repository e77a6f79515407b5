#include "client/report_file.h"

#include "common/base/version.h"
#include "common/report/html/report_html.h"
#include "common/report/render/thumbnail.h"

namespace cohort {
namespace {

constexpr size_t kMostThumbnails = 300;
constexpr int64_t kMostVertices = 10'000'000;

struct Thumbnails {
  std::vector<std::string> pngs;  ///< One per row; none at all if there are too many.
  std::string note;
};

int64_t VerticesOf(const FetchedJob& fetched) {
  int64_t vertices = 0;
  for (const JobMesh& mesh : fetched.meshes) {
    if (mesh.ingested) vertices += mesh.ingested->vertices;
  }
  return vertices;
}

Thumbnails DrawThumbnails(Session& session, const FetchedJob& fetched, Executor& executor) {
  const std::vector<size_t> meshes = MeshesOfRows(fetched);
  if (meshes.size() > kMostThumbnails || VerticesOf(fetched) > kMostVertices) {
    return {{},
            "Without pictures of the meshes: only up to " + std::to_string(kMostThumbnails) +
                " meshes of 10 million vertices together have them."};
  }
  const std::vector<Similarity> transforms = TransformsOf(fetched);
  const ThumbnailView view = ViewOf(fetched.mean_shape);
  Thumbnails drawn{std::vector<std::string>(meshes.size()), ""};
  std::vector<absl::Status> failures(meshes.size());
  executor.ParallelFor(std::ssize(meshes), [&](int64_t i) {
    const auto row = static_cast<size_t>(i);
    absl::StatusOr<TriangleMesh> mesh = FetchJobMesh(session, fetched, meshes[row]);
    if (!mesh.ok()) {
      failures[row] = mesh.status();
      return;
    }
    mesh->vertices = transforms[meshes[row]].Apply(mesh->vertices);
    absl::StatusOr<std::string> png = ThumbnailPng(*mesh, view);
    if (png.ok()) {
      drawn.pngs[row] = *std::move(png);
    } else {
      failures[row] = png.status();
    }
  });
  int64_t missing = 0;
  for (const absl::Status& failure : failures) {
    if (failure.ok()) continue;
    if (missing++ == 0) drawn.note = "first: " + std::string(failure.message());
  }
  if (missing > 0) {
    drawn.note = Counted(missing, "picture is", "pictures are") + " missing; " + drawn.note;
  }
  return drawn;
}

}  // namespace

absl::StatusOr<std::string> MakeReport(Session& session,
                                       const FetchedJob& fetched,
                                       const MatrixDescription& description,
                                       const std::vector<std::vector<Neighbour>>& neighbours,
                                       const std::vector<std::string>& notes,
                                       Executor& executor) {
  const bool has_neighbours = description.sign == DistanceSign::kAbsolute;
  Thumbnails thumbnails;
  if (has_neighbours) thumbnails = DrawThumbnails(session, fetched, executor);
  const std::vector<std::vector<Neighbour>> none;
  return ReportHtml({.job = fetched.job,
                     .meshes = fetched.meshes,
                     .alignments = fetched.alignments,
                     .matrix = fetched.matrix.View(),
                     .description = description,
                     .persons = fetched.persons,
                     .neighbours = has_neighbours ? neighbours : none,
                     .mean_shape = fetched.mean_shape,
                     .variation_shape = fetched.variation_shape,
                     .variation = fetched.variation,
                     .thumbnails = thumbnails.pngs,
                     .thumbnails_note = thumbnails.note,
                     .notes = notes,
                     .software_version = "cohort " + std::string(BuildVersion())},
                    executor);
}

}  // namespace cohort

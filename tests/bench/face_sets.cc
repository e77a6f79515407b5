#include "tests/bench/face_sets.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <thread>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include "common/base/status_macros.h"
#include "common/base/thread_pool.h"
#include "common/geometry/io/draco_codec.h"
#include "common/geometry/io/read_mesh.h"
#include "common/geometry/io/write_mesh.h"
#include "common/geometry/mesh/mesh_health.h"
#include "common/geometry/nearest/packet_search.h"
#include "common/geometry/registration/scaling_icp.h"
#include "common/geometry/synthetic/demo_cohort.h"

namespace cohort {
namespace {

constexpr uint64_t kDemoSeed = 1;

absl::StatusOr<TriangleMesh> ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream bytes;
  bytes << file.rdbuf();
  if (!file) {
    return absl::NotFoundError(absl::StrCat(path, ": cannot be read"));
  }
  return ReadMesh(bytes.str(), path);
}

/// What ingest makes of a mesh as read from its file.
absl::StatusOr<TriangleMesh> Ingested(TriangleMesh mesh) {
  MeshHealth health;
  COHORT_RETURN_IF_ERROR(CheckAndClean(mesh, health));
  COHORT_ASSIGN_OR_RETURN(const std::string bytes, EncodeDraco(mesh));
  return DecodeDraco(bytes);
}

absl::Status WriteFile(const std::string& path, const std::string& bytes) {
  // Renamed when complete: an interrupted run leaves no half of a mesh.
  const std::string partial = path + ".partial";
  std::ofstream file(partial, std::ios::binary);
  file << bytes;
  file.close();
  std::error_code error;
  std::filesystem::rename(partial, path, error);
  if (!file || error) {
    return absl::UnknownError(absl::StrCat(path, ": cannot be written: ", error.message()));
  }
  return absl::OkStatus();
}

}  // namespace

BenchMesh::BenchMesh(TriangleMesh given)
    : mesh(std::move(given)), vertices(mesh.vertices.cast<float>()), packed(vertices) {}

TriangleMesh Centered(TriangleMesh mesh) {
  const Eigen::Vector3d center = mesh.vertices.rowwise().mean();
  mesh.vertices.colwise() -= center;
  mesh.vertices = mesh.vertices.cast<float>().cast<double>().eval();
  return mesh;
}

absl::StatusOr<TriangleMesh> ReadAsIngested(const std::string& path) {
  COHORT_ASSIGN_OR_RETURN(TriangleMesh mesh, ReadFile(path));
  return Ingested(std::move(mesh));
}

double NearestRms(const BenchMesh& source, const BenchMesh& target) {
  PacketSearch search;
  NearestSlots nearest;
  search.Find(source.packed, target.packed, nearest);
  double sum = 0;
  for (int slot = 0; slot < source.packed.VertexCount(); ++slot) {
    sum += static_cast<double>(nearest.squared_distances[static_cast<size_t>(slot)]);
  }
  return std::sqrt(sum / source.packed.VertexCount());
}

std::string FaceSets::MadePath(int vertices, int i) const {
  return absl::StrFormat("%s/faces_%d/face_%04d_0.ply", folder_, vertices, i);
}

std::string FaceSets::PreparedFolder(int vertices) const {
  return absl::StrCat(folder_, "/prepared_", MadeCount(vertices) > 0 ? "faces_" : "demo_",
                      vertices);
}

int FaceSets::MadeCount(int vertices) const {
  int count = 0;
  while (std::filesystem::exists(MadePath(vertices, count))) {
    ++count;
  }
  return count;
}

absl::StatusOr<TriangleMesh> FaceSets::MakeRaw(int vertices, int i) const {
  if (MadeCount(vertices) > 0) {
    return ReadAsIngested(MadePath(vertices, i));
  }
  DemoOptions options;
  options.people = i + 1;
  options.captures = 1;
  options.vertices = vertices;
  options.seed = kDemoSeed;
  options.identity_spread = demo_spread_;
  COHORT_ASSIGN_OR_RETURN(DemoScan scan, MakeDemoScan(options, i, 0));
  return Ingested(std::move(scan.mesh));
}

absl::StatusOr<TriangleMesh> FaceSets::Prepare(int vertices,
                                               int i,
                                               const TriangleMesh* reference) const {
  const std::string path = absl::StrFormat("%s/%04d.ply", PreparedFolder(vertices), i);
  if (std::filesystem::exists(path)) {
    return ReadFile(path);
  }
  COHORT_ASSIGN_OR_RETURN(TriangleMesh mesh, MakeRaw(vertices, i));
  mesh = Centered(std::move(mesh));
  if (reference != nullptr) {
    PacketSearch search;
    COHORT_ASSIGN_OR_RETURN(const Alignment alignment,
                            AlignByIcp(IcpMesh(mesh.vertices), IcpMesh(reference->vertices),
                                       Similarity{}, IcpOptions{}, search));
    mesh.vertices = alignment.T_target_source.Apply(mesh.vertices);
  }
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  COHORT_RETURN_IF_ERROR(WriteFile(path, WritePly(mesh)));
  return ReadFile(path);  // The float32 coordinates that the next run will see.
}

absl::StatusOr<std::span<const BenchMesh>> FaceSets::Get(int vertices, int count) {
  const int made = MadeCount(vertices);
  if (made > 0 && made < count) {
    return absl::NotFoundError(absl::StrCat(folder_, "/faces_", vertices, " has ", made,
                                            " faces, needed are ", count, ": start run.sh"));
  }
  std::vector<BenchMesh>& set = sets_[vertices];
  if (set.empty()) {
    COHORT_ASSIGN_OR_RETURN(TriangleMesh first, Prepare(vertices, 0, nullptr));
    set.emplace_back(std::move(first));
  }
  const int have = static_cast<int>(set.size());
  if (have < count) {
    std::vector<absl::StatusOr<TriangleMesh>> added(static_cast<size_t>(count - have));
    ThreadPool pool(static_cast<int>(std::thread::hardware_concurrency()));
    pool.ParallelFor(count - have, [&](int64_t i) {
      added[static_cast<size_t>(i)] =
          Prepare(vertices, have + static_cast<int>(i), &set.front().mesh);
    });
    for (absl::StatusOr<TriangleMesh>& mesh : added) {
      COHORT_RETURN_IF_ERROR(mesh.status());
      set.emplace_back(*std::move(mesh));
    }
  }
  return std::span<const BenchMesh>(set).first(static_cast<size_t>(count));
}

}  // namespace cohort

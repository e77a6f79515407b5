#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/geometry/io/write_mesh.h"
#include "common/geometry/synthetic/demo_cohort.h"
#include "common/jobs/job_state.h"
#include "common/store/blob_store.h"

namespace cohort::testing {

/// Puts a small synthetic cohort into `store` and returns its meshes, as a set would hold them.
inline std::vector<SetMesh> PutDemoScans(BlobStore& store,
                                         int people,
                                         int captures,
                                         int64_t vertices = 300) {
  DemoOptions options;
  options.people = people;
  options.captures = captures;
  options.vertices = vertices;
  std::vector<SetMesh> meshes;
  for (int person = 0; person < people; ++person) {
    for (int capture = 0; capture < captures; ++capture) {
      const DemoScan scan = *MakeDemoScan(options, person, capture);
      const std::string bytes = WritePly(scan.mesh);
      SetMesh mesh;
      mesh.name = scan.capture.file;
      mesh.raw = *store.Put(bytes);
      mesh.size_bytes = static_cast<int64_t>(bytes.size());
      mesh.labels["person"] = scan.capture.person;
      meshes.push_back(std::move(mesh));
    }
  }
  return meshes;
}

/// Adds a file that no reader accepts.
inline SetMesh PutBrokenScan(BlobStore& store, const std::string& name) {
  const std::string bytes = "ply\nformat ascii 1.0\nelement vertex 3\nend_header\n";
  SetMesh mesh;
  mesh.name = name;
  mesh.raw = *store.Put(bytes);
  mesh.size_bytes = static_cast<int64_t>(bytes.size());
  return mesh;
}

}  // namespace cohort::testing

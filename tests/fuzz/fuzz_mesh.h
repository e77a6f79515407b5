#pragma once

#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string_view>

#include <absl/status/statusor.h>

#include "common/geometry/io/draco_codec.h"
#include "common/geometry/io/read_mesh.h"
#include "common/geometry/mesh/mesh_health.h"

namespace cohort {

/// Small enough that a reader which believes a header shows up as memory, not as patience.
inline constexpr ReadLimits kFuzzLimits = {
    .max_bytes = 1 << 20, .max_vertices = 100'000, .max_faces = 200'000};

inline std::string_view AsText(const uint8_t* bytes, size_t size) {
  return {reinterpret_cast<const char*>(bytes), size};
}

/// Ends the process, which is how libFuzzer learns of a finding.
inline void Require(const absl::Status& status, std::string_view what) {
  if (!status.ok()) {
    std::cerr << what << ": " << status << '\n';
    std::abort();
  }
}

/// Cleans an accepted mesh and, if it is small, sends it through Draco and back.
inline void RequireMeshSurvives(TriangleMesh mesh) {
  constexpr int64_t kSmall = 2000;
  MeshHealth health;
  if (!CheckAndClean(mesh, health).ok() || mesh.VertexCount() > kSmall) {
    return;
  }
  const absl::StatusOr<std::string> encoded = EncodeDraco(mesh);
  Require(encoded.status(), "EncodeDraco");
  Require(DecodeDraco(*encoded).status(), "DecodeDraco");
}

/// A reader may refuse any bytes, but with a reason and the right code.
inline void RequireGoodAnswer(absl::StatusOr<TriangleMesh> mesh) {
  if (mesh.ok()) {
    RequireMeshSurvives(*std::move(mesh));
  } else if (mesh.status().code() != absl::StatusCode::kInvalidArgument &&
             mesh.status().code() != absl::StatusCode::kResourceExhausted) {
    Require(mesh.status(), "refused with a surprising code");
  }
}

}  // namespace cohort

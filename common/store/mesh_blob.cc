#include "common/store/mesh_blob.h"

#include <cstdint>
#include <span>
#include <utility>

#include "common/base/byte_io.h"
#include "common/base/status_macros.h"

namespace cohort {
namespace {

constexpr std::string_view kMagic = "COHMESH1";
constexpr uint8_t kRaw = 0;
constexpr uint8_t kDraco = 1;
constexpr uint64_t kVertexBytes = 3 * sizeof(double);
constexpr uint64_t kFaceBytes = 3 * sizeof(int32_t);

absl::Status BadMeshBlob(const std::string& why) {
  return absl::DataLossError("mesh blob: " + why);
}

absl::StatusOr<TriangleMesh> DecodeRaw(std::string_view bytes) {
  ByteReader reader(bytes);
  uint64_t n = 0;
  uint64_t m = 0;
  if (!reader.Get(n) || !reader.Get(m)) {
    return BadMeshBlob("cut short in its counts");
  }
  // Divisions first: the counts may be anything, their products may overflow.
  const uint64_t remaining = reader.Remaining();
  if (n > remaining / kVertexBytes || m > remaining / kFaceBytes ||
      n * kVertexBytes + m * kFaceBytes != remaining) {
    return BadMeshBlob(std::to_string(n) + " vertices and " + std::to_string(m) +
                       " faces do not fit in " + std::to_string(remaining) + " bytes");
  }
  TriangleMesh mesh;
  mesh.vertices.resize(3, static_cast<Eigen::Index>(n));
  mesh.faces.resize(3, static_cast<Eigen::Index>(m));
  const bool complete = reader.GetArray(std::span<double>(mesh.vertices.data(), 3 * n)) &&
                        reader.GetArray(std::span<int32_t>(mesh.faces.data(), 3 * m));
  if (!complete) {
    return BadMeshBlob("cut short");
  }
  for (Eigen::Index face = 0; face < mesh.faces.cols(); ++face) {
    const auto corners = mesh.faces.col(face);
    const int32_t lowest = corners.minCoeff();
    const int32_t highest = corners.maxCoeff();
    if (lowest < 0 || highest >= mesh.vertices.cols()) {
      return BadMeshBlob("face " + std::to_string(face) + " uses vertex " +
                         std::to_string(lowest < 0 ? lowest : highest) + " of " +
                         std::to_string(n));
    }
  }
  return mesh;
}

}  // namespace

std::string EncodeRawMeshBlob(const TriangleMesh& mesh) {
  ByteWriter writer;
  writer.PutBytes(kMagic);
  writer.Put(kRaw);
  writer.Put(static_cast<uint64_t>(mesh.VertexCount()));
  writer.Put(static_cast<uint64_t>(mesh.FaceCount()));
  writer.PutArray(
      std::span<const double>(mesh.vertices.data(), static_cast<size_t>(mesh.vertices.size())));
  writer.PutArray(
      std::span<const int32_t>(mesh.faces.data(), static_cast<size_t>(mesh.faces.size())));
  return std::move(writer).Take();
}

absl::StatusOr<std::string> EncodeDracoMeshBlob(const TriangleMesh& mesh,
                                                const DracoOptions& options) {
  COHORT_ASSIGN_OR_RETURN(const std::string draco, EncodeDraco(mesh, options));
  ByteWriter writer;
  writer.PutBytes(kMagic);
  writer.Put(kDraco);
  writer.PutBytes(draco);
  return std::move(writer).Take();
}

absl::StatusOr<TriangleMesh> DecodeMeshBlob(std::string_view bytes) {
  if (!bytes.starts_with(kMagic)) {
    return BadMeshBlob("does not begin with " + std::string(kMagic));
  }
  ByteReader reader(bytes.substr(kMagic.size()));
  uint8_t encoding = 0;
  if (!reader.Get(encoding)) {
    return BadMeshBlob("cut short before its encoding");
  }
  switch (encoding) {
    case kRaw:
      return DecodeRaw(reader.Rest());
    case kDraco:
      return DecodeDraco(reader.Rest());
    default:
      return BadMeshBlob("unknown encoding " + std::to_string(encoding));
  }
}

}  // namespace cohort

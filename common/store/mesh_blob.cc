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
constexpr uint8_t kFile = 2;
constexpr uint64_t kVertexBytes = 3 * sizeof(double);
constexpr uint64_t kFloatVertexBytes = 3 * sizeof(float);
constexpr uint64_t kFaceBytes = 3 * sizeof(int32_t);

absl::Status BadMeshBlob(const std::string& why) {
  return absl::DataLossError("mesh blob: " + why);
}

absl::Status CheckFaces(const Matrix3Xi& faces, Eigen::Index vertices) {
  for (Eigen::Index face = 0; face < faces.cols(); ++face) {
    const auto corners = faces.col(face);
    const int32_t lowest = corners.minCoeff();
    const int32_t highest = corners.maxCoeff();
    if (lowest < 0 || highest >= vertices) {
      return BadMeshBlob("face " + std::to_string(face) + " uses vertex " +
                         std::to_string(lowest < 0 ? lowest : highest) + " of " +
                         std::to_string(vertices));
    }
  }
  return absl::OkStatus();
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
  COHORT_RETURN_IF_ERROR(CheckFaces(mesh.faces, mesh.vertices.cols()));
  return mesh;
}

template <typename T>
std::span<const T> Numbers(const Eigen::Matrix<T, 3, Eigen::Dynamic>& columns) {
  return {columns.data(), static_cast<size_t>(columns.size())};
}

/// Makes room for `count` columns and fills it.
template <typename T>
bool GetColumns(ByteReader& reader, uint64_t count, Eigen::Matrix<T, 3, Eigen::Dynamic>& columns) {
  columns.resize(3, static_cast<Eigen::Index>(count));
  return reader.GetArray(std::span<T>(columns.data(), 3 * count));
}

absl::StatusOr<FileMesh> DecodeFile(std::string_view bytes) {
  ByteReader reader(bytes);
  uint64_t n = 0;
  uint64_t m = 0;
  uint64_t k = 0;
  if (!reader.Get(n) || !reader.Get(m) || !reader.Get(k)) {
    return BadMeshBlob("cut short in its counts");
  }
  const uint64_t remaining = reader.Remaining();
  const bool fits = n <= remaining / kFloatVertexBytes && m <= remaining / kFaceBytes &&
                    (k == 0 || k == n) && (n + k) * kFloatVertexBytes + m * kFaceBytes == remaining;
  if (!fits || n == 0) {
    return BadMeshBlob(std::to_string(n) + " vertices, " + std::to_string(m) + " faces and " +
                       std::to_string(k) + " normals do not fit in " + std::to_string(remaining) +
                       " bytes");
  }
  FileMesh mesh;
  if (!GetColumns(reader, n, mesh.vertices) || !GetColumns(reader, m, mesh.faces) ||
      !GetColumns(reader, k, mesh.normals)) {
    return BadMeshBlob("cut short");
  }
  if (!mesh.vertices.allFinite() || !mesh.normals.allFinite()) {
    return BadMeshBlob("a coordinate or a normal is not finite");
  }
  COHORT_RETURN_IF_ERROR(CheckFaces(mesh.faces, mesh.vertices.cols()));
  return mesh;
}

/// The encoding, and in `rest` what follows it.
absl::StatusOr<uint8_t> EncodingOf(std::string_view bytes, std::string_view& rest) {
  if (!bytes.starts_with(kMagic)) {
    return BadMeshBlob("does not begin with " + std::string(kMagic));
  }
  ByteReader reader(bytes.substr(kMagic.size()));
  uint8_t encoding = 0;
  if (!reader.Get(encoding)) {
    return BadMeshBlob("cut short before its encoding");
  }
  rest = reader.Rest();
  return encoding;
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

std::string EncodeFileMeshBlob(const FileMesh& mesh) {
  ByteWriter writer;
  writer.PutBytes(kMagic);
  writer.Put(kFile);
  writer.Put(static_cast<uint64_t>(mesh.vertices.cols()));
  writer.Put(static_cast<uint64_t>(mesh.faces.cols()));
  writer.Put(static_cast<uint64_t>(mesh.normals.cols()));
  writer.PutArray(Numbers(mesh.vertices));
  writer.PutArray(Numbers(mesh.faces));
  writer.PutArray(Numbers(mesh.normals));
  return std::move(writer).Take();
}

absl::StatusOr<TriangleMesh> DecodeMeshBlob(std::string_view bytes) {
  std::string_view rest;
  COHORT_ASSIGN_OR_RETURN(const uint8_t encoding, EncodingOf(bytes, rest));
  switch (encoding) {
    case kRaw:
      return DecodeRaw(rest);
    case kDraco:
      return DecodeDraco(rest);
    case kFile: {
      COHORT_ASSIGN_OR_RETURN(FileMesh file, DecodeFile(rest));
      TriangleMesh mesh;
      mesh.vertices = file.vertices.cast<double>();
      mesh.faces = std::move(file.faces);
      return mesh;
    }
    default:
      return BadMeshBlob("unknown encoding " + std::to_string(encoding));
  }
}

bool IsFileMeshBlob(std::string_view bytes) {
  std::string_view rest;
  const absl::StatusOr<uint8_t> encoding = EncodingOf(bytes, rest);
  return encoding.ok() && *encoding == kFile;
}

absl::StatusOr<FileMesh> DecodeFileMeshBlob(std::string_view bytes) {
  std::string_view rest;
  COHORT_ASSIGN_OR_RETURN(const uint8_t encoding, EncodingOf(bytes, rest));
  if (encoding != kFile) {
    return BadMeshBlob("has encoding " + std::to_string(encoding) + ", not a mesh as in its file");
  }
  return DecodeFile(rest);
}

}  // namespace cohort

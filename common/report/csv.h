#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/analysis/metric_matrix.h"
#include "common/geometry/comparison/metrics.h"
#include "common/jobs/blobs.h"
#include "common/jobs/job_state.h"

namespace cohort {

// Tables as RFC 4180: comma, CRLF after every row, a field with a comma, quote, line break or outer
// space in quotes. UTF-8 without a byte order mark (R would read it into the first column's name).
// Numbers are ShortestDecimal; what is unknown is "NA"; truth is "TRUE" or "FALSE" (what R and
// spreadsheets read as such). Labels are written as they are, also those that a spreadsheet takes
// for a formula ("=1+1.ply"): a changed file name would match nothing any more.

/// One row with its line end.
[[nodiscard]] std::string CsvRow(std::span<const std::string> fields);

/// The matrix: a header of MetricName(metric) and the N labels, then per mesh its label and N
/// values. Row = source, column = target. In R: read.csv(file, row.names = 1, check.names = FALSE).
[[nodiscard]] std::string MatrixCsv(const MatrixView& matrix, Metric metric);
/// The same with another word in the corner.
[[nodiscard]] std::string MatrixCsv(const MatrixView& matrix, std::string_view corner);

/// Its parts, for a matrix whose text is larger than memory: the header, then row after row.
[[nodiscard]] std::string MatrixCsvHeader(const MatrixView& matrix, std::string_view corner);
[[nodiscard]] std::string MatrixCsvRow(const MatrixView& matrix, Eigen::Index row);

/// Ranked neighbours: "mesh,rank,neighbour,value", rank from 1; with persons also
/// "person,neighbour_person,same_person" (NA where one of them is unknown).
/// @param neighbours  one list per row of the matrix.
/// @param persons  one per row, "" for unknown (PersonsOf); none, or all unknown: no such columns.
[[nodiscard]] std::string NeighboursCsv(const MatrixView& matrix,
                                        std::span<const std::vector<Neighbour>> neighbours,
                                        std::span<const std::string> persons);

/// One row per mesh of the job, rejected ones too: "file,status,reason", a column per label key
/// (sorted; "label_" before a key that is the name of another column), the file's sha256 and size,
/// the canonical mesh, the health of the file (file_vertices ... warnings), the alignment, and
/// "pose_rms" (residual of the coarse pose: of the landmarks, or of sampled points), "asymmetry"
/// (of jobs with symmetric copies).
/// @param meshes  the job's order.
/// @param alignments, poses  by MeshAlignment::mesh, an index into `meshes`; meshes without one
///                           have NA.
[[nodiscard]] std::string MeshesCsv(std::span<const JobMesh> meshes,
                                    std::span<const MeshAlignment> alignments,
                                    std::span<const MeshAlignment> poses);

/// "rank,file,mean_distance" of the candidates for the base, the chosen one first: how much nearer
/// to all others it is than the next says how clear the choice was.
[[nodiscard]] std::string BaseChoiceCsv(std::span<const JobMesh> meshes, const BaseChoice& choice);

/// "file,scale,r11,...,r33,tx,ty,tz" of each aligned mesh: x_reference = scale * R * x_file + t.
[[nodiscard]] std::string TransformsCsv(std::span<const JobMesh> meshes,
                                        std::span<const MeshAlignment> alignments);

}  // namespace cohort

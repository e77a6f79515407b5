// The known truth of a demo cohort: CSV texts and true distances (declared in demo_cohort.h).
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/registration/similarity.h"
#include "common/geometry/synthetic/demo_cohort.h"
#include "common/geometry/synthetic/procedural_face.h"

namespace cohort {
namespace {

constexpr size_t kMaxScans = 2000;
constexpr int kGridStep = 4;  // mm in the parameter domain

/// Shortest text that reads back to the same double, with a point whatever the locale.
std::string Exact(double value) {
  std::array<char, 32> buffer = {};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return std::string(buffer.data(), result.ptr);
}

/// A field of a CSV file, quoted if it has to be (RFC 4180).
std::string Field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) {
    return text;
  }
  std::string quoted(1, '"');
  for (const char c : text) {
    quoted.append(c == '"' ? 2 : 1, c);
  }
  quoted.push_back('"');
  return quoted;
}

std::string NameFields(const DemoCapture& capture) {
  return absl::StrCat(Field(capture.file), ",", Field(capture.person), ",", Field(capture.capture));
}

/// Points of the noise-free face in its canonical pose; column i means the same on every face.
Eigen::Matrix3Xd CorrespondingPoints(const FaceParameters& parameters) {
  const ProceduralFace face(parameters);
  std::vector<Eigen::Vector3d> points;
  for (int v = -96; v <= 88; v += kGridStep) {
    for (int u = -80; u <= 80; u += kGridStep) {
      const double a = u / 84.0;
      const double b = (v + 4) / 96.0;
      if (a * a * a * a + b * b * b * b <= 1.0) {
        points.push_back(face.Point(u, v));
      }
    }
  }
  Eigen::Matrix3Xd matrix(3, static_cast<Eigen::Index>(points.size()));
  for (size_t i = 0; i < points.size(); ++i) {
    matrix.col(static_cast<Eigen::Index>(i)) = points[i];
  }
  return matrix;
}

absl::StatusOr<double> RmsAfterFit(const Eigen::Matrix3Xd& source, const Eigen::Matrix3Xd& target) {
  COHORT_ASSIGN_OR_RETURN(const Similarity T_target_source,
                          FitSimilarity(source, target, ScaleMode::kFree));
  const Eigen::Matrix3Xd residuals = T_target_source.Apply(source) - target;
  return std::sqrt(residuals.squaredNorm() / static_cast<double>(residuals.cols()));
}

}  // namespace

std::string LabelsCsv(std::span<const DemoCapture> captures) {
  std::string csv = "file,person,capture,expression\n";
  for (const DemoCapture& capture : captures) {
    absl::StrAppend(&csv, NameFields(capture), ",", Field(capture.expression), "\n");
  }
  return csv;
}

std::string TruthCsv(std::span<const DemoCapture> captures) {
  std::string csv = "file,person,capture,scale,qw,qx,qy,qz,tx,ty,tz\n";
  for (const DemoCapture& capture : captures) {
    const Similarity& T = capture.pose.T_file_canonical;
    absl::StrAppend(&csv, NameFields(capture), ",", Exact(T.scale));
    for (Eigen::Index i = 0; i < 4; ++i) {
      absl::StrAppend(&csv, ",", Exact(capture.pose.quaternion(i)));
    }
    for (Eigen::Index i = 0; i < 3; ++i) {
      absl::StrAppend(&csv, ",", Exact(T.translation(i)));
    }
    csv += "\n";
  }
  return csv;
}

absl::StatusOr<Eigen::MatrixXd> TruthRms(std::span<const DemoCapture> captures,
                                         Executor& executor) {
  if (captures.size() > kMaxScans) {
    return absl::InvalidArgumentError("demo: true distances of " + std::to_string(captures.size()) +
                                      " scans, at most " + std::to_string(kMaxScans) +
                                      " are possible");
  }
  const auto count = static_cast<int64_t>(captures.size());
  std::vector<Eigen::Matrix3Xd> shapes(captures.size());
  executor.ParallelFor(count, [&](int64_t i) {
    shapes[static_cast<size_t>(i)] = CorrespondingPoints(captures[static_cast<size_t>(i)].face);
  });
  Eigen::MatrixXd rms = Eigen::MatrixXd::Zero(count, count);
  std::vector<absl::Status> statuses(captures.size());
  executor.ParallelFor(count, [&](int64_t i) {
    for (int64_t j = 0; j < count; ++j) {
      if (i == j) {
        continue;
      }
      const absl::StatusOr<double> value =
          RmsAfterFit(shapes[static_cast<size_t>(i)], shapes[static_cast<size_t>(j)]);
      if (!value.ok()) {
        statuses[static_cast<size_t>(i)] = value.status();
        return;
      }
      rms(i, j) = *value;
    }
  });
  for (const absl::Status& status : statuses) {
    COHORT_RETURN_IF_ERROR(status);
  }
  return rms;
}

std::string TruthRmsCsv(std::span<const DemoCapture> captures,
                        const Eigen::Ref<const Eigen::MatrixXd>& rms) {
  std::string csv = "file";
  for (const DemoCapture& capture : captures) {
    absl::StrAppend(&csv, ",", Field(capture.file));
  }
  csv += "\n";
  for (size_t i = 0; i < captures.size(); ++i) {
    csv += Field(captures[i].file);
    for (Eigen::Index j = 0; j < rms.cols(); ++j) {
      absl::StrAppend(&csv, ",", Exact(rms(static_cast<Eigen::Index>(i), j)));
    }
    csv += "\n";
  }
  return csv;
}

}  // namespace cohort

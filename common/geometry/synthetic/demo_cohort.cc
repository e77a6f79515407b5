#include "common/geometry/synthetic/demo_cohort.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "common/base/status_macros.h"
#include "common/geometry/synthetic/portable_math.h"
#include "common/geometry/synthetic/procedural_face.h"

namespace cohort {
namespace {

/// Streams of random numbers under the seed of the options.
enum Stream : uint64_t { kPersonStream = 1, kExpressionStream, kPoseStream, kScanStream };

std::string Plain(double value) {
  std::string text = std::to_string(value);  // six decimals; cut the zeros for people
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') {
    text.pop_back();
  }
  return text;
}

absl::Status CheckRange(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) {  // false for NaN
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(std::string("demo: ") + name + " is " + Plain(value) +
                                    ", must be " + Plain(low) + " to " + Plain(high));
}

uint64_t CaptureSeed(const DemoOptions& options, Stream stream, int person, int capture) {
  return StreamSeed(StreamSeed(options.seed, stream, 0), static_cast<uint64_t>(person),
                    static_cast<uint64_t>(capture));
}

std::string PersonName(int person, int people) {
  const std::string number = std::to_string(person + 1);
  const size_t width = std::max<size_t>(2, std::to_string(people).size());
  return "person" + std::string(width - number.size(), '0') + number;
}

/// The options are valid and the scan exists.
DemoCapture Describe(const DemoOptions& options, int person, int capture) {
  DemoCapture described;
  described.person = PersonName(person, options.people);
  described.capture = std::string(1, static_cast<char>('a' + capture));
  described.file = described.person + "_" + described.capture + ".ply";
  described.face =
      DrawPerson(CaptureSeed(options, kPersonStream, person, 0), options.identity_spread);
  if (capture > 0) {
    described.face.expression = DrawExpression(
        CaptureSeed(options, kExpressionStream, person, capture), options.expression_strength);
  }
  described.expression = DescribeExpression(described.face.expression);
  described.pose = DrawPose(CaptureSeed(options, kPoseStream, person, capture), options.pose);
  return described;
}

void ApplyPose(const Similarity& T, TriangleMesh& mesh) {
  const Eigen::Matrix3d& R = T.rotation;
  for (Eigen::Index i = 0; i < mesh.vertices.cols(); ++i) {
    const Eigen::Vector3d p = mesh.vertices.col(i);
    for (Eigen::Index k = 0; k < 3; ++k) {  // written out: the order of the sum is fixed
      const double turned = R(k, 0) * p.x() + R(k, 1) * p.y() + R(k, 2) * p.z();
      mesh.vertices(k, i) = T.scale * turned + T.translation(k);
    }
  }
}

DemoScan Make(const DemoOptions& options, int person, int capture) {
  DemoScan scan;
  scan.capture = Describe(options, person, capture);
  const ProceduralFace face(scan.capture.face);
  scan.mesh = CaptureFace(face, CaptureSeed(options, kScanStream, person, capture),
                          {options.vertices, options.noise, options.warp});
  ApplyPose(scan.capture.pose.T_file_canonical, scan.mesh);
  return scan;
}

absl::Status CheckScan(const DemoOptions& options, int person, int capture) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  if (person < 0 || person >= options.people || capture < 0 || capture >= options.captures) {
    return absl::OutOfRangeError("demo: no capture " + std::to_string(capture) + " of person " +
                                 std::to_string(person) + " among " +
                                 std::to_string(options.people) + " people with " +
                                 std::to_string(options.captures) + " captures");
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status DemoOptions::Validate() const {
  COHORT_RETURN_IF_ERROR(CheckRange("people", people, 1, 100000));
  COHORT_RETURN_IF_ERROR(CheckRange("captures", captures, 1, 26));
  COHORT_RETURN_IF_ERROR(CheckRange("vertices", static_cast<double>(vertices), 100, 2000000));
  COHORT_RETURN_IF_ERROR(CheckRange("identity_spread", identity_spread, 0, 2));
  COHORT_RETURN_IF_ERROR(CheckRange("expression_strength", expression_strength, 0, 1));
  COHORT_RETURN_IF_ERROR(CheckRange("noise", noise, 0, 1));
  COHORT_RETURN_IF_ERROR(CheckRange("warp", warp, 0, 2));
  COHORT_RETURN_IF_ERROR(CheckRange("max_rotation_degrees", pose.max_rotation_degrees, 0, 180));
  COHORT_RETURN_IF_ERROR(CheckRange("max_translation", pose.max_translation, 0, 10000));
  return CheckRange("scale_sd", pose.scale_sd, 0, 0.2);
}

absl::StatusOr<DemoCapture> DescribeDemoCapture(const DemoOptions& options,
                                                int person,
                                                int capture) {
  COHORT_RETURN_IF_ERROR(CheckScan(options, person, capture));
  return Describe(options, person, capture);
}

absl::StatusOr<std::vector<DemoCapture>> DescribeDemoCohort(const DemoOptions& options) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  std::vector<DemoCapture> captures;
  captures.reserve(static_cast<size_t>(options.people) * static_cast<size_t>(options.captures));
  for (int person = 0; person < options.people; ++person) {
    for (int capture = 0; capture < options.captures; ++capture) {
      captures.push_back(Describe(options, person, capture));
    }
  }
  return captures;
}

absl::StatusOr<DemoScan> MakeDemoScan(const DemoOptions& options, int person, int capture) {
  COHORT_RETURN_IF_ERROR(CheckScan(options, person, capture));
  return Make(options, person, capture);
}

absl::StatusOr<std::vector<DemoScan>> MakeDemoCohort(const DemoOptions& options,
                                                     Executor& executor) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  const int64_t count = int64_t{options.people} * options.captures;
  std::vector<DemoScan> scans(static_cast<size_t>(count));
  executor.ParallelFor(count, [&](int64_t i) {
    scans[static_cast<size_t>(i)] = Make(options, static_cast<int>(i / options.captures),
                                         static_cast<int>(i % options.captures));
  });
  return scans;
}

}  // namespace cohort

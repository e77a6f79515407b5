// `cohort pair`: two meshes of a job; `cohort compare`: two files.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>

#include <absl/strings/str_cat.h>
#include <nlohmann/json.hpp>

#include "client/commands/command.h"
#include "client/files.h"
#include "client/job_flags.h"
#include "client/job_source.h"
#include "client/output/exit_codes.h"
#include "client/pair_files.h"
#include "common/base/status_macros.h"
#include "common/geometry/mesh/bounds.h"
#include "common/pairs/align_mesh.h"
#include "common/pairs/canonical_mesh.h"

namespace cohort {
namespace {

struct PairFlags {
  JobSource source;
  std::string a;
  std::string b;
  std::string out;
  bool is_signed = false;
  bool json = false;
  JobFlags spec;           ///< Of compare.
  bool keep_pose = false;  ///< Of compare.

  [[nodiscard]] DistanceSign Sign() const {
    return is_signed ? DistanceSign::kSigned : DistanceSign::kAbsolute;
  }
};

/// Prints the numbers, and where the files are.
void Print(const PairFlags& flags,
           bool as_json,
           const std::string& heading,
           const std::vector<SideDistances>& sides,
           const nlohmann::json& numbers) {
  if (as_json) {
    std::cout << numbers.dump(2) << "\n";
    return;
  }
  std::cout << heading << "\n" << SidesToText(sides);
  if (!flags.out.empty()) {
    std::cout << "  " << (std::filesystem::path(flags.out) / "distances_a_to_b.png").string()
              << ", .ply, .csv, histogram.png\n";
  }
}

absl::StatusOr<int> RunPair(const PairFlags& flags) {
  COHORT_ASSIGN_OR_RETURN(const OpenedJob opened, flags.source.Open());
  COHORT_ASSIGN_OR_RETURN(const auto frame,
                          JobFrame::Open(*opened.session, opened.Blobs(), opened.id));
  COHORT_ASSIGN_OR_RETURN(const int32_t first, frame->IndexOf(flags.a));
  COHORT_ASSIGN_OR_RETURN(const int32_t second, frame->IndexOf(flags.b));
  const CompareOptions& compare = frame->GetJob().spec.compare;
  const PairMeshOptions options = {.compare = compare, .sign = flags.Sign()};
  COHORT_ASSIGN_OR_RETURN(const FramedMesh a_mesh, frame->Load(first, options));
  COHORT_ASSIGN_OR_RETURN(const FramedMesh b_mesh, frame->Load(second, options));
  const PairSide a = {flags.a, a_mesh};
  const PairSide b = {flags.b, b_mesh};
  COHORT_ASSIGN_OR_RETURN(const auto sides, MeasureSides(a, b, compare, flags.Sign()));
  nlohmann::json numbers = SidesToJson(sides, flags.Sign());
  numbers["job"] = opened.id.value;
  if (!flags.out.empty()) {
    COHORT_RETURN_IF_ERROR(WritePairFiles(flags.out, a, b, sides, flags.Sign(), numbers));
  }
  Print(flags, flags.source.server.json,
        absl::StrCat("a = ", flags.a, ", b = ", flags.b, ", as aligned by job ", opened.id.value),
        sides, numbers);
  return kExitOk;
}

absl::StatusOr<TriangleMesh> ReadCanonical(const std::string& file, int position_bits) {
  COHORT_ASSIGN_OR_RETURN(const std::string bytes, ReadWholeFile(file));
  COHORT_ASSIGN_OR_RETURN(
      CanonicalMesh canonical,
      MakeCanonical(bytes, std::filesystem::path(file).filename().string(), position_bits));
  return std::move(canonical.mesh);
}

absl::StatusOr<int> RunCompare(const PairFlags& flags) {
  COHORT_ASSIGN_OR_RETURN(const JobSpec spec, flags.spec.ToSpec());
  if (flags.spec.UsesLandmarks()) {
    return absl::InvalidArgumentError(
        "--landmarks is for jobs: use cohort run with a folder of the two meshes");
  }
  COHORT_ASSIGN_OR_RETURN(TriangleMesh a, ReadCanonical(flags.a, spec.position_bits));
  COHORT_ASSIGN_OR_RETURN(TriangleMesh b, ReadCanonical(flags.b, spec.position_bits));
  Alignment alignment;
  if (!flags.keep_pose) {
    COHORT_ASSIGN_OR_RETURN(alignment, AlignMeshTo(a, b, spec));
  }
  const Eigen::Vector3d center = CentroidOf(b.vertices);
  const PairMeshOptions options = {.compare = spec.compare, .sign = flags.Sign()};
  COHORT_ASSIGN_OR_RETURN(PairMesh a_placed,
                          MakePairMesh(a, alignment.T_target_source, center, options));
  COHORT_ASSIGN_OR_RETURN(PairMesh b_placed, MakePairMesh(b, Similarity{}, center, options));
  const FramedMesh a_mesh{std::move(a), alignment.T_target_source, std::move(a_placed)};
  const FramedMesh b_mesh{std::move(b), Similarity{}, std::move(b_placed)};
  const PairSide a_side = {std::filesystem::path(flags.a).filename().string(), a_mesh};
  const PairSide b_side = {std::filesystem::path(flags.b).filename().string(), b_mesh};
  COHORT_ASSIGN_OR_RETURN(const auto sides,
                          MeasureSides(a_side, b_side, spec.compare, flags.Sign()));
  nlohmann::json numbers = SidesToJson(sides, flags.Sign());
  numbers["alignment"] = {
      {"kept_pose", flags.keep_pose},     {"iterations", alignment.iterations},
      {"converged", alignment.converged}, {"rms_residual", alignment.rms_residual},
      {"overlap", alignment.overlap},     {"scale", alignment.T_target_source.scale}};
  if (!flags.out.empty()) {
    COHORT_RETURN_IF_ERROR(WritePairFiles(flags.out, a_side, b_side, sides, flags.Sign(), numbers));
  }
  std::string heading = absl::StrCat("a = ", flags.a, ", b = ", flags.b);
  if (!flags.keep_pose) {
    absl::StrAppend(&heading, "; a moved onto b in ", alignment.iterations, " iterations, scale ",
                    alignment.T_target_source.scale,
                    alignment.converged ? "" : "; NOT CONVERGED, see --max-iterations");
  }
  Print(flags, flags.json, heading, sides, numbers);
  return kExitOk;
}

void AddFileOptions(CLI::App& command, PairFlags& flags) {
  command.add_option(
      "--out", flags.out,
      "folder for distance maps (PLY, CSV, PNG), histogram and numbers; made if new");
  command.add_flag("--signed", flags.is_signed,
                   "positive in front of the other mesh, negative behind it");
}

}  // namespace

void AddPairCommand(CLI::App& app, Action& action) {
  CLI::App* command =
      app.add_subcommand("pair", "the distances of two meshes of a job, vertex by vertex");
  const auto flags = std::make_shared<PairFlags>();
  flags->source.AddTo(*command);
  command->add_option("a", flags->a, "name of a mesh of the job")->required();
  command->add_option("b", flags->b, "name of another one")->required();
  AddFileOptions(*command, *flags);
  command->callback([flags, &action] { action = [flags] { return RunPair(*flags); }; });
  command->footer("Example: cohort pair j-000001 anna.ply berta.ply --out pair");
}

void AddCompareCommand(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand(
      "compare", "align one mesh file to another and measure both directions, on this machine");
  const auto flags = std::make_shared<PairFlags>();
  command->add_option("a", flags->a, "mesh file that moves")->required();
  command->add_option("b", flags->b, "mesh file that stays")->required();
  command->add_flag("--json", flags->json, "print JSON for scripts");
  AddFileOptions(*command, *flags);
  command->add_flag("--keep-pose", flags->keep_pose, "measure the meshes where they are");
  flags->spec.AddPairOptionsTo(*command);
  command->callback([flags, &action] { action = [flags] { return RunCompare(*flags); }; });
  command->footer("Example: cohort compare before.ply after.ply --signed --out change");
}

}  // namespace cohort

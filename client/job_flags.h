#pragma once

#include <absl/status/statusor.h>
#include <CLI/CLI.hpp>

#include <optional>
#include <string>
#include <vector>

#include "common/jobs/job_spec.h"

namespace cohort {

/// The options of a job on the command line: a preset, and what differs from it.
struct JobFlags {
  std::string preset = "default";
  std::string method = "average";
  std::optional<std::string> base;
  std::optional<int> rounds;
  std::optional<std::string> pose;
  std::vector<std::string> landmarks;  ///< Files and folders.
  bool symmetric_copies = false;
  std::optional<double> mean_tolerance;
  std::optional<std::string> scale;
  std::optional<double> scale_limit;
  std::optional<int> max_iterations;
  std::optional<double> tolerance;
  std::optional<std::string> acceleration;
  std::optional<double> trim;
  std::optional<double> distance_limit;
  std::optional<std::string> align_boundary;
  std::optional<std::string> correspondence;
  std::optional<std::string> undersample;
  std::optional<std::string> distance;
  std::optional<std::string> boundary;
  std::optional<std::string> retention;
  std::optional<double> retention_budget_gb;
  bool preview = false;
  bool fresh = false;
  std::string reference;
  int priority = 0;
  bool signed_distances = false;
  std::optional<std::string> metric;
  std::optional<std::string> symmetrize;
  std::optional<int> neighbours;
  std::optional<int> position_bits;
  std::optional<double> size_ratio_limit;

  void AddTo(CLI::App& command);
  /// The options that are about two meshes: how they are aligned, and what a distance is.
  void AddPairOptionsTo(CLI::App& command);
  /// All but JobSpec::landmarks, which needs the meshes: MakeLandmarkBlob, if UsesLandmarks.
  /// @return kInvalidArgument naming the option and what was expected.
  [[nodiscard]] absl::StatusOr<JobSpec> ToSpec() const;
  [[nodiscard]] bool UsesLandmarks() const { return !landmarks.empty(); }

 private:
  void AddAlignmentOptionsTo(CLI::App& command);
  void AddComparisonOptionsTo(CLI::App& command);
  void AddDistanceOptionsTo(CLI::App& command);
  absl::Status SetPose(JobSpec& spec) const;
  absl::Status SetAlignment(JobSpec& spec) const;
  absl::Status SetComparison(JobSpec& spec) const;
  /// @return kInvalidArgument if options are given that the reference job has decided.
  absl::Status KeepReference(JobSpec& spec) const;
};

}  // namespace cohort

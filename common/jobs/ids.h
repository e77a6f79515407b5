#pragma once

#include <compare>
#include <cstdint>
#include <string>

namespace cohort {

/// Name of a job, e.g. "j-000012"; given by the server.
struct JobId {
  std::string value;
  friend bool operator==(const JobId&, const JobId&) = default;
  friend auto operator<=>(const JobId&, const JobId&) = default;
};

/// A task: the number counts from 0 in the order in which the plan made it.
struct TaskId {
  JobId job;
  int64_t number = 0;
  friend bool operator==(const TaskId&, const TaskId&) = default;
  friend auto operator<=>(const TaskId&, const TaskId&) = default;
};

/// Name that a worker process chose for itself, unique in practice (host, process, random).
struct WorkerId {
  std::string value;
  friend bool operator==(const WorkerId&, const WorkerId&) = default;
  friend auto operator<=>(const WorkerId&, const WorkerId&) = default;
};

}  // namespace cohort

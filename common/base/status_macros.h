#pragma once

#include <utility>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

/// Returns from the enclosing function when `expression` is a status that is not OK.
#define COHORT_RETURN_IF_ERROR(expression)                                \
  do {                                                                    \
    if (absl::Status cohort_status = (expression); !cohort_status.ok()) { \
      return cohort_status;                                               \
    }                                                                     \
  } while (false)

/// Assigns the value of a StatusOr to `target` (a declaration or a variable), or returns its error.
/// Expands to several statements: never the body of an `if` without braces.
#define COHORT_ASSIGN_OR_RETURN(target, expression) \
  COHORT_ASSIGN_OR_RETURN_IMPL_(COHORT_CONCAT_(cohort_result_, __COUNTER__), target, expression)

#define COHORT_CONCAT_IMPL_(a, b) a##b
#define COHORT_CONCAT_(a, b) COHORT_CONCAT_IMPL_(a, b)
#define COHORT_ASSIGN_OR_RETURN_IMPL_(result, target, expression) \
  auto result = (expression);                                     \
  if (!result.ok()) {                                             \
    return std::move(result).status();                            \
  }                                                               \
  target = *std::move(result)

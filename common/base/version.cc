#include "common/base/version.h"

namespace cohort {

std::string_view BuildVersion() {
  return COHORT_VERSION;
}

}  // namespace cohort

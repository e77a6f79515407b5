#pragma once

namespace cohort {

/// The program cohort: `cohort <command> ...`.
/// @return an exit code of client/output/exit_codes.h.
int ClientMain(int argc, char** argv);

}  // namespace cohort

#pragma once

namespace cohort {

/// The program cohort-server: parses the command line, serves until SIGINT or SIGTERM.
/// @return exit code: 0 stopped as asked, 1 failed, 2 wrong usage.
int ServerMain(int argc, char** argv);

}  // namespace cohort

#pragma once

#include <atomic>

namespace cohort {

/// Makes SIGINT and SIGTERM wait for WaitForStopSignal instead of ending the process, in this
/// thread and those that it starts later; ignores SIGPIPE. Call first thing in main.
void BlockStopSignals();

/// Waits for SIGINT or SIGTERM. Also returns when `*stop` becomes true or, if `parent` is not 0,
/// the parent process is no longer `parent` (looked at four times a second).
/// @return the signal, or 0.
int WaitForStopSignal(const std::atomic<bool>* stop, int parent);

}  // namespace cohort

#include "common/base/process.h"

#include <csignal>
#include <ctime>

#include <unistd.h>

namespace cohort {
namespace {

sigset_t StopSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  return signals;
}

}  // namespace

void BlockStopSignals() {
  const sigset_t signals = StopSignals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

int WaitForStopSignal(const std::atomic<bool>* stop, int parent) {
  const sigset_t signals = StopSignals();
  constexpr timespec kStep = {.tv_sec = 0, .tv_nsec = 250'000'000};
  while (true) {
    const int signal = sigtimedwait(&signals, nullptr, &kStep);
    if (signal > 0) {
      return signal;
    }
    if ((stop != nullptr && *stop) || (parent != 0 && getppid() != parent)) {
      return 0;
    }
  }
}

}  // namespace cohort

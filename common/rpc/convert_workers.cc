// Workers and what they hold.
#include "common/rpc/convert.h"

namespace cohort {

v1::HeldTask ToProto(const HeldTask& held) {
  v1::HeldTask wire;
  *wire.mutable_lease() = ToProto(held.lease);
  wire.set_ticks(held.ticks);
  return wire;
}

HeldTask FromProto(const v1::HeldTask& wire) {
  return {.lease = FromProto(wire.lease()), .ticks = wire.ticks()};
}

v1::Worker ToProto(const WorkerStatus& status) {
  v1::Worker wire;
  wire.set_name(status.worker.value);
  wire.set_instruction_set(status.instruction_set);
  wire.set_slots(status.slots);
  wire.set_draining(status.is_draining);
  wire.set_silent_seconds(status.silent_seconds);
  wire.set_first_seen_unix_ms(status.first_seen_unix_ms);
  wire.set_tasks_done(status.tasks_done);
  wire.set_tasks_failed(status.tasks_failed);
  wire.set_busy_seconds(status.busy_seconds);
  for (const RunningTask& running : status.running) {
    v1::RunningTask* added = wire.add_running();
    *added->mutable_held() = ToProto(running.held);
    added->set_stage(running.stage);
    added->set_seconds(running.seconds);
  }
  return wire;
}

WorkerStatus FromProto(const v1::Worker& wire) {
  WorkerStatus status;
  status.worker = WorkerId{wire.name()};
  status.instruction_set = wire.instruction_set();
  status.slots = wire.slots();
  status.is_draining = wire.draining();
  status.silent_seconds = wire.silent_seconds();
  status.first_seen_unix_ms = wire.first_seen_unix_ms();
  status.tasks_done = wire.tasks_done();
  status.tasks_failed = wire.tasks_failed();
  status.busy_seconds = wire.busy_seconds();
  for (const v1::RunningTask& running : wire.running()) {
    status.running.push_back({.held = FromProto(running.held()),
                              .stage = running.stage(),
                              .seconds = running.seconds()});
  }
  return status;
}

}  // namespace cohort

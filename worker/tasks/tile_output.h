#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status_macros.h"
#include "common/jobs/blobs.h"
#include "common/jobs/field_blob.h"
#include "common/jobs/task.h"
#include "common/pairs/pair_meter.h"
#include "worker/tasks/task_context.h"

namespace cohort {

/// Metrics and fields of one block of pairs, filled pair by pair.
struct MeasuredBlock {
  MetricBlock metrics;
  FieldBlock fields;

  MeasuredBlock(const std::vector<int32_t>& sources, const std::vector<int32_t>& targets)
      : metrics{.sources = sources, .targets = targets, .values = {}},
        fields{.sources = sources, .targets = targets, .fields = {}} {
    metrics.values.resize(sources.size() * targets.size());
    fields.fields.resize(metrics.values.size());
  }
  void Set(size_t place, MeasuredPair pair) {
    metrics.values[place] = pair.metrics;
    fields.fields[place] = std::move(pair.field);
  }
};

/// What a tile writes.
class TileOutput {
 public:
  explicit TileOutput(Retention retention) { fields_.retention = retention; }

  void Add(MeasuredBlock block) {
    metrics_.push_back(std::move(block.metrics));
    if (fields_.retention != Retention::kMetrics) {
      fields_.blocks.push_back(std::move(block.fields));
    }
  }
  /// Ends the computing of the task.
  absl::Status Write(const TaskContext& context, TaskResult& result) const {
    const std::string metrics = EncodeTileBlob(metrics_);
    const std::string fields = fields_.blocks.empty() ? std::string() : EncodeFieldBlob(fields_);
    const std::array<TaskBlob, 2> written = {{{metrics, result.output}, {fields, result.fields}}};
    return WriteBlobs(context, written);
  }

 private:
  std::vector<MetricBlock> metrics_;
  FieldBlob fields_;
};

}  // namespace cohort

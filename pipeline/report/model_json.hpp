/// One motion model as the page's data.
#pragma once

#include "report/json.hpp"
#include "report/report.hpp"

namespace vrda {

/// Everything the page shows of one model. With `is_whole` false only what a comparison of several needs:
/// head, numbers, warnings, curves, provenance.
struct ModelJsonOptions {
  bool is_whole = true;
};
Json model_json(const ReportModel& entry, const ModelJsonOptions& options = {});

/// The curves over flexion alone, as the page knows them.
Json curve_json(const ClinicalCurve& curve);

}  // namespace vrda

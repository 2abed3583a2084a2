#include "guide/bench_parts.hpp"

#include "core/error.hpp"
#include "guide/eyes_so_far.hpp"
#include "guide/parts.hpp"
#include "setup/record_text.hpp"

namespace vrda {
namespace {

CalibrationRecords bench_records(const Calibration& calibration)
{
  CalibrationRecords records;
  for (const auto& [part, record] : calibration.records) {
    if (is_once_a_bench(part)) records[part] = record;
  }
  return records;
}

}  // namespace

Calibration begun_from(const Calibration& other, const BenchFile& bench, const std::string& other_path)
{
  for (const CalibrationPart part : parts_of_step("bench", bench)) {
    if (is_done(other, part)) continue;
    throw InputError({other_path, std::string("per_bench.") + name_of(part),
                      other.records.contains(part) ? "a part that is to be done again" : "nothing",
                      "all once-per-bench parts done: vrda-player calibrate bench"});
  }
  Calibration begun = nominal_calibration(bench);
  begun.records = bench_records(other);
  // The eyes as those parts found them: the other person's bull's-eyes made them their own.
  begun.eyes = eyes_before(CalibrationPart::eyepoints, bench, begun);
  begun.X_tracker_table = other.X_tracker_table;
  begun.stage_direction_table = other.stage_direction_table;
  return begun;
}

void require_same_bench_parts(const Calibration& begun, const std::string& path, const Calibration& other,
                              const std::string& other_path)
{
  if (records_text(bench_records(begun)) == records_text(bench_records(other))) return;
  throw InputError({path, "per_bench", "once-per-bench parts that are not those of " + other_path,
                    "a file that is not there yet, or one that was begun from " + other_path});
}

}  // namespace vrda

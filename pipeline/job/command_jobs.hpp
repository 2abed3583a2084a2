/// Tables of a job for single commands: [fit] and [laxity].
#pragma once

#include <optional>

#include "job/job.hpp"

namespace vrda::job {

/// [fit]: what `vrda fit --to` may change. Absent if the job has none. Throws InputError naming the key: one
/// that the quantity does not have or lacks, angles that do not ascend, no coordinate to fit.
std::optional<FitJob> fit_of(const core::Document& document);

/// [laxity]: the loads of `vrda laxity`. Absent if the job has none. Throws InputError naming the key: angles
/// that do not ascend, no load.
std::optional<LaxityJob> laxity_of(const core::Document& document);

/// The job over these flexions (degrees, ascending) with varus free and nothing smoothed, whatever its grid.
/// Its texts are those of the given job. Throws InputError naming the key unless the method is the
/// equilibrium, Delta is +Y and turns with the moving object, and the job has a grid.
Job over_flexions(const Job& job, const std::vector<double>& flexion_deg);

// The loads of a job, [push]: parsing, and their values at one flexion.

/// Throws InputError naming the key: a zero direction, load or tension, a name twice, a list of another
/// length than its flexions, a line whose objects' points coincide.
PushJob push_of(const core::Document& document);

/// All settings that may have columns, with the least value that each may have (NaN: any).
struct PushTable {
  FlexionTable* table = nullptr;
  double least = 0.0;
  bool excludes_least = false;
};
std::vector<PushTable> tables_of(PushJob& push);

/// The loads at a flexion and, of a sequence, at a frame; `delta` is the unit direction there. The lateral
/// force acts across Delta, along X and Z rotated by the shortest rotation from +Y to Delta.
Push push_at(const PushJob& job, const Eigen::Vector3d& delta, double flexion_rad, std::size_t frame = 0);

}  // namespace vrda::job

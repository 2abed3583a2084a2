/// The loads of a job, [push]: parsing, and their values at one flexion.
#pragma once

#include "job/job.hpp"

namespace vrda::job {

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

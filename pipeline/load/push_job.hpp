/// The loads of a job, [push]: parsing, and their values at one flexion.
#pragma once

#include "load/job.hpp"

namespace vrda::load {

/// Throws InputError naming the key: a zero direction, load or tension, a name twice, a list of another
/// length than its flexions, a line whose objects' points coincide.
PushJob push_of(const documents::Document& document);

/// The loads at a flexion; `delta` is the unit direction there. The lateral force acts across Delta, along X
/// and Z rotated by the shortest rotation from +Y to Delta.
Push push_at(const PushJob& job, const Eigen::Vector3d& delta, double flexion_rad);

}  // namespace vrda::load

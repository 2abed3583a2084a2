/// Inputs of the benchmarks: a joint, the motion steps of a coarse sweep, and poses typical of a search.
#pragma once

#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "job/case.hpp"
#include "solve/sweep.hpp"

namespace vrda::benchmarks {

struct Step {
  Attitude attitude;
  MovingPose seed;
  MovingPose solved;
};

struct Scene {
  job::Case job_case;
  solve::Joint joint;
  std::vector<Step> steps;  ///< solved ones, 7 x 3 attitudes
};

/// "generic" or "jam-smith2019". Loaded and swept once, then cached.
const Scene& scene(const std::string& knee);

/// jobs/knee-NAME.toml with the given settings ("key.path=value"); meshes from $VRDA_DATA.
job::Case case_of(const std::string& knee, const std::vector<std::string>& settings = {});

/// Whether the real knees are available ($VRDA_DATA or ../shared/data).
bool has_real_knees();

/// Near misses: the solved pose moved back by up to 0.2 mm along Delta and rotated by up to half a degree,
/// as in a search. Fixed random numbers.
std::vector<MovingPose> near_misses(const Step& step);

/// Registers `run(state, knee)` as room/what/knee for each available knee.
void for_each_knee(const std::string& room_and_what, void (*run)(benchmark::State&, const std::string&));

}  // namespace vrda::benchmarks

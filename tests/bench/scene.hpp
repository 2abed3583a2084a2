/// What the benchmarks work on: a joint, the motion steps of a coarse sweep, and poses a search would ask
/// about.
#pragma once

#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "load/case.hpp"
#include "solve/joint.hpp"

namespace vrda::bench {

struct Step {
  Attitude attitude;
  MovingPose seed;
  MovingPose solved;
};

struct Scene {
  Case job_case;
  Joint joint;
  std::vector<Step> steps;  ///< solved ones, 7 x 3 attitudes
};

/// "generic" or "jam-smith2019". Loaded and swept once, then kept.
const Scene& scene(const std::string& knee);

/// jobs/knee-NAME.toml with the settings given ("key.path=value"); meshes from $VRDA_DATA.
Case case_of(const std::string& knee, const std::vector<std::string>& settings = {});

/// Whether the real knees are there ($VRDA_DATA or ../shared/data).
bool has_real_knees();

/// Near misses: the solved pose moved back by up to 0.2 mm along Delta and turned by up to half a degree, as
/// a search asks. Fixed numbers.
std::vector<MovingPose> near_misses(const Step& step);

/// Registers `run(state, knee)` as room/what/knee for each knee at hand.
void for_each_knee(const std::string& room_and_what, void (*run)(benchmark::State&, const std::string&));

}  // namespace vrda::bench

/// The scenes of thesis chapter 4 as cases of property tests: random parameters, one search, outcomes.
#pragma once

#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "geometry/shapes.hpp"
#include "solve/stability_search.hpp"

namespace vrda::test {

/// Seeded random numbers, identical on every platform: only the generator's bits are used.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : bits_(seed) {}
  double uniform(double from, double to);
  /// Uniform in the logarithm; both ends must be positive.
  double log_uniform(double from, double to);
  int whole(int from, int to);  ///< both ends included
  double sign();                ///< -1 or 1

 private:
  std::mt19937_64 bits_;
};

/// Both objects of a scene in the solver frame.
struct Scene {
  Mesh reference;
  Mesh moving;
};

Scene scene_of(const geometry::ShapeRequest& request);

struct Solved {
  StepRecord record;
  std::map<MoveKind, int> moves;
};

Solved solve(const Scene& scene, const SearchOptions& options, const MovingPose& seed = {});

/// Final position of a point of the moving object, mm.
Eigen::Vector3d placed(const Solved& solved, const Eigen::Vector3d& p_moving_mm);

/// Of `n` cases of a property all with VRDA_VALIDATION set, otherwise the first quarter.
int n_tested(int n);

/// Statistics of a tested property: printed, kept in CTest's log, and appended as a JSON line to the folder
/// $VRDA_VALIDATION if set (scripts/validation makes results/validation.md from them).
struct Tally {
  std::string scene{};    ///< as in the table: "ball in a dish, bowl"
  std::string claim{};    ///< property that must hold
  std::string measure{};  ///< meaning and unit of `worst`: "distance from the middle, resolutions"
  std::uint64_t seed = 0;
  double allowed = 0.0;  ///< upper limit of the measure
  int cases = 0;
  int failures = 0;
  double worst = 0.0;
  std::map<std::string, int> outcomes{};  ///< number of cases by outcome

  /// Counts a case; it fails if `measured` is above `allowed` or NaN.
  bool add(double measured);
};

/// Prints and writes the tally; fails the test if a case failed.
void report(const Tally& tally);

}  // namespace vrda::test

/// The scenes of thesis chapter 4 as cases of a property test: drawn parameters, one search, what came out.
#pragma once

#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "shapes/shapes.hpp"
#include "solve/stability_search.hpp"

namespace vrda::test {

/// Random numbers of one seed. The same draws everywhere: only the generator's bits are used.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : bits_(seed) {}
  double uniform(double from, double to);
  /// Even over the logarithm; both ends above zero.
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

Scene scene_of(const ShapeRequest& request);

struct Solved {
  StepRecord record;
  std::map<MoveKind, int> moves;
};

Solved solve(const Scene& scene, const SearchOptions& options, const MovingPose& seed = {});

/// Where a point of the moving object stands in the end, mm.
Eigen::Vector3d placed(const Solved& solved, const Eigen::Vector3d& p_moving_mm);

/// What a property was held against: printed, kept in CTest's log, and written as one line of JSON to the
/// folder $VRDA_VALIDATION when it is set (scripts/validation makes results/validation.md of these).
struct Tally {
  std::string scene{};    ///< as in the table: "ball in a dish, bowl"
  std::string claim{};    ///< what must hold
  std::string measure{};  ///< what `worst` is, with its unit: "distance from the middle, resolutions"
  std::uint64_t seed = 0;
  double allowed = 0.0;  ///< of the measure
  int cases = 0;
  int failures = 0;
  double worst = 0.0;
  std::map<std::string, int> outcomes{};  ///< how often each was met

  /// Counts a case; it fails when `measured` is above `allowed` or no number.
  bool add(double measured);
};

/// Prints and writes the tally, and fails the test when a case failed.
void report(const Tally& tally);

}  // namespace vrda::test

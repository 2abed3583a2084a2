/// A motion step solved by Bullet's rigid-body dynamics, as a general-purpose simulator would.
#pragma once

#include <memory>

#include "model/frames.hpp"

namespace vrda::benchmarks {

/// The body moves along Delta at 0.1 m/s at most, less than half a millimetre per step, since GImpact's
/// surfaces have no interior: after tunnelling a body does not return.
struct SettleOptions {
  double force_n = 20.0;  ///< along Delta
  double mass_kg = 14.5;
  double velocity_left = 1e-6;  ///< fraction of a velocity that remains after a second of damping
  double radius_of_inertia_mm = 30.0;
  double margin_mm = 0.05;  ///< of each surface: half the resolution, so that contact is within it
  double step_s = 1.0 / 240.0;
  int solver_iterations = 50;
  double window_s = 0.25;  ///< at rest if nothing moved by more than both resolutions within it
  double resolution_mm = 0.1;
  double resolution_rad = 0.1 * 3.14159265358979323846 / 180.0;
  double limit_s = 20.0;
};

struct Settled {
  MovingPose pose;
  double simulated_s = 0.0;
  bool is_at_rest = false;  ///< false: ended by the limit
};

/// GImpact shapes of both objects, S at zero attitude, in cm: Bullet is designed for sizes around 1.
class RigidPair {
 public:
  RigidPair(const Mesh& reference, const Mesh& moving, const SettleOptions& options);
  ~RigidPair();
  RigidPair(const RigidPair&) = delete;
  RigidPair& operator=(const RigidPair&) = delete;

  /// The reference is fixed; the moving object translates freely and rotates about Delta only, without
  /// friction.
  Settled settle(const Attitude& attitude, const MovingPose& start) const;

 private:
  struct Shapes;
  std::unique_ptr<Shapes> shapes_;
  SettleOptions options_;
};

}  // namespace vrda::benchmarks

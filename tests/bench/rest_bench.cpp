// One motion step of the generic knee from the same start, by rigid-body dynamics and by the equilibrium.
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <benchmark/benchmark.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <memory>

#include "core/text.hpp"
#include "processor_time.hpp"
#include "scene.hpp"
#include "solve/case_solver.hpp"

namespace vrda::benchmarks {
namespace {

// A motion step solved by Bullet's rigid-body dynamics, as a general-purpose simulator would.

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

constexpr double mm_a_unit = 10.0;  // cm
constexpr double units_a_m = 100.0;

btVector3 to_bullet(const Eigen::Vector3d& p_mm)
{
  return {p_mm.x() / mm_a_unit, p_mm.y() / mm_a_unit, p_mm.z() / mm_a_unit};
}

btTransform to_bullet(const Eigen::Matrix3d& R, const Eigen::Vector3d& p_mm)
{
  const btMatrix3x3 basis(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2));
  return btTransform(basis, to_bullet(p_mm));
}

MovingPose from_bullet(const btTransform& X)
{
  const btVector3& p = X.getOrigin();
  const btMatrix3x3& R = X.getBasis();
  return {mm_a_unit * Eigen::Vector3d(p.x(), p.y(), p.z()), std::atan2(R[0][2], R[0][0])};
}

// A mesh and its shape.
struct Surface {
  Surface(const Mesh& mesh, double margin_mm)
  {
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
      const auto [a, b, c] = corners(mesh, t);
      triangles.addTriangle(to_bullet(a), to_bullet(b), to_bullet(c));
    }
    shape = std::make_unique<btGImpactMeshShape>(&triangles);
    shape->setMargin(margin_mm / mm_a_unit);
    shape->updateBound();
  }

  btTriangleMesh triangles;
  std::unique_ptr<btGImpactMeshShape> shape;
};

// Bullet requires destruction in reverse order of construction.
struct World {
  explicit World(int solver_iterations)
  {
    btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
    dynamics.setGravity({0.0, 0.0, 0.0});
    dynamics.getSolverInfo().m_numIterations = solver_iterations;
  }

  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld dynamics{&dispatcher, &broadphase, &solver, &configuration};
};

void make_bare(btRigidBody& body)
{
  body.setFriction(0.0);
  body.setRollingFriction(0.0);
  body.setRestitution(0.0);
}

bool is_still(const MovingPose& a, const MovingPose& b, const SettleOptions& options)
{
  return (a.translation_mm - b.translation_mm).norm() < options.resolution_mm &&
         std::abs(a.theta_rad - b.theta_rad) < options.resolution_rad;
}

struct RigidPair::Shapes {
  Surface reference;
  Surface moving;
};

RigidPair::RigidPair(const Mesh& reference, const Mesh& moving, const SettleOptions& options)
    : shapes_(new Shapes{{reference, options.margin_mm}, {moving, options.margin_mm}}), options_(options)
{
}

RigidPair::~RigidPair() = default;

Settled RigidPair::settle(const Attitude& attitude, const MovingPose& start) const
{
  World world(options_.solver_iterations);
  btRigidBody fixed(0.0, nullptr, shapes_->reference.shape.get());
  fixed.setWorldTransform(to_bullet(reference_rotation(attitude), Eigen::Vector3d::Zero()));
  const double radius = options_.radius_of_inertia_mm / mm_a_unit;
  const double inertia = options_.mass_kg * radius * radius;
  btRigidBody body(options_.mass_kg, nullptr, shapes_->moving.shape.get(), {inertia, inertia, inertia});
  body.setCenterOfMassTransform(to_bullet(rotation_y(start.theta_rad), start.translation_mm));
  body.setLinearFactor({1.0, 1.0, 1.0});
  body.setAngularFactor({0.0, 1.0, 0.0});
  body.setDamping(1.0 - options_.velocity_left, 1.0 - options_.velocity_left);
  body.setActivationState(DISABLE_DEACTIVATION);
  make_bare(fixed);
  make_bare(body);
  world.dynamics.addRigidBody(&fixed);
  world.dynamics.addRigidBody(&body);

  Settled settled{start, 0.0, false};
  const int steps_a_window = static_cast<int>(std::lround(options_.window_s / options_.step_s));
  while (!settled.is_at_rest && settled.simulated_s < options_.limit_s) {
    for (int k = 0; k < steps_a_window; ++k) {
      body.applyCentralForce({0.0, options_.force_n * units_a_m, 0.0});
      world.dynamics.stepSimulation(options_.step_s, 0);
    }
    settled.simulated_s += steps_a_window * options_.step_s;
    const MovingPose now = from_bullet(body.getCenterOfMassTransform());
    settled.is_at_rest = is_still(now, settled.pose, options_);
    settled.pose = now;
  }
  world.dynamics.removeRigidBody(&body);
  world.dynamics.removeRigidBody(&fixed);
  return settled;
}

constexpr double start_below_mm = 2.0;
constexpr double neighbour_deg = 5.0;  // difference in flexion of the start's attitude
constexpr int n_solved = 20;           // repetitions of the equilibrium for timing

struct Knee {
  job::Case job_case = case_of("generic", {"solver.method=equilibrium"});
  solve::Joint joint = solve::joint_of(job_case, job_case.frame);
  solve::EquilibriumSolver solver{joint, job_case.ligaments, job_case.equilibrium};
  geometry::GapQuery gap{joint.reference_gap, joint.moving_gap};
  RigidPair bodies{joint.reference.tree_mesh.mesh, joint.moving.tree_mesh.mesh, {}};
};

Knee& knee()
{
  static Knee made;
  return made;
}

double travel_left_mm(const Attitude& attitude, const MovingPose& pose)
{
  knee().gap.set_attitude(attitude);
  return knee().gap.travel_mm(pose);
}

StepRecord rest_at(const Attitude& attitude, const MovingPose& seed)
{
  return knee().solver.solve(
      {attitude, seed, solve::loads_of(knee().job_case, knee().job_case.push.front()), false});
}

// Pose of a neighbour's equilibrium, slightly below first contact.
MovingPose start_of(const Attitude& attitude)
{
  Attitude neighbour = attitude;
  neighbour.flexion_rad += rad_from_deg(attitude.flexion_rad > 0.0 ? -neighbour_deg : neighbour_deg);
  MovingPose start = rest_at(neighbour, solve::plan_of(knee().job_case).initial).pose;
  const double travel_mm = travel_left_mm(attitude, start);
  check(std::isfinite(travel_mm), "the neighbour's pose must face the reference");
  start.translation_mm.y() += travel_mm - start_below_mm;
  return start;
}

void settle(benchmark::State& state, const Attitude& attitude)
{
  const MovingPose start = start_of(attitude);
  for (auto _ : state) {
    const double before_s = thread_s();
    const Settled settled = knee().bodies.settle(attitude, start);
    const double between_s = thread_s();
    StepRecord rest;
    for (int k = 0; k < n_solved; ++k) rest = rest_at(attitude, start);
    check(rest.status == StepStatus::stable,
          "the generic knee must have an equilibrium at each of these attitudes");
    const double settled_s = between_s - before_s, solved_s = (thread_s() - between_s) / n_solved;
    const Eigen::Vector3d off_mm = settled.pose.translation_mm - rest.pose.translation_mm;
    state.SetIterationTime(settled_s);
    state.counters["times the equilibrium"] = settled_s / solved_s;
    state.counters["simulated s"] = settled.simulated_s;
    state.counters["converged"] = settled.is_at_rest ? 1.0 : 0.0;
    state.counters["travel deficit along Delta, mm"] = -off_mm.y();
    state.counters["mm across"] = std::hypot(off_mm.x(), off_mm.z());
    state.counters["degrees"] = std::abs(deg_from_rad(settled.pose.theta_rad - rest.pose.theta_rad));
    state.counters["remaining travel, mm"] = travel_left_mm(attitude, settled.pose);
    state.counters["theta determined"] = rest.theta_determined ? 1.0 : 0.0;
  }
}

[[maybe_unused]] const bool registered = [] {
  struct Row {
    int flexion_deg, varus_deg;
  };
  for (const Row& row : {Row{0, 0}, Row{30, 0}, Row{60, 0}, Row{90, 0}, Row{30, -3}, Row{30, 3}}) {
    const std::string name = "rest/rigid_body_by_Bullet/flexion " + std::to_string(row.flexion_deg) +
                             " varus " + std::to_string(row.varus_deg);
    const Attitude attitude{rad_from_deg(row.flexion_deg), rad_from_deg(row.varus_deg)};
    benchmark::RegisterBenchmark(name.c_str(),
                                 [attitude](benchmark::State& state) { settle(state, attitude); })
        ->UseManualTime()
        ->Iterations(1);
  }
  return true;
}();

}  // namespace
}  // namespace vrda::benchmarks

#include "rigid_body.hpp"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>

namespace vrda::benchmarks {
namespace {

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

}  // namespace

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

}  // namespace vrda::benchmarks

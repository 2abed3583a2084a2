#include "analysis/noisy_joint.hpp"

#include <cmath>

#include "store/motion.hpp"

namespace vrda::test {
namespace {

/// Adds Legendre terms up to the joint's degree and noise to `surface`, which is 0.
void fill(store::GridD& surface, const NoisyJoint& joint, const store::MotionModel& model,
          NormalNumbers& numbers)
{
  const store::AxisRanges ranges = store::axis_ranges(model.flexion_deg, model.varus_deg);
  const double n_cells = static_cast<double>(surface.size());
  const double spread = joint.noise_mm > 0.0 ? joint.noise_mm : 0.01;
  const auto table = [&](const std::vector<double>& axis, Eigen::Index k, const store::AxisRange& range) {
    return store::legendre(store::unit_coordinate(axis[static_cast<std::size_t>(k)], range), joint.degree);
  };
  for (int p = 0; p <= joint.degree; ++p) {
    for (int q = 0; p + q <= joint.degree; ++q) {
      // Mean square of P_p P_q over the grid, nearly, is 1 / (2p + 1)(2q + 1).
      const double standard_error = spread * std::sqrt((2 * p + 1) * (2 * q + 1) / n_cells);
      const double sign = numbers.next_uniform() < 0.0 ? -1.0 : 1.0;
      const double coefficient = p + q == joint.degree
                                     ? sign * joint.significance * standard_error
                                     : joint.lower_mm / (1 + p * p) * numbers.next_uniform();
      for (Eigen::Index i = 0; i < surface.rows(); ++i) {
        for (Eigen::Index j = 0; j < surface.cols(); ++j) {
          surface(i, j) += coefficient * table(model.flexion_deg, i, ranges.flexion).value[p] *
                           table(model.varus_deg, j, ranges.varus).value[q];
        }
      }
    }
  }
  for (Eigen::Index k = 0; k < surface.size(); ++k) surface.data()[k] += joint.noise_mm * numbers.next();
}

}  // namespace

double NormalNumbers::next_uniform()
{
  return static_cast<double>(generator_() >> 11) * 0x1p-52 - 1.0;
}

double NormalNumbers::next()
{
  while (true) {
    const double x = next_uniform(), y = next_uniform(), square = x * x + y * y;
    if (square > 0.0 && square < 1.0) return x * std::sqrt(-2.0 * std::log(square) / square);
  }
}

store::MotionModel noisy_model(const NoisyJoint& joint)
{
  store::MotionModel model;
  for (int i = 0; i < joint.n_flexion; ++i) model.flexion_deg.push_back(3.0 * i);
  for (int j = 0; j < joint.n_varus; ++j) model.varus_deg.push_back(j - 0.5 * (joint.n_varus - 1));
  NormalNumbers numbers(joint.seed);
  for (store::GridD* surface : {&model.tx_mm, &model.ty_mm, &model.tz_mm, &model.theta_deg}) {
    *surface = store::GridD::Zero(joint.n_flexion, joint.n_varus);
    fill(*surface, joint, model, numbers);
  }
  model.status = store::GridB::Zero(joint.n_flexion, joint.n_varus);
  model.theta_determined = store::GridB::Ones(joint.n_flexion, joint.n_varus);
  model.varus_solved_deg = store::GridD::Zero(joint.n_flexion, joint.n_varus);
  for (int i = 0; i < joint.n_flexion; ++i) {
    for (int j = 0; j < joint.n_varus; ++j)
      model.varus_solved_deg(i, j) = model.varus_deg[static_cast<std::size_t>(j)];
  }
  model.push = store::constant_push(Eigen::Vector3d::UnitY(), model.flexion_deg.size());
  return model;
}

}  // namespace vrda::test

// The minimum of a quadratic function in a box, by NLopt (SLSQP).
#include "solve/quadratic_program.hpp"

#include <nlopt.h>

#include "core/error.hpp"

namespace vrda::solve {
namespace {

struct Quadratic {
  const Eigen::MatrixXd& H;
  const Eigen::VectorXd& g;
};

double quadratic_value(unsigned n, const double* x, double* gradient, void* data)
{
  const auto& q = *static_cast<const Quadratic*>(data);
  const Eigen::Map<const Eigen::VectorXd> at(x, static_cast<Eigen::Index>(n));
  const Eigen::VectorXd Hx = q.H * at;
  if (gradient != nullptr) Eigen::Map<Eigen::VectorXd>(gradient, static_cast<Eigen::Index>(n)) = Hx + q.g;
  return 0.5 * at.dot(Hx) + q.g.dot(at);
}

}  // namespace

Eigen::VectorXd minimum_in_box(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, const Eigen::VectorXd& low,
                               const Eigen::VectorXd& high)
{
  const Eigen::Index n = g.size();
  check(n > 0 && H.rows() == n && low.size() == n && high.size() == n, "minimum_in_box: lengths");
  Quadratic quadratic{H, g};
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  const nlopt_opt opt = nlopt_create(NLOPT_LD_SLSQP, static_cast<unsigned>(n));
  check(opt != nullptr, "nlopt_create failed");
  nlopt_set_min_objective(opt, quadratic_value, &quadratic);
  nlopt_set_lower_bounds(opt, low.data());
  nlopt_set_upper_bounds(opt, high.data());
  nlopt_set_xtol_abs1(opt, 1e-9);
  nlopt_set_maxeval(opt, 1000);
  double value = 0.0;
  // Its result stays in x where it stops by rounding.
  nlopt_optimize(opt, x.data(), &value);
  nlopt_destroy(opt);
  return x;
}

}  // namespace vrda::solve

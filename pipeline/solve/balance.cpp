#include "solve/balance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vrda {

Held held_by(const Potential& potential, const std::vector<Clearance>& touching, const Grip& grip,
             const std::array<bool, 5>& is_free)
{
  Vector5d s;
  s << 1.0, 1.0, 1.0, 1.0 / grip.lever_mm, 1.0 / grip.lever_mm;
  for (std::size_t k = 0; k < is_free.size(); ++k) s(static_cast<Eigen::Index>(k)) *= is_free[k] ? 1.0 : 0.0;
  std::vector<HalfSpace> rows;
  std::vector<double> length;
  for (const Clearance& c : touching) {
    const QpVector normal = s.cwiseProduct(c.gradient);
    length.push_back(std::max(normal.norm(), std::numeric_limits<double>::min()));
    rows.push_back({normal / length.back(), 0.0});
  }
  const QpSolution qp =
      solve_quadratic_program(QpMatrix::Identity(), s.cwiseProduct(potential.gradient), rows);
  Held held;
  held.unbalanced_n = qp.d;
  held.residual_n = qp.d.norm();
  for (std::size_t k = 0; k < qp.n_support; ++k) {
    const QpSolution::Support& one = qp.support[k];
    if (one.multiplier > 0.0) held.bearing.push_back({one.row, one.multiplier / length[one.row]});
  }
  std::sort(held.bearing.begin(), held.bearing.end(),
            [](const Held::Bearing& a, const Held::Bearing& b) { return a.row < b.row; });
  return held;
}

}  // namespace vrda

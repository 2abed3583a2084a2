#include "analysis/sequence_program.hpp"

#include <algorithm>
#include <cmath>

#include "analysis/band_matrix.hpp"

namespace vrda::analysis {
namespace {

// Penalty on the squared excess. H is at least 1 for a frame alone; with smoothing, the compliance of a frame
// is some hundredths: the excess falls by a factor of 100 or more with each update of the multipliers.
constexpr double penalty = 1e4;
constexpr int most_updates = 12, most_newton_steps = 30, most_halvings = 12;
constexpr double tolerance = 1e-6;
// Shorter rows move with no unknown.
constexpr double shortest_normal = 1e-9;

struct Row {
  Eigen::Index frame = 0;
  Vector6d normal;  // unit
  double offset = 0.0, multiplier = 0.0;
};

Vector6d part(const std::vector<double>& x, Eigen::Index frame)
{
  return Eigen::Map<const Vector6d>(x.data() + 6 * frame);
}

class AugmentedLagrangian {
 public:
  explicit AugmentedLagrangian(const SequenceProgram& program)
      : program_(program), n_(static_cast<Eigen::Index>(program.b.size()))
  {
    for (Eigen::Index k = 0; k < n_; ++k) {
      for (const FrameBound& bound : program.bounds[static_cast<std::size_t>(k)]) {
        const double length = bound.normal.norm();
        if (length > shortest_normal) rows_.push_back({k, bound.normal / length, bound.offset / length, 0.0});
      }
    }
  }

  std::vector<double> run()
  {
    std::vector<double> x = newton_solution(std::vector<bool>(rows_.size(), false));
    for (int update = 0; update < most_updates; ++update) {
      x = minimised(std::move(x));
      double worst = 0.0;
      for (Row& row : rows_) {
        worst = std::max(worst, row.multiplier > 0.0 ? std::abs(excess(row, x)) : excess(row, x));
        row.multiplier = std::max(0.0, force(row, x));
      }
      if (worst <= tolerance) break;
    }
    return x;
  }

 private:
  static double excess(const Row& row, const std::vector<double>& x)
  {
    return row.offset - row.normal.dot(part(x, row.frame));
  }
  static double force(const Row& row, const std::vector<double>& x)
  {
    return row.multiplier + penalty * excess(row, x);
  }

  std::vector<bool> active(const std::vector<double>& x) const
  {
    std::vector<bool> out(rows_.size());
    for (std::size_t i = 0; i < rows_.size(); ++i) out[i] = force(rows_[i], x) > 0.0;
    return out;
  }

  double value(const std::vector<double>& x) const
  {
    double sum = 0.0;
    for (Eigen::Index k = 0; k < n_; ++k) {
      const std::array<Matrix6d, 3>& row = program_.H[static_cast<std::size_t>(k)];
      const Vector6d xk = part(x, k);
      sum += 0.5 * xk.dot(row[0] * xk) - program_.b[static_cast<std::size_t>(k)].dot(xk);
      for (Eigen::Index d = 1; d <= std::min<Eigen::Index>(2, k); ++d)
        sum += xk.dot(row[static_cast<std::size_t>(d)] * part(x, k - d));
    }
    for (const Row& row : rows_) {
      const double pull = std::max(0.0, force(row, x));
      sum += 0.5 * pull * pull / penalty;
    }
    return sum;
  }

  // The minimum of the quadratic function with these rows as springs.
  std::vector<double> newton_solution(const std::vector<bool>& is_active) const
  {
    BandMatrix matrix(6 * n_, 17);
    std::vector<double> b(static_cast<std::size_t>(6 * n_));
    for (Eigen::Index k = 0; k < n_; ++k) {
      for (Eigen::Index d = 0; d <= std::min<Eigen::Index>(2, k); ++d) {
        const Matrix6d& block = program_.H[static_cast<std::size_t>(k)][static_cast<std::size_t>(d)];
        for (Eigen::Index i = 0; i < 6; ++i) {
          for (Eigen::Index j = 0; j < (d == 0 ? i + 1 : 6); ++j)
            matrix.at(6 * k + i, 6 * (k - d) + j) = block(i, j);
        }
      }
      for (Eigen::Index i = 0; i < 6; ++i)
        b[static_cast<std::size_t>(6 * k + i)] = program_.b[static_cast<std::size_t>(k)](i);
    }
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      if (!is_active[r]) continue;
      const Row& row = rows_[r];
      const double pull = row.multiplier + penalty * row.offset;
      for (Eigen::Index i = 0; i < 6; ++i) {
        b[static_cast<std::size_t>(6 * row.frame + i)] += pull * row.normal(i);
        for (Eigen::Index j = 0; j <= i; ++j)
          matrix.at(6 * row.frame + i, 6 * row.frame + j) += penalty * row.normal(i) * row.normal(j);
      }
    }
    matrix.factorise();
    return matrix.solve(std::move(b));
  }

  // Newton steps until the active rows remain, which is the exact minimum of the piecewise quadratic
  // function.
  std::vector<double> minimised(std::vector<double> x) const
  {
    double least = value(x);
    std::vector<bool> rows = active(x);
    for (int step = 0; step < most_newton_steps; ++step) {
      const std::vector<double> target = newton_solution(rows);
      std::vector<double> trial = target;
      double share = 1.0, found = value(trial);
      for (int halving = 0; found > least && halving < most_halvings; ++halving) {
        share *= 0.5;
        for (std::size_t i = 0; i < x.size(); ++i) trial[i] = x[i] + share * (target[i] - x[i]);
        found = value(trial);
      }
      if (found > least) break;
      x = std::move(trial);
      least = found;
      const std::vector<bool> now = active(x);
      if (share == 1.0 && now == rows) break;
      rows = now;
    }
    return x;
  }

  const SequenceProgram& program_;
  Eigen::Index n_ = 0;
  std::vector<Row> rows_;
};

}  // namespace

std::vector<Vector6d> minimise(const SequenceProgram& program)
{
  const std::vector<double> x = AugmentedLagrangian(program).run();
  std::vector<Vector6d> out;
  for (std::size_t k = 0; k < program.b.size(); ++k) out.push_back(part(x, static_cast<Eigen::Index>(k)));
  return out;
}

}  // namespace vrda::analysis

#include "solve/quadratic_program.hpp"

#include <nlopt.h>

#include <cmath>
#include <limits>

#include "core/text.hpp"

namespace vrda::solve {
namespace {

// A normal whose component orthogonal to the active ones is below this share depends linearly on them.
constexpr double dependent_share = 1e-11;
// Every change of the active set raises the dual value, so some tens suffice; the limit stops cycles by
// rounding.
constexpr int max_changes = 400;

// L with L L^T = H.
template <int N>
QpMatrixOf<N> cholesky(const QpMatrixOf<N>& H)
{
  QpMatrixOf<N> L = QpMatrixOf<N>::Zero();
  for (Eigen::Index j = 0; j < N; ++j) {
    double pivot = H(j, j);
    for (Eigen::Index k = 0; k < j; ++k) pivot -= L(j, k) * L(j, k);
    check(pivot > 0.0, "quadratic programme: H is not positive definite");
    L(j, j) = std::sqrt(pivot);
    for (Eigen::Index i = j + 1; i < N; ++i) {
      double sum = H(i, j);
      for (Eigen::Index k = 0; k < j; ++k) sum -= L(i, k) * L(j, k);
      L(i, j) = sum / L(j, j);
    }
  }
  return L;
}

// Inverse of L^T.
template <int N>
QpMatrixOf<N> inverse_transposed(const QpMatrixOf<N>& L)
{
  QpMatrixOf<N> J = QpMatrixOf<N>::Zero();  // upper triangular
  for (Eigen::Index j = 0; j < N; ++j) {
    J(j, j) = 1.0 / L(j, j);
    for (Eigen::Index i = j - 1; i >= 0; --i) {
      double sum = 0.0;
      for (Eigen::Index k = i + 1; k <= j; ++k) sum -= L(k, i) * J(k, j);
      J(i, j) = sum / L(i, i);
    }
  }
  return J;
}

template <int N>
class DualMethod {
 public:
  DualMethod(const QpMatrixOf<N>& H, const QpVectorOf<N>& g, const std::vector<HalfSpaceOf<N>>& half_spaces)
      : half_spaces_(half_spaces), J_(inverse_transposed(cholesky(H))), x_(-(J_ * (J_.transpose() * g)))
  {
  }

  QpSolutionOf<N> run()
  {
    QpSolutionOf<N> solution;
    while (n_left_ > 0) {
      const std::size_t worst = most_violated();
      if (worst == half_spaces_.size()) {
        solution.is_solved = true;
        break;
      }
      if (!take(worst)) break;
    }
    solution.d = x_;
    solution.n_active = static_cast<std::size_t>(n_active_);
    for (Eigen::Index k = 0; k < n_active_; ++k)
      solution.active[static_cast<std::size_t>(k)] = {active_[static_cast<std::size_t>(k)], u_(k)};
    return solution;
  }

 private:
  double slack(std::size_t row) const { return half_spaces_[row].normal.dot(x_) - half_spaces_[row].offset; }

  std::size_t most_violated() const
  {
    std::size_t worst = half_spaces_.size();
    double least = -qp_tolerance;
    for (std::size_t row = 0; row < half_spaces_.size(); ++row) {
      const double s = slack(row);
      if (s < least) {
        least = s;
        worst = row;
      }
    }
    return worst;
  }

  // Activates half-space `row`, dropping constraints with a zero multiplier. False if it is infeasible.
  bool take(std::size_t row)
  {
    const QpVectorOf<N> normal = half_spaces_[row].normal;
    double multiplier = 0.0;
    while (n_left_-- > 0) {
      const QpVectorOf<N> d = J_.transpose() * normal;
      const QpVectorOf<N> r = dual_direction(d);
      const double across = d.tail(N - n_active_).squaredNorm();
      const bool is_dependent =
          n_active_ == N || across <= dependent_share * dependent_share * d.squaredNorm();
      const Eigen::Index leaving = first_to_leave(r);
      const double t_dual = leaving < 0 ? std::numeric_limits<double>::infinity() : u_(leaving) / r(leaving);
      const double t_primal =
          is_dependent ? std::numeric_limits<double>::infinity() : std::max(0.0, -slack(row)) / across;
      const double t = std::min(t_dual, t_primal);
      if (!std::isfinite(t)) return false;
      u_.head(n_active_) -= t * r.head(n_active_);
      multiplier += t;
      if (!is_dependent) x_ += t * (J_.rightCols(N - n_active_) * d.tail(N - n_active_));
      if (t_primal <= t_dual) {
        add(row, multiplier, d);
        return true;
      }
      drop(leaving);
    }
    return false;
  }

  // R r = first n_active_ of d.
  QpVectorOf<N> dual_direction(const QpVectorOf<N>& d) const
  {
    QpVectorOf<N> r = QpVectorOf<N>::Zero();
    for (Eigen::Index i = n_active_ - 1; i >= 0; --i) {
      double sum = d(i);
      for (Eigen::Index k = i + 1; k < n_active_; ++k) sum -= R_(i, k) * r(k);
      r(i) = sum / R_(i, i);
    }
    return r;
  }

  Eigen::Index first_to_leave(const QpVectorOf<N>& r) const
  {
    Eigen::Index leaving = -1;
    for (Eigen::Index k = 0; k < n_active_; ++k) {
      if (r(k) > 0.0 && (leaving < 0 || u_(k) / r(k) < u_(leaving) / r(leaving))) leaving = k;
    }
    return leaving;
  }

  void add(std::size_t row, double multiplier, QpVectorOf<N> d)
  {
    for (Eigen::Index k = N - 1; k > n_active_; --k) turn_columns(k - 1, d(k - 1), d(k), d);
    R_.col(n_active_).head(n_active_ + 1) = d.head(n_active_ + 1);
    active_[static_cast<std::size_t>(n_active_)] = row;
    u_(n_active_) = multiplier;
    ++n_active_;
  }

  // Givens rotation of columns k and k + 1 of J that makes entry k + 1 of `d` zero.
  void turn_columns(Eigen::Index k, double a, double b, QpVectorOf<N>& d)
  {
    const double length = std::sqrt(a * a + b * b);
    if (b == 0.0 || length == 0.0) return;
    const double c = a / length, s = b / length;
    d(k) = length;
    d(k + 1) = 0.0;
    rotate(k, c, s);
  }

  void rotate(Eigen::Index k, double c, double s)
  {
    const QpVectorOf<N> left = J_.col(k), right = J_.col(k + 1);
    J_.col(k) = c * left + s * right;
    J_.col(k + 1) = c * right - s * left;
  }

  void drop(Eigen::Index leaving)
  {
    for (Eigen::Index k = leaving; k + 1 < n_active_; ++k) {
      R_.col(k) = R_.col(k + 1);
      u_(k) = u_(k + 1);
      active_[static_cast<std::size_t>(k)] = active_[static_cast<std::size_t>(k + 1)];
    }
    --n_active_;
    // Each shifted column has one entry below the diagonal.
    for (Eigen::Index k = leaving; k < n_active_; ++k) {
      const double a = R_(k, k), b = R_(k + 1, k), length = std::sqrt(a * a + b * b);
      if (b == 0.0) continue;
      const double c = a / length, s = b / length;
      const QpVectorOf<N> upper = R_.row(k), lower = R_.row(k + 1);
      R_.row(k) = (c * upper + s * lower).transpose();
      R_.row(k + 1) = (c * lower - s * upper).transpose();
      rotate(k, c, s);
    }
  }

  const std::vector<HalfSpaceOf<N>>& half_spaces_;
  QpMatrixOf<N> J_;                          // L^-T Q: its first n_active_ columns span the active normals
  QpMatrixOf<N> R_ = QpMatrixOf<N>::Zero();  // upper triangular: J^T N = [R; 0]
  QpVectorOf<N> x_;
  QpVectorOf<N> u_ = QpVectorOf<N>::Zero();
  std::array<std::size_t, N> active_{};
  Eigen::Index n_active_ = 0;
  int n_left_ = max_changes;
};

}  // namespace

template <int N>
QpSolutionOf<N> solve_quadratic_program(const QpMatrixOf<N>& H, const QpVectorOf<N>& g,
                                        const std::vector<HalfSpaceOf<N>>& half_spaces)
{
  return DualMethod<N>(H, g, half_spaces).run();
}

template QpSolutionOf<5> solve_quadratic_program(const QpMatrixOf<5>&, const QpVectorOf<5>&,
                                                 const std::vector<HalfSpaceOf<5>>&);
template QpSolutionOf<6> solve_quadratic_program(const QpMatrixOf<6>&, const QpVectorOf<6>&,
                                                 const std::vector<HalfSpaceOf<6>>&);

// The minimum of a quadratic function in a box, by NLopt (SLSQP).

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

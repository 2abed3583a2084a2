#include "analysis/sequence_program.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::analysis {

BandMatrix::BandMatrix(Eigen::Index n, Eigen::Index width)
    : n_(n), width_(width), values_(static_cast<std::size_t>(n * (width + 1)), 0.0)
{
}

void BandMatrix::factorise()
{
  for (Eigen::Index i = 0; i < n_; ++i) {
    const Eigen::Index first = std::max<Eigen::Index>(0, i - width_);
    for (Eigen::Index j = first; j <= i; ++j) {
      double sum = at(i, j);
      for (Eigen::Index k = std::max(first, j - width_); k < j; ++k) sum -= at(i, k) * at(j, k);
      if (j < i) {
        at(i, j) = sum / at(j, j);
      } else {
        check(sum > 0.0, "the band matrix is positive definite");
        at(i, i) = std::sqrt(sum);
      }
    }
  }
}

std::vector<double> BandMatrix::solve(std::vector<double> b) const
{
  check(static_cast<Eigen::Index>(b.size()) == n_, "one value per row of the band matrix");
  const auto element = [&b](Eigen::Index i) -> double& { return b[static_cast<std::size_t>(i)]; };
  for (Eigen::Index i = 0; i < n_; ++i) {
    for (Eigen::Index j = std::max<Eigen::Index>(0, i - width_); j < i; ++j)
      element(i) -= at(i, j) * element(j);
    element(i) /= at(i, i);
  }
  for (Eigen::Index i = n_ - 1; i >= 0; --i) {
    for (Eigen::Index j = i + 1; j <= std::min(n_ - 1, i + width_); ++j) element(i) -= at(j, i) * element(j);
    element(i) /= at(i, i);
  }
  return b;
}

std::vector<double> BandMatrix::inverse_diagonal() const
{
  BandMatrix inverse(n_, width_);
  std::vector<double> diagonal(static_cast<std::size_t>(n_));
  for (Eigen::Index j = n_ - 1; j >= 0; --j) {
    const Eigen::Index last = std::min(n_ - 1, j + width_);
    for (Eigen::Index i = last; i >= j; --i) {
      double sum = i == j ? 1.0 / at(j, j) : 0.0;
      for (Eigen::Index k = j + 1; k <= last; ++k)
        sum -= at(k, j) * inverse.at(std::max(i, k), std::min(i, k));
      inverse.at(i, j) = sum / at(j, j);
    }
    diagonal[static_cast<std::size_t>(j)] = inverse.at(j, j);
  }
  return diagonal;
}

namespace {

// Below this angle (rad) the next term of each series is below the rounding of a double.
constexpr double small_angle = 1e-4;

Eigen::Vector3d inverse_or_zero(const Eigen::Vector3d& v)
{
  Eigen::Vector3d inverse = Eigen::Vector3d::Zero();
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (v(k) > 0.0) inverse(k) = 1.0 / v(k);
  }
  return inverse;
}

}  // namespace

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& v)
{
  const double angle_sq = v.squaredNorm(), angle = std::sqrt(angle_sq);
  const SinCos turn = sin_cos(angle);
  const double first = angle < small_angle ? 1.0 - angle_sq / 6.0 : turn.sin / angle;
  const double half_sine = sine(0.5 * angle);
  const double second = angle < small_angle ? 0.5 - angle_sq / 24.0 : 2.0 * half_sine * half_sine / angle_sq;
  const Eigen::Matrix3d K = cross_matrix(v);
  return Eigen::Matrix3d::Identity() + first * K + second * (K * K);
}

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R)
{
  const Eigen::Vector3d skew(0.5 * (R(2, 1) - R(1, 2)), 0.5 * (R(0, 2) - R(2, 0)), 0.5 * (R(1, 0) - R(0, 1)));
  const double sine_of_angle = skew.norm();
  const double angle = arc_tangent2(sine_of_angle, 0.5 * (R.trace() - 1.0));
  return angle < small_angle ? Eigen::Vector3d(skew * (1.0 + angle * angle / 6.0))
                             : Eigen::Vector3d(skew * (angle / sine_of_angle));
}

NoiseScale noise_scale(const SolverFrame& frame, const MeasurementNoise& noise)
{
  // Column k: axis k of W in S. Reflection of a left joint changes signs of components only, which a standard
  // deviation does not have.
  Eigen::Matrix3d axes;
  SolverFrame right = frame;
  right.side = Side::right;
  if (frame.side == Side::left) right.delta.z() = -right.delta.z();
  for (Eigen::Index k = 0; k < 3; ++k)
    axes.row(k) = world_from_solver(right, Eigen::Vector3d::Unit(k)).transpose();
  return {axes * noise.rotation_rad.asDiagonal(), axes * noise.translation_mm.asDiagonal(),
          inverse_or_zero(noise.rotation_rad).asDiagonal() * axes.transpose(),
          inverse_or_zero(noise.translation_mm).asDiagonal() * axes.transpose()};
}

Pose displaced(const Pose& X_measured, const Vector6d& twist, const NoiseScale& scale)
{
  Pose X = Pose::Identity();
  X.linear() = rotation_of(scale.rotation * twist.head<3>()) * X_measured.linear();
  X.translation() = X_measured.translation() + scale.translation * twist.tail<3>();
  return X;
}

Eigen::Matrix3d turn_per_twist(const Vector6d& twist, const NoiseScale& scale)
{
  const Eigen::Matrix3d K = cross_matrix(scale.rotation * twist.head<3>());
  return (Eigen::Matrix3d::Identity() + 0.5 * K + K * K / 6.0) * scale.rotation;
}

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

namespace {

// Weights tried: periods of half amplitude from 2.4 frames to 12,000.
constexpr double least_weight = 0.0625, largest_weight = 1099511627776.0 * 16.0;

// Coefficients of the values before, at and after frame k.
std::array<double, 3> coefficients(const std::vector<double>& key, std::size_t k)
{
  const double spacing = (key.back() - key.front()) / static_cast<double>(key.size() - 1);
  const double before = (key[k] - key[k - 1]) / spacing, after = (key[k + 1] - key[k]) / spacing;
  const double mean = 0.5 * (before + after);
  return {1.0 / (before * mean), -1.0 / (before * mean) - 1.0 / (after * mean), 1.0 / (after * mean)};
}

// Inverse left Jacobian of SO(3) at v; with -v the inverse right one. The error is v^4 / 720.
Eigen::Matrix3d inverse_left_jacobian(const Eigen::Vector3d& v)
{
  const Eigen::Matrix3d K = cross_matrix(v);
  return Eigen::Matrix3d::Identity() - 0.5 * K + K * K / 12.0;
}

Vector6d first_difference(const Pose& from, const Pose& to)
{
  Vector6d out;
  out << rotation_vector(Eigen::Matrix3d(to.linear()) * from.linear().transpose()),
      to.translation() - from.translation();
  return out;
}

Vector6d in_noise_units(const Vector6d& twist, const NoiseScale& scale)
{
  Vector6d out;
  out << scale.inverse_rotation * twist.head<3>(), scale.inverse_translation * twist.tail<3>();
  return out;
}

double sum(const std::vector<double>& values)
{
  double total = 0.0;
  for (const double value : values) total += value;
  return total;
}

// I + weight D^T D, factorised.
BandMatrix smoother(const std::vector<double>& key, double weight)
{
  const auto n = static_cast<Eigen::Index>(key.size());
  BandMatrix matrix(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) matrix.at(i, i) = 1.0;
  for (Eigen::Index k = 1; k + 1 < n; ++k) {
    const std::array<double, 3> c = coefficients(key, static_cast<std::size_t>(k));
    for (Eigen::Index i = 0; i < 3; ++i) {
      for (Eigen::Index j = 0; j <= i; ++j)
        matrix.at(k - 1 + i, k - 1 + j) +=
            weight * c[static_cast<std::size_t>(i)] * c[static_cast<std::size_t>(j)];
    }
  }
  matrix.factorise();
  return matrix;
}

}  // namespace

std::vector<SecondDifference> second_differences(const std::vector<double>& key, const std::vector<Pose>& X,
                                                 const std::vector<Vector6d>& twist, const NoiseScale& scale)
{
  std::vector<SecondDifference> out;
  for (std::size_t k = 1; k + 1 < X.size(); ++k) {
    const std::array<double, 3> c = coefficients(key, k);
    const Vector6d before = first_difference(X[k - 1], X[k]), after = first_difference(X[k], X[k + 1]);
    SecondDifference difference;
    difference.frame = k;
    difference.value = in_noise_units(c[2] * after - c[0] * before, scale);
    const Eigen::Matrix3d at_before = inverse_left_jacobian(-Eigen::Vector3d(before.head<3>()));
    const Eigen::Matrix3d after_before = inverse_left_jacobian(before.head<3>());
    const Eigen::Matrix3d at_after = inverse_left_jacobian(-Eigen::Vector3d(after.head<3>()));
    const Eigen::Matrix3d after_after = inverse_left_jacobian(after.head<3>());
    const std::array<Eigen::Matrix3d, 3> turn = {c[0] * at_before, -c[2] * at_after - c[0] * after_before,
                                                 c[2] * after_after};
    for (std::size_t i = 0; i < 3; ++i) {
      Matrix6d& J = difference.jacobian[i];
      J.setZero();
      J.topLeftCorner<3, 3>() = scale.inverse_rotation * turn[i] * turn_per_twist(twist[k - 1 + i], scale);
      J.bottomRightCorner<3, 3>() = c[i] * (scale.inverse_translation * scale.translation);
    }
    out.push_back(difference);
  }
  return out;
}

Vector6d weights_from_noise(const std::vector<double>& key, const std::vector<Pose>& X_measured,
                            const NoiseScale& scale)
{
  Vector6d weights = Vector6d::Zero();
  const std::size_t n = key.size();
  if (n < 3) return weights;
  std::vector<Vector6d> path(n, Vector6d::Zero());
  for (std::size_t k = 1; k < n; ++k)
    path[k] = path[k - 1] + in_noise_units(first_difference(X_measured[k - 1], X_measured[k]), scale);
  Vector6d best = Vector6d::Constant(2.0 * static_cast<double>(n));
  for (double weight = least_weight; weight <= largest_weight; weight *= 2.0) {
    const BandMatrix matrix = smoother(key, weight);
    const double trace = sum(matrix.inverse_diagonal());
    for (Eigen::Index c = 0; c < 6; ++c) {
      std::vector<double> values(n);
      for (std::size_t k = 0; k < n; ++k) values[k] = path[k](c);
      const std::vector<double> smooth = matrix.solve(values);
      double score = 2.0 * trace;
      for (std::size_t k = 0; k < n; ++k) score += (values[k] - smooth[k]) * (values[k] - smooth[k]);
      if (score >= best(c)) continue;
      best(c) = score;
      weights(c) = weight;
    }
  }
  for (Eigen::Index c = 0; c < 3; ++c) {
    if (scale.inverse_rotation.row(c).isZero(0.0)) weights(c) = 0.0;
    if (scale.inverse_translation.row(c).isZero(0.0)) weights(c + 3) = 0.0;
  }
  return weights;
}

double weight_of_period(double period_frames)
{
  check(period_frames > 2.0, "a period of half amplitude is above two frames");
  const double s = 2.0 * sine(pi / period_frames);
  return 1.0 / (s * s * s * s);
}

double period_of_weight(double weight)
{
  if (weight <= 0.0) return 2.0;
  const double half = 0.5 / std::sqrt(std::sqrt(weight));
  return half >= 1.0 ? 2.0 : pi / arc_sine(half);
}

}  // namespace vrda::analysis

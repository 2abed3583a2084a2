#include "coverage.hpp"

#include <gtest/gtest.h>

#include "bench/rigid_body.hpp"
#include "core/units.hpp"

namespace vrda::test {

void Coverage::add(const std::string& name, double error, double half_width)
{
  // Both eyes are pooled, which doubles the number of cases.
  const bool is_left = name.starts_with("left."), is_right = name.starts_with("right.");
  Count& count = counts_[is_left || is_right ? "an eye's" + name.substr(name.find('.')) : name];
  ++count.n;
  if (std::abs(error) <= half_width) ++count.n_within;
}

void Coverage::add(const bench::Estimate& estimate, const Eigen::VectorXd& error)
{
  ASSERT_LE(error.size(), estimate.values.size());
  for (Eigen::Index k = 0; k < error.size(); ++k)
    add(estimate.names[static_cast<std::size_t>(k)], error(k), bench::half_width_95(estimate, k));
}

void Coverage::expect_honest() const
{
  EXPECT_FALSE(counts_.empty());
  for (const auto& [name, count] : counts_) {
    const double share = static_cast<double>(count.n_within) / count.n;
    EXPECT_GE(share, 0.90) << name << ", " << count.n << " cases";
    EXPECT_LE(share, 0.98) << name << ", " << count.n << " cases";
  }
}

Eigen::VectorXd place_error(const Pose& X_found, const Pose& X_true)
{
  Eigen::VectorXd error(6);
  error << X_found.translation() - X_true.translation(),
      bench::turn_of(X_found.linear() * X_true.linear().transpose()) * deg_from_rad(1.0);
  return error;
}

}  // namespace vrda::test

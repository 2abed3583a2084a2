/// Grids of surfaces to smooth.
#pragma once

#include <random>
#include <utility>

#include "analysis/smooth.hpp"

namespace vrda::test {

/// `n` values from `from` on.
inline std::vector<double> axis(int n, double from, double step)
{
  std::vector<double> values;
  for (int i = 0; i < n; ++i) values.push_back(from + step * i);
  return values;
}

/// A solved grid of zeros, varus given.
inline analysis::SmoothInput blank(std::vector<double> flexion_deg, std::vector<double> varus_deg)
{
  analysis::SmoothInput input;
  input.name = "knee.h5";
  const auto rows = static_cast<Eigen::Index>(flexion_deg.size()),
             columns = static_cast<Eigen::Index>(varus_deg.size());
  input.flexion_deg = std::move(flexion_deg);
  input.varus_deg = std::move(varus_deg);
  input.tx_mm = input.ty_mm = input.tz_mm = input.theta_deg = store::GridD::Zero(rows, columns);
  input.status = store::GridB::Zero(rows, columns);
  input.theta_determined = store::GridB::Ones(rows, columns);
  return input;
}

/// Sets all four surfaces to value(flexion, varus) in degrees.
template <typename Value>
void fill(analysis::SmoothInput& input, const Value& value)
{
  for (store::GridD* grid : {&input.tx_mm, &input.ty_mm, &input.tz_mm, &input.theta_deg}) {
    for (Eigen::Index i = 0; i < grid->rows(); ++i) {
      for (Eigen::Index j = 0; j < grid->cols(); ++j)
        (*grid)(i, j) = value(input.flexion_deg[static_cast<std::size_t>(i)],
                              input.varus_deg[static_cast<std::size_t>(j)]);
    }
  }
}

/// Uniform within -1 and 1, equal on all platforms.
class UniformNumbers {
 public:
  explicit UniformNumbers(unsigned seed) : generator_(seed) {}
  double next() { return static_cast<double>(generator_() % 2001) / 1000.0 - 1.0; }

 private:
  std::mt19937_64 generator_;
};

}  // namespace vrda::test

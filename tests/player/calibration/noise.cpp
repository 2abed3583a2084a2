#include "noise.hpp"

namespace vrda::test {

double Noise::uniform()
{
  constexpr double unit = 1.0 / 9007199254740992.0;  // 2^-53
  return static_cast<double>(bits_() >> 11U) * unit;
}

double Noise::normal()
{
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += uniform();
  return sum;
}

Eigen::VectorXd Noise::normals(Eigen::Index n)
{
  Eigen::VectorXd values(n);
  for (double& value : values) value = normal();
  return values;
}

}  // namespace vrda::test

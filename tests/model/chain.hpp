/// The shortest way round an ellipsoid as a chain of points: slow, simple, and shares nothing with the
/// product.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace vrda::test {

using Chain = std::vector<Eigen::Vector3d>;

/// The point outside or on the ellipsoid nearest to being on the straight line between two neighbours.
inline Eigen::Vector3d eased(const Eigen::Vector3d& before, const Eigen::Vector3d& after,
                             const Eigen::Vector3d& half_axes_mm)
{
  Eigen::Vector3d p = 0.5 * (before + after);
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector3d q = p.cwiseQuotient(half_axes_mm);
    const double outside = q.squaredNorm() - 1.0;
    if (outside >= 0.0 && i == 0) return p;
    const Eigen::Vector3d gradient = 2.0 * q.cwiseQuotient(half_axes_mm);
    p -= outside / gradient.squaredNorm() * gradient;
  }
  return p;
}

inline double length_of(const Chain& chain)
{
  double length_mm = 0.0;
  for (std::size_t i = 1; i < chain.size(); ++i) length_mm += (chain[i] - chain[i - 1]).norm();
  return length_mm;
}

/// Length of the way that starts from the given points, by halving the links down to `n_links`; an even
/// number of sweeps a level pulls it tight. Falls short by the arcs over the chords.
inline double chain_length_mm(Chain chain, const Eigen::Vector3d& half_axes_mm, std::size_t n_links)
{
  while (true) {
    for (int sweep = 0; sweep < 400; ++sweep) {
      for (std::size_t i = 1; i + 1 < chain.size(); ++i) {
        chain[i] = eased(chain[i - 1], chain[i + 1], half_axes_mm);
      }
    }
    if (chain.size() > n_links) return length_of(chain);
    Chain finer;
    for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
      finer.push_back(chain[i]);
      finer.push_back(eased(chain[i], chain[i + 1], half_axes_mm));
    }
    finer.push_back(chain.back());
    chain = finer;
  }
}

}  // namespace vrda::test

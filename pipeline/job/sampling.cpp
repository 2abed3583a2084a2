// Samples of the unit cube: the same numbers for the same arguments on every machine.
#include "job/sampled_case.hpp"

#include <boost/random/sobol.hpp>
#include <numeric>
#include <random>
#include <vector>

#include "core/error.hpp"

namespace vrda::job {
namespace {

constexpr double two_to_32 = 4294967296.0;

// Distributions of the standard library differ between implementations; the generator's numbers do not.
std::uint32_t random_bits(std::mt19937_64& random)
{
  return static_cast<std::uint32_t>(random() >> 32U);
}

double inside_unit(std::uint32_t bits)
{
  return (static_cast<double>(bits) + 0.5) / two_to_32;
}

Eigen::MatrixXd sobol_samples(Eigen::Index n_samples, Eigen::Index n_dimensions, std::mt19937_64& random)
{
  std::vector<std::uint32_t> shift(static_cast<std::size_t>(n_dimensions));
  for (std::uint32_t& bits : shift) bits = random_bits(random);
  boost::random::sobol_engine<std::uint32_t, 32> sequence(shift.size());
  Eigen::MatrixXd samples(n_samples, n_dimensions);
  for (Eigen::Index s = 0; s < n_samples; ++s) {
    // Boost omits the first point, the origin, without which 2^k points are not a net.
    for (Eigen::Index d = 0; d < n_dimensions; ++d)
      samples(s, d) = inside_unit((s == 0 ? 0U : sequence()) ^ shift[static_cast<std::size_t>(d)]);
  }
  return samples;
}

Eigen::MatrixXd latin_samples(Eigen::Index n_samples, Eigen::Index n_dimensions, std::mt19937_64& random)
{
  Eigen::MatrixXd samples(n_samples, n_dimensions);
  std::vector<Eigen::Index> order(static_cast<std::size_t>(n_samples));
  for (Eigen::Index d = 0; d < n_dimensions; ++d) {
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    for (std::size_t k = order.size() - 1; k > 0; --k) std::swap(order[k], order[random() % (k + 1)]);
    for (Eigen::Index s = 0; s < n_samples; ++s)
      samples(s, d) =
          (static_cast<double>(order[static_cast<std::size_t>(s)]) + inside_unit(random_bits(random))) /
          static_cast<double>(n_samples);
  }
  return samples;
}

}  // namespace

Eigen::MatrixXd unit_samples(job::SampleSequence sequence, Eigen::Index n_samples, Eigen::Index n_dimensions,
                             std::uint32_t seed)
{
  check(n_samples > 0 && n_dimensions > 0, "unit_samples: an empty sample");
  std::mt19937_64 random(seed);
  return sequence == job::SampleSequence::sobol ? sobol_samples(n_samples, n_dimensions, random)
                                                 : latin_samples(n_samples, n_dimensions, random);
}

}  // namespace vrda::job

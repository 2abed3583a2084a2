#include "job/statistics.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "core/error.hpp"

namespace vrda::job {
namespace {

constexpr int n_terms = 4;                      // of a cubic
constexpr Eigen::Index fewest_samples = 40;     // ten for each term
constexpr double least_spread = 1e-9;           // mm, degrees or N: far below any tolerance of the solver
constexpr double score_of_90_percent = 1.6449;  // of the normal distribution, two-sided

// Mean rank of equal values.
std::vector<double> ranks_of(const std::vector<double>& values)
{
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> ranks(values.size());
  for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
    while (last < order.size() && values[order[last]] == values[order[first]]) ++last;
    for (std::size_t k = first; k < last; ++k)
      ranks[order[k]] = 0.5 * static_cast<double>(first + last - 1);
  }
  return ranks;
}

double correlation(const std::vector<double>& x, const std::vector<double>& y)
{
  const Eigen::Map<const Eigen::ArrayXd> a(x.data(), static_cast<Eigen::Index>(x.size()));
  const Eigen::Map<const Eigen::ArrayXd> b(y.data(), static_cast<Eigen::Index>(y.size()));
  const Eigen::ArrayXd da = a - a.mean(), db = b - b.mean();
  const double spread = std::sqrt(da.square().sum() * db.square().sum());
  return spread > 0.0 ? (da * db).sum() / spread : nan;
}

using Terms = Eigen::Matrix<double, n_terms, 1>;

// Hermite polynomials of degree 0 to 3.
Terms hermite(double z)
{
  return {1.0, z, z * z - 1.0, z * (z * z - 3.0)};
}

// Sums over samples from which a least-squares fit follows; those of groups add up.
struct Sums {
  Eigen::Matrix4d terms = Eigen::Matrix4d::Zero();
  Eigen::MatrixXd products;  // [n_terms, m]
  Eigen::ArrayXd squares;    // [m]
  double n = 0.0;

  explicit Sums(Eigen::Index m) : products(Eigen::MatrixXd::Zero(n_terms, m)), squares(Eigen::ArrayXd::Zero(m))
  {
  }

  void add(double score, const Eigen::RowVectorXd& results)
  {
    const Terms h = hermite(score);
    terms += h * h.transpose();
    products += h * results;
    squares += results.transpose().array().square();
    n += 1.0;
  }

  Sums& operator+=(const Sums& other)
  {
    terms += other.terms;
    products += other.products;
    squares += other.squares;
    n += other.n;
    return *this;
  }

  Sums without(const Sums& part) const
  {
    Sums rest = *this;
    rest.terms -= part.terms;
    rest.products -= part.products;
    rest.squares -= part.squares;
    rest.n -= part.n;
    return rest;
  }

  // [m] adjusted coefficients of determination.
  Eigen::ArrayXd indices() const
  {
    const Eigen::MatrixXd fit = terms.ldlt().solve(products);
    const Eigen::ArrayXd mean_square = products.row(0).transpose().array().square() / n;
    const Eigen::ArrayXd total = squares - mean_square;
    const Eigen::ArrayXd explained = products.cwiseProduct(fit).colwise().sum().transpose().array() - mean_square;
    Eigen::ArrayXd index = 1.0 - (1.0 - explained / total) * (n - 1.0) / (n - n_terms);
    for (Eigen::Index k = 0; k < index.size(); ++k) {
      if (!(std::sqrt(std::max(total[k], 0.0) / n) > least_spread)) index[k] = nan;
    }
    return index;
  }
};

}  // namespace

double quantile(std::vector<double> values, double probability)
{
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return nan;
  std::sort(values.begin(), values.end());
  const double at = probability * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  if (below + 1 == values.size()) return values.back();
  const double share = at - static_cast<double>(below);
  return (1.0 - share) * values[below] + share * values[below + 1];
}

double rank_correlation(std::span<const double> x, std::span<const double> y)
{
  check(x.size() == y.size(), "rank_correlation: pairs");
  std::vector<double> a, b;
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (!std::isfinite(x[k]) || !std::isfinite(y[k])) continue;
    a.push_back(x[k]);
    b.push_back(y[k]);
  }
  return a.size() < 3 ? nan : correlation(ranks_of(a), ranks_of(b));
}

std::vector<int> jackknife_groups(std::size_t n, std::uint32_t seed)
{
  std::vector<int> group(n);
  for (std::size_t k = 0; k < n; ++k) group[k] = static_cast<int>(k % n_jackknife_groups);
  std::mt19937_64 random(seed);
  for (std::size_t k = n; k-- > 1;) std::swap(group[k], group[random() % (k + 1)]);
  return group;
}

std::vector<FirstOrderIndex> first_order_indices(const Eigen::VectorXd& scores, const Eigen::MatrixXd& results,
                                                 const std::vector<int>& group)
{
  const Eigen::Index m = results.cols();
  std::vector<Eigen::Index> rows;
  for (Eigen::Index s = 0; s < results.rows(); ++s) {
    if (results.row(s).allFinite()) rows.push_back(s);
  }
  std::vector<FirstOrderIndex> indices(static_cast<std::size_t>(m), {nan, nan, nan});
  if (static_cast<Eigen::Index>(rows.size()) < fewest_samples) return indices;
  Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(m);
  for (const Eigen::Index s : rows) mean += results.row(s) / static_cast<double>(rows.size());
  std::vector<Sums> parts(n_jackknife_groups, Sums(m));
  Sums all(m);
  for (const Eigen::Index s : rows)
    parts[static_cast<std::size_t>(group[static_cast<std::size_t>(s)])].add(scores[s], results.row(s) - mean);
  for (const Sums& part : parts) all += part;
  const Eigen::ArrayXd index = all.indices();
  Eigen::ArrayXXd left_out(m, n_jackknife_groups);
  for (int g = 0; g < n_jackknife_groups; ++g)
    left_out.col(g) = all.without(parts[static_cast<std::size_t>(g)]).indices();
  const Eigen::ArrayXd centre = left_out.rowwise().mean();
  const Eigen::ArrayXd error = ((left_out.colwise() - centre).square().rowwise().sum() *
                                (n_jackknife_groups - 1.0) / n_jackknife_groups)
                                   .sqrt();
  for (Eigen::Index k = 0; k < m; ++k) {
    if (std::isnan(index[k])) continue;
    const double half_width = score_of_90_percent * error[k];
    indices[static_cast<std::size_t>(k)] = {std::clamp(index[k], 0.0, 1.0),
                                            std::clamp(index[k] - half_width, 0.0, 1.0),
                                            std::clamp(index[k] + half_width, 0.0, 1.0)};
  }
  return indices;
}

}  // namespace vrda::job

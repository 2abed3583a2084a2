// Merges vertices with equal coordinates.
#include "job/clean_mesh.hpp"

#include <algorithm>
#include <numeric>

namespace vrda::job {

WeldedVertices weld_vertices(const RawMesh& raw)
{
  const Eigen::Index n = raw.vertices.rows();
  std::vector<std::int32_t> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  const auto row = [&](std::int32_t v) { return raw.vertices.data() + 3 * static_cast<std::ptrdiff_t>(v); };
  const auto compare = [&](std::int32_t a, std::int32_t b) {
    return std::lexicographical_compare(row(a), row(a) + 3, row(b), row(b) + 3);
  };
  // Stable: the first of equal vertices in the file represents the others.
  std::stable_sort(order.begin(), order.end(), compare);
  std::vector<std::int32_t> earliest(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool is_new = k == 0 || compare(order[k - 1], order[k]);
    earliest[static_cast<std::size_t>(order[k])] =
        is_new ? order[k] : earliest[static_cast<std::size_t>(order[k - 1])];
  }
  WeldedVertices out;
  out.index_of_raw.resize(order.size());
  out.vertices.resize(n, 3);
  out.normal_sums = Points::Zero(raw.normals.rows(), 3);
  std::int32_t n_merged = 0;
  for (Eigen::Index v = 0; v < n; ++v) {
    const auto place = static_cast<std::size_t>(v);
    const bool is_first = earliest[place] == v;
    out.index_of_raw[place] =
        is_first ? n_merged++ : out.index_of_raw[static_cast<std::size_t>(earliest[place])];
    // Adding zero turns -0 into 0.
    if (is_first) out.vertices.row(out.index_of_raw[place]) = raw.vertices.row(v).array() + 0.0;
    if (raw.normals.rows() > 0) out.normal_sums.row(out.index_of_raw[place]) += raw.normals.row(v);
  }
  out.vertices.conservativeResize(n_merged, 3);
  if (raw.normals.rows() > 0) out.normal_sums.conservativeResize(n_merged, 3);
  return out;
}

}  // namespace vrda::job

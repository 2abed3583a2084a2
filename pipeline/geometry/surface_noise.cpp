#include "geometry/surface_noise.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/bucket_sort.hpp"
#include "core/units.hpp"

namespace vrda::geometry {
namespace {

// Fewer vertices are a block, a plate or a rim, of which the median says nothing.
constexpr std::size_t fewest_vertices = 100;

// Neighbours of each vertex in ascending order; rows[v] to rows[v + 1].
struct Neighbours {
  std::vector<std::size_t> rows;
  std::vector<std::int32_t> vertex;

  std::size_t count(std::size_t v) const { return rows[v + 1] - rows[v]; }
};

struct DirectedEdge {
  std::int32_t from = 0, to = 0;
  Eigen::Index triangle = 0;
};

// Each edge of a triangle in both directions, sorted.
std::vector<DirectedEdge> directed_edges(const Mesh& mesh)
{
  std::vector<DirectedEdge> edges;
  edges.reserve(static_cast<std::size_t>(6 * mesh.triangles.rows()));
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = mesh.triangles(t, k), b = mesh.triangles(t, (k + 1) % 3);
      edges.push_back({a, b, t});
      edges.push_back({b, a, t});
    }
  }
  core::sort_by_row(
      edges, static_cast<std::size_t>(mesh.vertices_mm.rows()), [](const DirectedEdge& e) { return e.from; },
      [](const DirectedEdge& a, const DirectedEdge& b) {
        return a.to != b.to ? a.to < b.to : a.triangle < b.triangle;
      });
  return edges;
}

// Calls `use(edge, n)` for the first row of each edge and the number of its triangles.
template <typename Use>
void for_each_edge(const std::vector<DirectedEdge>& edges, const Use& use)
{
  for (std::size_t first = 0; first < edges.size();) {
    std::size_t last = first + 1;
    while (last < edges.size() && edges[last].from == edges[first].from && edges[last].to == edges[first].to)
      ++last;
    use(first, last - first);
    first = last;
  }
}

Neighbours neighbours_of(const std::vector<DirectedEdge>& edges, Eigen::Index n_vertices)
{
  Neighbours all{std::vector<std::size_t>(static_cast<std::size_t>(n_vertices) + 1, 0), {}};
  for_each_edge(edges, [&](std::size_t row, std::size_t) {
    ++all.rows[static_cast<std::size_t>(edges[row].from) + 1];
    all.vertex.push_back(edges[row].to);
  });
  for (std::size_t v = 1; v < all.rows.size(); ++v) all.rows[v] += all.rows[v - 1];
  return all;
}

// Moves each vertex by `factor` towards the mean of its neighbours; vertices without neighbours stay.
void relax(Points& vertices, Points& before, const Neighbours& neighbours, double factor)
{
  before = vertices;
  for (std::size_t v = 0; v + 1 < neighbours.rows.size(); ++v) {
    const std::size_t n = neighbours.count(v);
    if (n == 0) continue;
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    for (std::size_t k = neighbours.rows[v]; k < neighbours.rows[v + 1]; ++k)
      sum += before.row(neighbours.vertex[k]);
    const auto row = static_cast<Eigen::Index>(v);
    vertices.row(row) += factor * (sum / static_cast<double>(n) - before.row(row));
  }
}

// A pass shrinks and swells. It multiplies a shape with the eigenvalue k of the Laplacian by
// (1 - shrink k) (1 + swell k): noise, k near 1, is halved; chains of borders, k up to 2, stay stable.
// All passes together enlarge no shape by more than 0.1 %, exp(excess^2 / 4).
void smooth(Points& vertices, const Neighbours& neighbours, int n_passes)
{
  constexpr double shrink = 0.7, excess = 0.05;
  const double swell = shrink * (1.0 + excess / std::sqrt(static_cast<double>(n_passes)));
  Points before;
  for (int pass = 0; pass < n_passes; ++pass) {
    relax(vertices, before, neighbours, shrink);
    relax(vertices, before, neighbours, -swell);
  }
}

// The row of vertex v of the Laplacian applied twice, with its gain for independent noise.
class TwiceLaplacian {
 public:
  explicit TwiceLaplacian(const Neighbours& neighbours)
      : neighbours_(neighbours), weight_(neighbours.rows.size(), 0.0)
  {
  }

  // What is left of `vertices` at v, divided by the gain.
  Eigen::RowVector3d left_at(const Points& vertices, std::size_t v)
  {
    used_.clear();
    add(static_cast<std::int32_t>(v), 1.0);
    const double share = 1.0 / static_cast<double>(neighbours_.count(v));
    for (std::size_t k = neighbours_.rows[v]; k < neighbours_.rows[v + 1]; ++k) {
      const std::int32_t next = neighbours_.vertex[k];
      add(next, -2.0 * share);
      const auto n = static_cast<std::size_t>(next);
      for (std::size_t j = neighbours_.rows[n]; j < neighbours_.rows[n + 1]; ++j)
        add(neighbours_.vertex[j], share / static_cast<double>(neighbours_.count(n)));
    }
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    double gain_sq = 0.0;
    for (const std::int32_t u : used_) {
      double& weight = weight_[static_cast<std::size_t>(u)];
      sum += weight * vertices.row(u);
      gain_sq += weight * weight;
      weight = 0.0;
    }
    return gain_sq > 0.0 ? Eigen::RowVector3d(sum / std::sqrt(gain_sq)) : sum;
  }

 private:
  void add(std::int32_t u, double weight)
  {
    double& at = weight_[static_cast<std::size_t>(u)];
    if (at == 0.0) used_.push_back(u);
    at += weight;
  }

  const Neighbours& neighbours_;
  std::vector<double> weight_;
  std::vector<std::int32_t> used_;
};

// Vertices with neighbours that are neither on a border nor next to one.
std::vector<std::size_t> inner_vertices(const std::vector<DirectedEdge>& edges, const Neighbours& neighbours)
{
  std::vector<bool> is_border(neighbours.rows.size(), false);
  for_each_edge(edges, [&](std::size_t row, std::size_t n_triangles) {
    if (n_triangles != 2) is_border[static_cast<std::size_t>(edges[row].from)] = true;
  });
  std::vector<std::size_t> inner;
  for (std::size_t v = 0; v + 1 < neighbours.rows.size(); ++v) {
    bool is_inner = neighbours.count(v) > 0 && !is_border[v];
    for (std::size_t k = neighbours.rows[v]; k < neighbours.rows[v + 1]; ++k)
      is_inner = is_inner && !is_border[static_cast<std::size_t>(neighbours.vertex[k])];
    if (is_inner) inner.push_back(v);
  }
  return inner;
}

// Mean edge e: curvature of radius R leaves some e^2 / 8R, steps of a segmentation a share of e.
double clean_limit_mm(double edge_mm)
{
  constexpr double share = 0.035, radius_mm = 55.0;  // measured: README
  return share * edge_mm + edge_mm * edge_mm / radius_mm;
}

// The rims of thin bodies look like noise: menisci have 2 to 4 mm, a fibula 7 mm, bones more than 12 mm.
bool is_thin(Mesh mesh)
{
  constexpr double thinnest_mm = 10.0;
  const Eigen::RowVector3d middle = mesh.vertices_mm.colwise().mean();
  mesh.vertices_mm.rowwise() -= middle;
  return 2.0 * std::abs(signed_volume_mm3(mesh)) < thinnest_mm * area_mm2(mesh);
}

// Of edges and corners that are kept: at least that of cut shafts, and beyond what noise makes of flat parts,
// where the angle between neighbouring triangles has a standard deviation of some 2.3 noise / edge. Beyond
// 100 degrees noise looks the same: no edges.
double least_sharp_rad(const SurfaceNoise& noise)
{
  constexpr double least_rad = rad_from_deg(60.0), most_rad = rad_from_deg(100.0), deviations = 4.5;
  const double of_noise_rad = deviations * 2.3 * noise.noise_mm / noise.edge_mm;
  return of_noise_rad > most_rad ? pi : std::max(least_rad, of_noise_rad);
}

// Borders and sharp edges, by their vertices.
struct Lines {
  Neighbours along;
  std::vector<bool> is_border;
};

Lines lines_of(const Mesh& mesh, const std::vector<DirectedEdge>& edges, double sharp_rad)
{
  const double least_cosine = sin_cos(sharp_rad).cos;
  std::vector<DirectedEdge> lines;
  std::vector<bool> is_border(static_cast<std::size_t>(mesh.vertices_mm.rows()), false);
  for_each_edge(edges, [&](std::size_t row, std::size_t n_triangles) {
    const DirectedEdge& edge = edges[row];
    if (n_triangles != 2) is_border[static_cast<std::size_t>(edge.from)] = true;
    if (n_triangles != 2 ||
        face_normal(mesh, edge.triangle).dot(face_normal(mesh, edges[row + 1].triangle)) < least_cosine)
      lines.push_back(edge);
  });
  return {neighbours_of(lines, mesh.vertices_mm.rows()), std::move(is_border)};
}

bool is_corner(const Points& vertices, std::size_t v, const Neighbours& lines, double sharp_rad)
{
  const Eigen::RowVector3d p = vertices.row(static_cast<Eigen::Index>(v));
  const Eigen::RowVector3d a = p - vertices.row(lines.vertex[lines.rows[v]]);
  const Eigen::RowVector3d b = vertices.row(lines.vertex[lines.rows[v] + 1]) - p;
  return a.dot(b) < sin_cos(sharp_rad).cos * a.norm() * b.norm();
}

// The neighbours towards which each vertex may move.
Neighbours allowed_neighbours(const Mesh& mesh, const SurfaceNoise& noise)
{
  const std::vector<DirectedEdge> edges = directed_edges(mesh);
  const Neighbours all = neighbours_of(edges, mesh.vertices_mm.rows());
  const double sharp_rad = least_sharp_rad(noise);
  const auto [lines, is_border] = lines_of(mesh, edges, sharp_rad);
  Neighbours allowed{{0}, {}};
  for (std::size_t v = 0; v + 1 < all.rows.size(); ++v) {
    const std::size_t n = lines.count(v);
    const bool is_free = n == 0 || (n == 1 && !is_border[v]);  // a single sharp edge is noise
    const bool is_along = n == 2 && !is_corner(mesh.vertices_mm, v, lines, sharp_rad);
    const Neighbours& from = is_free ? all : lines;
    if (is_free || is_along)
      allowed.vertex.insert(allowed.vertex.end(),
                            from.vertex.begin() + static_cast<std::ptrdiff_t>(from.rows[v]),
                            from.vertex.begin() + static_cast<std::ptrdiff_t>(from.rows[v + 1]));
    allowed.rows.push_back(allowed.vertex.size());
  }
  return allowed;
}

// More passes remove noise of longer waves, and shapes of bones with them, on long edges sooner: the error of
// the vertices is least near this number on real knees with noise of 0.25 to 1 mm (README).
int passes_for(const SurfaceNoise& noise)
{
  constexpr double per_noise_of_an_edge = 100.0, long_edge_mm = 3.0, fewest = 4.0, most = 200.0;
  const double edge = noise.edge_mm / long_edge_mm;
  const double n = per_noise_of_an_edge * noise.noise_mm / noise.edge_mm / (1.0 + edge * edge);
  return static_cast<int>(std::clamp(std::ceil(n), fewest, most));
}

}  // namespace

SurfaceNoise surface_noise(const Mesh& mesh)
{
  SurfaceNoise noise{std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};
  if (mesh.triangles.rows() == 0) return noise;
  const std::vector<DirectedEdge> edges = directed_edges(mesh);
  const Neighbours neighbours = neighbours_of(edges, mesh.vertices_mm.rows());
  constexpr int n_passes = 20;  // noise of the length of an edge lengthens edges and turns normals around
  Mesh smoothed = mesh;
  smooth(smoothed.vertices_mm, neighbours, n_passes);
  noise.edge_mm = mean_edge_length_mm(smoothed);
  noise.limit_mm = clean_limit_mm(noise.edge_mm);
  const std::vector<std::size_t> inner = inner_vertices(edges, neighbours);
  constexpr double longest_of_thin_mm = 1.5, thin_factor = 2.0;
  const bool has_rims = is_thin(smoothed);
  if (has_rims) noise.limit_mm *= thin_factor;
  if (inner.size() < fewest_vertices || (has_rims && noise.edge_mm > longest_of_thin_mm)) return noise;
  const Points normals = vertex_normals(smoothed);
  TwiceLaplacian twice(neighbours);
  std::vector<double> across_mm;
  constexpr std::size_t most_judged = 100'000;
  for (std::size_t k = 0; k < inner.size(); k += 1 + inner.size() / most_judged)
    across_mm.push_back(std::abs(
        twice.left_at(mesh.vertices_mm, inner[k]).dot(normals.row(static_cast<Eigen::Index>(inner[k])))));
  constexpr double median_of_normal = 0.6745;  // of the absolute value, in standard deviations
  const auto middle = across_mm.begin() + static_cast<std::ptrdiff_t>(across_mm.size() / 2);
  std::nth_element(across_mm.begin(), middle, across_mm.end());
  noise.noise_mm = *middle / median_of_normal;
  return noise;
}

SmoothedSurface smoothed_surface(const Mesh& mesh, const SurfaceNoise& noise)
{
  SmoothedSurface out{mesh, {}, passes_for(noise)};
  smooth(out.mesh.vertices_mm, allowed_neighbours(mesh, noise), out.n_passes);
  out.mesh.normals = vertex_normals(out.mesh);
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v)
    out.moved_mm.push_back((out.mesh.vertices_mm.row(v) - mesh.vertices_mm.row(v)).norm());
  return out;
}

}  // namespace vrda::geometry

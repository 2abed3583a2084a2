#include "geometry/level_set.hpp"

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "core/text.hpp"
#include "core/units.hpp"
#include "geometry/shapes.hpp"

namespace vrda::geometry {
namespace {

using Index3 = std::array<int, 3>;

// Samples of a field on the nodes of a regular grid.
struct Samples {
  Eigen::Vector3d origin_mm;
  double cell_mm = 0.0;
  Index3 n_nodes{};
  std::vector<double> value;

  std::size_t at(const Index3& node) const
  {
    return (static_cast<std::size_t>(node[2]) * static_cast<std::size_t>(n_nodes[1]) +
            static_cast<std::size_t>(node[1])) *
               static_cast<std::size_t>(n_nodes[0]) +
           static_cast<std::size_t>(node[0]);
  }
  Eigen::Vector3d position_mm(const Index3& node) const
  {
    return origin_mm + cell_mm * Eigen::Vector3d(node[0], node[1], node[2]);
  }
};

template <typename Visit>
void for_each_node(const Index3& first, const Index3& end, const Visit& visit)
{
  Index3 node{};
  for (node[2] = first[2]; node[2] < end[2]; ++node[2]) {
    for (node[1] = first[1]; node[1] < end[1]; ++node[1]) {
      for (node[0] = first[0]; node[0] < end[0]; ++node[0]) visit(node);
    }
  }
}

// A surface in a box has seldom more triangles than the box's own surface, and samples grow with its volume.
void require_moderate_grid(const Box& box_mm, double cell_mm)
{
  const Eigen::Vector3d n = (box_mm.max_mm - box_mm.min_mm) / cell_mm;
  require_moderate_size(4.0 * (n.x() * n.y() + n.y() * n.z() + n.z() * n.x()), "resolution");
}

// Blocks that cannot contain the surface, by the gradient bound, take the value of their middle.
Samples sample(const Field& field, const Box& box_mm, double cell_mm, double steepest_slope)
{
  constexpr int block = 6;
  require_moderate_grid(box_mm, cell_mm);
  Samples samples;
  samples.origin_mm = box_mm.min_mm.array() - cell_mm;
  samples.cell_mm = cell_mm;
  Index3 n_blocks{};
  for (int axis = 0; axis < 3; ++axis) {
    const double extent_mm = box_mm.max_mm[axis] - box_mm.min_mm[axis] + 2.0 * cell_mm;
    samples.n_nodes[static_cast<std::size_t>(axis)] = static_cast<int>(std::ceil(extent_mm / cell_mm)) + 1;
    n_blocks[static_cast<std::size_t>(axis)] =
        (samples.n_nodes[static_cast<std::size_t>(axis)] + block - 1) / block;
  }
  samples.value.resize(samples.at({0, 0, samples.n_nodes[2]}));
  const double reach_mm = 0.5 * (block - 1) * cell_mm * std::sqrt(3.0);
  for_each_node({0, 0, 0}, n_blocks, [&](const Index3& b) {
    Index3 first{}, end{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      first[axis] = block * b[axis];
      end[axis] = std::min(first[axis] + block, samples.n_nodes[axis]);
    }
    const Eigen::Vector3d middle =
        samples.position_mm(first) + Eigen::Vector3d::Constant(0.5 * (block - 1) * cell_mm);
    const double at_middle = field(middle);
    const bool is_empty = std::abs(at_middle) > steepest_slope * reach_mm;
    for_each_node(first, end, [&](const Index3& node) {
      samples.value[samples.at(node)] = is_empty ? at_middle : field(samples.position_mm(node));
    });
  });
  return samples;
}

// Mean of the surface's crossings of the cell's edges; empty without a crossing.
std::optional<Eigen::Vector3d> cell_vertex(const Samples& samples, const Index3& cell)
{
  static constexpr std::array<std::array<int, 2>, 12> edges = {
      {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3}, {4, 6}, {5, 7}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};
  const auto node = [&](int c) {
    return Index3{cell[0] + (c & 1), cell[1] + ((c >> 1) & 1), cell[2] + (c >> 2)};
  };
  std::array<double, 8> value{};
  int n_inside = 0;
  for (int c = 0; c < 8; ++c) {
    value[static_cast<std::size_t>(c)] = samples.value[samples.at(node(c))];
    n_inside += value[static_cast<std::size_t>(c)] < 0.0 ? 1 : 0;
  }
  if (n_inside == 0 || n_inside == 8) return std::nullopt;
  std::array<Eigen::Vector3d, 8> corner;
  for (int c = 0; c < 8; ++c) corner[static_cast<std::size_t>(c)] = samples.position_mm(node(c));
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int n_crossings = 0;
  for (const auto& edge : edges) {
    const auto a = static_cast<std::size_t>(edge[0]), b = static_cast<std::size_t>(edge[1]);
    if ((value[a] < 0.0) == (value[b] < 0.0)) continue;
    const double t = value[a] / (value[a] - value[b]);
    sum += corner[a] + t * (corner[b] - corner[a]);
    ++n_crossings;
  }
  return Eigen::Vector3d(sum / n_crossings);
}

using Quad = std::array<std::int32_t, 4>;

struct Net {
  std::vector<Eigen::Vector3d> vertices_mm;
  std::vector<Index3> cells;    // of the grid, one per vertex
  std::vector<bool> is_pinned;  // vertices excluded from relaxation
  std::vector<Quad> quads;
};

// One vertex a crossed cell, one quad a crossed grid edge.
Net surface_net(const Samples& samples)
{
  Net net;
  std::vector<std::int32_t> vertex_of_cell(samples.value.size(), -1);
  const Index3 end{samples.n_nodes[0] - 1, samples.n_nodes[1] - 1, samples.n_nodes[2] - 1};
  for_each_node({0, 0, 0}, end, [&](const Index3& cell) {
    const std::optional<Eigen::Vector3d> vertex_mm = cell_vertex(samples, cell);
    if (!vertex_mm) return;
    vertex_of_cell[samples.at(cell)] = static_cast<std::int32_t>(net.vertices_mm.size());
    net.vertices_mm.push_back(*vertex_mm);
    net.cells.push_back(cell);
  });
  net.is_pinned.assign(net.vertices_mm.size(), false);
  for_each_node({1, 1, 1}, end, [&](const Index3& node) {
    const bool is_inside = samples.value[samples.at(node)] < 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Index3 next = node;
      ++next[axis];
      if ((samples.value[samples.at(next)] < 0.0) == is_inside) continue;
      const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
      Index3 low_u = node, low_v = node, low_uv = node;
      --low_u[u], --low_v[v], --low_uv[u], --low_uv[v];
      Quad quad{vertex_of_cell[samples.at(low_uv)], vertex_of_cell[samples.at(low_v)],
                vertex_of_cell[samples.at(node)], vertex_of_cell[samples.at(low_u)]};
      if (!is_inside) std::swap(quad[1], quad[3]);
      net.quads.push_back(quad);
    }
  });
  return net;
}

Eigen::Vector3d gradient(const Field& field, const Eigen::Vector3d& p)
{
  constexpr double h_mm = 1e-3;  // fields are smooth over tenths of a mm; rounding adds 1e-12 / h
  Eigen::Vector3d g;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = h_mm * Eigen::Vector3d::Unit(axis);
    g[axis] = (field(p + step) - field(p - step)) / (2.0 * h_mm);
  }
  return g;
}

// A Newton step towards the surface along the unit direction n, limited to a quarter of a cell.
Eigen::Vector3d projected(const Field& field, const Eigen::Vector3d& p, const Eigen::Vector3d& n,
                          double cell_mm)
{
  constexpr double h_mm = 1e-3;
  constexpr double flattest = 0.2;  // below this slope the step is meaningless
  const double value = field(p);
  const double slope = (field(p + h_mm * n) - value) / h_mm;
  const double longest_mm = 0.25 * cell_mm;
  return p - std::clamp(value / std::max(slope, flattest), -longest_mm, longest_mm) * n;
}

std::vector<Eigen::Vector3d> normals(const Net& net)
{
  std::vector<Eigen::Vector3d> sum(net.vertices_mm.size(), Eigen::Vector3d::Zero());
  for (const Quad& quad : net.quads) {
    const auto at = [&](std::size_t k) -> const Eigen::Vector3d& {
      return net.vertices_mm[static_cast<std::size_t>(quad[k])];
    };
    const Eigen::Vector3d area = (at(2) - at(0)).cross(at(3) - at(1));
    for (const std::int32_t v : quad) sum[static_cast<std::size_t>(v)] += area;
  }
  for (Eigen::Vector3d& n : sum) n.normalize();
  return sum;
}

// Each vertex moves along the surface halfway to the mean of its neighbours across the net's quads.
void relax(Net& net, const Field& field, double cell_mm)
{
  std::vector<Eigen::Vector3d> sum(net.vertices_mm.size(), Eigen::Vector3d::Zero());
  std::vector<int> count(net.vertices_mm.size(), 0);
  for (const Quad& quad : net.quads) {
    for (std::size_t k = 0; k < 4; ++k) {
      const auto from = static_cast<std::size_t>(quad[k]), to = static_cast<std::size_t>(quad[(k + 1) % 4]);
      sum[from] += net.vertices_mm[to];
      sum[to] += net.vertices_mm[from];
      ++count[from], ++count[to];
    }
  }
  const std::vector<Eigen::Vector3d> normal = normals(net);
  for (std::size_t v = 0; v < net.vertices_mm.size(); ++v) {
    if (net.is_pinned[v]) continue;
    const Eigen::Vector3d& n = normal[v];
    const Eigen::Vector3d towards = sum[v] / count[v] - net.vertices_mm[v];
    const Eigen::Vector3d moved = net.vertices_mm[v] + 0.5 * (towards - towards.dot(n) * n);
    net.vertices_mm[v] = projected(field, moved, n, cell_mm);
  }
}

// Quads split along their shorter diagonal.
Mesh triangulated(const Net& net)
{
  Mesh mesh;
  mesh.vertices_mm.resize(static_cast<Eigen::Index>(net.vertices_mm.size()), 3);
  for (std::size_t v = 0; v < net.vertices_mm.size(); ++v) {
    mesh.vertices_mm.row(static_cast<Eigen::Index>(v)) = net.vertices_mm[v].transpose();
  }
  mesh.triangles.resize(2 * static_cast<Eigen::Index>(net.quads.size()), 3);
  Eigen::Index t = 0;
  for (const Quad& q : net.quads) {
    const auto diagonal_sq_mm2 = [&](std::size_t a, std::size_t b) {
      return (net.vertices_mm[static_cast<std::size_t>(q[a])] -
              net.vertices_mm[static_cast<std::size_t>(q[b])])
          .squaredNorm();
    };
    const bool is_first = diagonal_sq_mm2(0, 2) <= diagonal_sq_mm2(1, 3);
    if (is_first) {
      mesh.triangles.row(t++) << q[0], q[1], q[2];
      mesh.triangles.row(t++) << q[0], q[2], q[3];
    } else {
      mesh.triangles.row(t++) << q[1], q[2], q[3];
      mesh.triangles.row(t++) << q[1], q[3], q[0];
    }
  }
  return mesh;
}

void put_on_surface(Mesh& mesh, const Field& field, double cell_mm)
{
  mesh.normals.resize(mesh.vertices_mm.rows(), 3);
  constexpr int n_steps = 3;  // Newton's method from within a hundredth of a cell
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) {
    Eigen::Vector3d p = mesh.vertices_mm.row(v);
    Eigen::Vector3d n = gradient(field, p).normalized();
    for (int step = 0; step < n_steps; ++step) p = projected(field, p, n, cell_mm);
    mesh.vertices_mm.row(v) = p.transpose();
    mesh.normals.row(v) = gradient(field, p).normalized().transpose();
  }
}

// The net's triangles; empty when an edge has more than two faces.
std::optional<Mesh> manifold_mesh(const Net& net)
{
  Mesh mesh = triangulated(net);
  const EdgeCounts edges = edge_counts(mesh);
  check(edges.boundary == 0, "level_set_mesh: the surface is inside its box");
  if (edges.non_manifold > 0) return std::nullopt;
  return mesh;
}

Net relaxed_net(const LevelSet& set, double cell_mm, const LevelSetOptions& options)
{
  Net net = surface_net(sample(set.field, set.box_mm, cell_mm, options.max_gradient));
  for (int pass = 0; pass < options.n_relaxations; ++pass) relax(net, set.field, cell_mm);
  return net;
}

// Moves vertices of `net` to the vertices of the same cells in `neighbour`, and pins them, where both
// surfaces coincide. `shift` is added to a cell of `net` for its index in the neighbour's grid.
void pin_to_neighbour(Net& net, const Net& neighbour, const Index3& shift, const Field& field,
                      const Field& neighbour_field)
{
  std::map<Index3, std::size_t> vertex_of_cell;
  for (std::size_t v = 0; v < neighbour.cells.size(); ++v) vertex_of_cell[neighbour.cells[v]] = v;
  for (std::size_t v = 0; v < net.cells.size(); ++v) {
    const Index3& cell = net.cells[v];
    const auto found = vertex_of_cell.find({cell[0] + shift[0], cell[1] + shift[1], cell[2] + shift[2]});
    if (found == vertex_of_cell.end()) continue;
    const Eigen::Vector3d& p = neighbour.vertices_mm[found->second];
    if (field(p) != neighbour_field(p)) continue;
    net.vertices_mm[v] = p;
    net.is_pinned[v] = true;
  }
}

// The net of `wanted` on the grid of `neighbour`, with common vertices where the surfaces coincide.
Net net_along(const LevelSet& neighbour, const Net& neighbour_net, const LevelSet& wanted, double cell_mm,
              const LevelSetOptions& options)
{
  Box box_mm = wanted.box_mm;  // extended to nodes of the neighbour's grid
  Index3 shift{};
  for (int axis = 0; axis < 3; ++axis) {
    const double corner_mm = neighbour.box_mm.min_mm[axis];
    const int n_cells = static_cast<int>(std::floor((box_mm.min_mm[axis] - corner_mm) / cell_mm));
    shift[static_cast<std::size_t>(axis)] = n_cells;
    box_mm.min_mm[axis] = corner_mm + n_cells * cell_mm;
  }
  Net net = surface_net(sample(wanted.field, box_mm, cell_mm, options.max_gradient));
  pin_to_neighbour(net, neighbour_net, shift, wanted.field, neighbour.field);
  for (int pass = 0; pass < options.n_relaxations; ++pass) relax(net, wanted.field, cell_mm);
  return net;
}

// Cell sizes to try, each one percent smaller.
class CellSizes {
 public:
  explicit CellSizes(double cell_mm) : cell_mm_(cell_mm) {}
  double next_mm()
  {
    check(n_tried_++ < most_attempts, "level_set_mesh: one of the cell sizes gives a manifold mesh");
    return std::exchange(cell_mm_, cell_mm_ * 0.99);
  }

 private:
  static constexpr int most_attempts = 20;
  double cell_mm_;
  int n_tried_ = 0;
};

}  // namespace

Mesh level_set_mesh(const Field& field, const Box& box_mm, const LevelSetOptions& options)
{
  for (CellSizes cells(options.cell_mm);;) {
    const double cell_mm = cells.next_mm();
    std::optional<Mesh> mesh = manifold_mesh(relaxed_net({field, box_mm}, cell_mm, options));
    if (!mesh) continue;
    put_on_surface(*mesh, field, cell_mm);
    return std::move(*mesh);
  }
}

AdjoiningMeshes adjoining_level_set_meshes(const LevelSet& first, const LevelSet& second,
                                           const LevelSetOptions& options)
{
  std::optional<Mesh> first_mesh;
  for (CellSizes cells(options.cell_mm);;) {
    const double cell_mm = cells.next_mm();
    const Net first_net = relaxed_net(first, cell_mm, options);
    std::optional<Mesh> mesh = manifold_mesh(first_net);
    if (!mesh) continue;
    if (!first_mesh) {
      first_mesh = std::move(mesh);
      put_on_surface(*first_mesh, first.field, cell_mm);
    }
    std::optional<Mesh> second_mesh = manifold_mesh(net_along(first, first_net, second, cell_mm, options));
    if (!second_mesh) continue;
    put_on_surface(*second_mesh, second.field, cell_mm);
    return {std::move(*first_mesh), std::move(*second_mesh)};
  }
}

namespace {

using Face = std::array<std::int32_t, 3>;

Mesh assembled(const std::vector<Eigen::Vector3d>& vertices_mm, const std::vector<Face>& faces)
{
  Mesh mesh;
  mesh.vertices_mm.resize(static_cast<Eigen::Index>(vertices_mm.size()), 3);
  for (std::size_t v = 0; v < vertices_mm.size(); ++v) {
    mesh.vertices_mm.row(static_cast<Eigen::Index>(v)) = vertices_mm[v].transpose();
  }
  mesh.triangles.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t t = 0; t < faces.size(); ++t) {
    mesh.triangles.row(static_cast<Eigen::Index>(t)) << faces[t][0], faces[t][1], faces[t][2];
  }
  return mesh;
}

// Vertices and faces of a block under construction; vertices are created on first use.
class BlockBuilder {
 public:
  explicit BlockBuilder(const ShapedBlock& block) : block_(block)
  {
    n_x_ = static_cast<int>(block.x_mm.size()) - 1;
    n_z_ = static_cast<int>(block.z_mm.size()) - 1;
    faces_up_ = block.front_y_mm(block.x_mm.front(), block.z_mm.front()) > block.back_y_mm;
  }

  Mesh mesh()
  {
    for (int i = 0; i < n_x_; ++i) {
      for (int k = 0; k < n_z_; ++k) {
        if (!is_filled(i, k)) continue;
        add_front(i, k);
        add_quad(back(i, k), back(i + 1, k), back(i + 1, k + 1), back(i, k + 1));
        if (!is_filled(i - 1, k)) add_quad(front(i, k), back(i, k), back(i, k + 1), front(i, k + 1));
        if (!is_filled(i + 1, k))
          add_quad(front(i + 1, k + 1), back(i + 1, k + 1), back(i + 1, k), front(i + 1, k));
        if (!is_filled(i, k - 1)) add_quad(front(i + 1, k), back(i + 1, k), back(i, k), front(i, k));
        if (!is_filled(i, k + 1))
          add_quad(front(i, k + 1), back(i, k + 1), back(i + 1, k + 1), front(i + 1, k + 1));
      }
    }
    Mesh result = assembled(vertices_mm_, faces_);
    result.normals = vertex_normals(result);
    return result;
  }

 private:
  bool is_filled(int i, int k) const
  {
    if (i < 0 || k < 0 || i >= n_x_ || k >= n_z_) return false;
    const auto reach = [](const std::vector<double>& lines, int n) {
      const auto at = static_cast<std::size_t>(n);
      return std::max(std::abs(lines[at]), std::abs(lines[at + 1]));
    };
    return std::max(reach(block_.x_mm, i), reach(block_.z_mm, k)) > block_.hole_half_mm;
  }

  std::int32_t vertex(int i, int k, bool is_front)
  {
    const auto [found, is_new] =
        index_.try_emplace({i, k, is_front ? 1 : 0}, static_cast<std::int32_t>(vertices_mm_.size()));
    if (is_new) {
      const double x = block_.x_mm[static_cast<std::size_t>(i)], z = block_.z_mm[static_cast<std::size_t>(k)];
      vertices_mm_.emplace_back(x, is_front ? block_.front_y_mm(x, z) : block_.back_y_mm, z);
    }
    return found->second;
  }
  std::int32_t front(int i, int k) { return vertex(i, k, true); }
  std::int32_t back(int i, int k) { return vertex(i, k, false); }

  // Counter-clockwise seen from outside when the front faces up.
  void add_face(std::int32_t a, std::int32_t b, std::int32_t c)
  {
    faces_.push_back(faces_up_ ? Face{a, b, c} : Face{a, c, b});
  }
  void add_quad(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d)
  {
    add_face(a, b, c);
    add_face(a, c, d);
  }

  void add_front(int i, int k)
  {
    const std::int32_t a = front(i, k), b = front(i, k + 1), c = front(i + 1, k + 1), d = front(i + 1, k);
    const auto y = [&](std::int32_t v) { return vertices_mm_[static_cast<std::size_t>(v)].y(); };
    const auto at = [](const std::vector<double>& lines, int n) {
      return 0.5 * (lines[static_cast<std::size_t>(n)] + lines[static_cast<std::size_t>(n) + 1]);
    };
    const double middle = block_.front_y_mm(at(block_.x_mm, i), at(block_.z_mm, k));
    const bool is_first = std::abs(0.5 * (y(a) + y(c)) - middle) <= std::abs(0.5 * (y(b) + y(d)) - middle);
    is_first ? add_quad(a, b, c, d) : add_quad(b, c, d, a);
  }

  const ShapedBlock& block_;
  int n_x_ = 0;
  int n_z_ = 0;
  bool faces_up_ = true;
  std::map<std::array<int, 3>, std::int32_t> index_;
  std::vector<Eigen::Vector3d> vertices_mm_;
  std::vector<Face> faces_;
};

// Corners and faces of an icosahedron on the unit ball with a corner at +Y: two rings of five at
// heights +-1 / sqrt(5).
struct Icosahedron {
  std::array<Eigen::Vector3d, 12> corner;
  std::vector<Face> faces;
};

Icosahedron icosahedron()
{
  Icosahedron result;
  const double height = 1.0 / std::sqrt(5.0), radius = 2.0 * height;
  result.corner[0] = Eigen::Vector3d(0, 1, 0);
  result.corner[11] = Eigen::Vector3d(0, -1, 0);
  for (std::int32_t k = 0; k < 5; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const SinCos upper = sin_cos(2.0 * pi * k / 5.0), lower = sin_cos(2.0 * pi * (k + 0.5) / 5.0);
    result.corner[1 + at] = {radius * upper.cos, height, -radius * upper.sin};
    result.corner[6 + at] = {radius * lower.cos, -height, -radius * lower.sin};
    const std::int32_t u = 1 + k, u_next = 1 + (k + 1) % 5, l = 6 + k, l_next = 6 + (k + 1) % 5;
    result.faces.insert(result.faces.end(), {Face{0, u, u_next}, Face{u, l, u_next}, Face{u_next, l, l_next},
                                             Face{11, l_next, l}});
  }
  return result;
}

// Points on a face are identified by corners and weights, so that faces share the points of their edges.
using PointName = std::array<std::pair<std::int32_t, int>, 3>;

}  // namespace

void append_lines(std::vector<double>& lines, double from, double to, int n_steps)
{
  for (int k = lines.empty() ? 0 : 1; k <= n_steps; ++k) {
    const double t = static_cast<double>(k) / n_steps;
    lines.push_back(from * (1.0 - t) + to * t);
  }
}

Mesh block_mesh(const ShapedBlock& block)
{
  return BlockBuilder(block).mesh();
}

Mesh plain_pyramid_mesh(double half_base_mm, double rim_y_mm, double back_y_mm)
{
  // Corners counter-clockwise seen from above: 0 to 3 rim, 4 to 7 back, 8 tip.
  std::vector<Eigen::Vector3d> vertices_mm;
  for (const double y : {rim_y_mm, back_y_mm}) {
    for (const auto& [x, z] : {std::pair(1.0, 1.0), {1.0, -1.0}, {-1.0, -1.0}, {-1.0, 1.0}}) {
      vertices_mm.emplace_back(half_base_mm * x, y, half_base_mm * z);
    }
  }
  vertices_mm.emplace_back(0.0, 0.0, 0.0);
  std::vector<Face> faces = {{4, 6, 5}, {4, 7, 6}};
  for (std::int32_t k = 0; k < 4; ++k) {
    const std::int32_t next = (k + 1) % 4;
    faces.insert(faces.end(), {Face{k, next, 8}, Face{k + 4, next, k}, Face{k + 4, next + 4, next}});
  }
  if (back_y_mm > 0.0) {
    for (Face& face : faces) std::swap(face[1], face[2]);
  }
  Mesh mesh = assembled(vertices_mm, faces);
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

Mesh ellipsoid_mesh(const Eigen::Vector3d& half_axes_mm, int n_edges)
{
  const Icosahedron base = icosahedron();
  std::map<PointName, std::int32_t> index;
  std::vector<Eigen::Vector3d> vertices_mm, normal;
  std::vector<Face> faces;
  const auto point = [&](const Face& face, int a, int b) {
    PointName name = {{{face[0], n_edges - a - b}, {face[1], a}, {face[2], b}}};
    for (auto& [corner, weight] : name) corner = weight == 0 ? -1 : corner;
    std::sort(name.begin(), name.end());
    const auto [found, is_new] = index.try_emplace(name, static_cast<std::int32_t>(vertices_mm.size()));
    if (is_new) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (const auto& [corner, weight] : name) {
        if (corner >= 0) sum += weight * base.corner[static_cast<std::size_t>(corner)];
      }
      const Eigen::Vector3d unit = sum.normalized();
      vertices_mm.push_back(unit.cwiseProduct(half_axes_mm));
      normal.push_back(unit.cwiseQuotient(half_axes_mm).normalized());
    }
    return found->second;
  };
  for (const Face& face : base.faces) {
    for (int a = 0; a < n_edges; ++a) {
      for (int b = 0; a + b < n_edges; ++b) {
        faces.push_back({point(face, a, b), point(face, a + 1, b), point(face, a, b + 1)});
        if (a + b + 1 == n_edges) continue;
        faces.push_back({point(face, a + 1, b), point(face, a + 1, b + 1), point(face, a, b + 1)});
      }
    }
  }
  Mesh mesh = assembled(vertices_mm, faces);
  mesh.normals = assembled(normal, {}).vertices_mm;
  return mesh;
}

}  // namespace vrda::geometry

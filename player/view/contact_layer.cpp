// Layer of the contact points, with forces as lengths of arrows.
#include "view/layers.hpp"

#include <algorithm>

#include "model/step_record.hpp"
#include "core/units.hpp"
#include "view/joint_layers.hpp"
#include "view/scene.hpp"
#include "view/solids.hpp"

namespace vrda::view {
namespace {

// Sizes for a knee, mm: visible between condyle and plateau without hiding either.
constexpr double ball_radius_mm = 1.3, normal_radius_mm = 0.55;
constexpr double longest_arrow_mm = 26.0, shortest_arrow_mm = 3.0;
constexpr VertexColour ball_colour{226, 74, 28, 255}, arrow_colour{38, 132, 62, 255};

std::vector<double> radians(const std::vector<double>& deg)
{
  std::vector<double> rad;
  rad.reserve(deg.size());
  for (const double angle : deg) rad.push_back(rad_from_deg(angle));
  return rad;
}

std::size_t nearest(const std::vector<double>& axis, double value)
{
  const auto after = std::lower_bound(axis.begin(), axis.end(), value);
  if (after == axis.begin()) return 0;
  const auto i = static_cast<std::size_t>(after - axis.begin());
  return after == axis.end() || value - axis[i - 1] <= axis[i] - value ? i - 1 : i;
}

std::size_t most_rows(const std::vector<std::size_t>& start)
{
  std::size_t most = 0;
  for (std::size_t cell = 0; cell + 1 < start.size(); ++cell)
    most = std::max(most, start[cell + 1] - start[cell]);
  return most;
}

/// Contact force of a row, N: its component along Delta divided by the normal's.
double force_n(const store::ForceRows& rows, std::size_t row, const Eigen::Vector3d& delta)
{
  const double opposing = -rows.normal_world.row(static_cast<Eigen::Index>(row)).dot(delta);
  return rows.along_delta_n[row] / std::max(opposing, 1e-3);
}

double highest_force_n(const store::MotionModel& model)
{
  const store::ForceRows& rows = model.equilibrium->forces;
  double highest_n = 0.0;
  for (const std::size_t cell : informative_cells(model)) {
    for (std::int64_t row = rows.row_start[cell]; row < rows.row_start[cell + 1]; ++row)
      highest_n = std::max(highest_n, force_n(rows, static_cast<std::size_t>(row), model.delta));
  }
  return highest_n;
}

}  // namespace

template <typename Rows, typename Length>
ContactLayer::Markers ContactLayer::markers_of(const store::MotionModel& model, const Rows& rows,
                                               const Length& length_mm)
{
  const store::Motion raw(model, "raw");
  Markers markers;
  markers.start.push_back(0);
  const std::size_t n_cells = rows.row_start.empty() ? 0 : rows.row_start.size() - 1;
  for (std::size_t cell = 0; cell < n_cells; ++cell) {
    const bool is_solved = model.status.data()[cell] == status_stable;
    const auto i = static_cast<std::size_t>(cell / model.varus_deg.size());
    const auto first = static_cast<std::size_t>(rows.row_start[cell]),
               last = static_cast<std::size_t>(rows.row_start[cell + 1]);
    if (is_solved && first < last) {
      const store::JointPose pose =
          raw.is_sequence()
              ? raw.at_frame(raw.keys()[i])
              : raw.joint_pose(
                    {rad_from_deg(model.flexion_deg[i]), rad_from_deg(model.varus_solved_deg.data()[cell])},
                    {model.tx_mm.data()[cell], model.ty_mm.data()[cell], model.tz_mm.data()[cell],
                     rad_from_deg(model.theta_deg.data()[cell])});
      const Pose X_moving_world = pose.X_world_moving.inverse();
      for (std::size_t row = first; row < last; ++row) {
        const auto k = static_cast<Eigen::Index>(row);
        markers.tip_mm.emplace_back(X_moving_world * Eigen::Vector3d(rows.point_world_mm.row(k).transpose()) -
                                    model.rotation_centre_mm);
        markers.arrow_mm.emplace_back(
            length_mm(row) *
            (X_moving_world.linear() * Eigen::Vector3d(rows.normal_world.row(k).transpose())));
      }
    }
    markers.start.push_back(markers.tip_mm.size());
  }
  return markers;
}

ContactLayer::ContactLayer(const store::MotionModel& model, Scene& scene)
    : flexion_rad_(radians(model.flexion_deg)),
      varus_rad_(radians(model.varus_deg)),
      scale_(marker_scale(model)),
      points_(markers_of(model, model.contacts, [&](std::size_t) { return scale_ * plain_arrow_mm; }))
{
  if (model.frames) keys_ = model.frames->key;
  if (model.equilibrium) {
    const double highest_n = highest_force_n(model);
    arrows_ = markers_of(model, model.equilibrium->forces, [&](std::size_t row) {
      const double part = force_n(model.equilibrium->forces, row, model.delta) / highest_n;
      return scale_ * std::clamp(part * longest_arrow_mm, shortest_arrow_mm, longest_arrow_mm);
    });
  } else {
    arrows_ = points_;
  }
  points_.drawn.emplace(scene, Layer::contacts, ParentFrame::moving, "contacts", model.rotation_centre_mm);
  arrows_.drawn.emplace(scene, Layer::normals, ParentFrame::moving,
                        model.equilibrium ? "contact forces" : "contact normals", model.rotation_centre_mm);
  for (Markers* markers : {&points_, &arrows_}) markers->drawn->reserve(scene, most_rows(markers->start));
}

std::size_t ContactLayer::nearest_cell(const store::JointPose& pose) const
{
  if (!keys_.empty()) return nearest(keys_, pose.key);
  const Attitude& attitude = pose.attitude;
  return nearest(flexion_rad_, attitude.flexion_rad) * varus_rad_.size() +
         nearest(varus_rad_, attitude.varus_rad);
}

void ContactLayer::update(Scene& scene, const store::JointPose& pose, const LayerSet& wanted)
{
  const std::size_t cell = nearest_cell(pose);
  for (Markers* markers : {&points_, &arrows_}) {
    if (!wanted.has(markers == &points_ ? Layer::contacts : Layer::normals)) continue;
    const bool is_row = cell + 1 < markers->start.size();
    const std::size_t first = is_row ? markers->start[cell] : 0;
    const std::size_t n = is_row ? markers->start[cell + 1] - first : 0;
    markers->drawn->show(scene, n > 0);
    if (n == 0 || markers->cell == cell) continue;
    markers->cell = cell;
    markers->drawn->place(scene, std::span(markers->tip_mm).subspan(first, n),
                          std::span(markers->arrow_mm).subspan(first, n), scale_);
  }
}

ContactMarkers::ContactMarkers(Scene& scene, Layer layer, ParentFrame parent, const std::string& name,
                               const Eigen::Vector3d& origin_mm)
    : is_arrows_(layer == Layer::normals), drawable_(add_layer(scene, layer, parent, name))
{
  scene.drawables[drawable_].origin_mm = origin_mm;
  scene.drawables[drawable_].material = marker_material(is_arrows_ ? arrow_colour : ball_colour);
}

void ContactMarkers::reserve(Scene& scene, std::size_t n_contacts)
{
  RenderMesh& mesh = scene.drawables[drawable_].mesh;
  mesh = {};
  is_arrows_ ? add_arrows(mesh, n_contacts) : add_balls(mesh, n_contacts);
  capacity_ = n_contacts;
  triangles_ = mesh.triangles;
}

void ContactMarkers::show(Scene& scene, bool is_shown) const
{
  scene.drawables[drawable_].is_shown = is_shown;
}

void ContactMarkers::place(Scene& scene, std::span<const Eigen::Vector3d> tip_mm,
                           std::span<const Eigen::Vector3d> arrow_vector_mm, double scale)
{
  Drawable& drawable = scene.drawables[drawable_];
  const SolidSize size = is_arrows_ ? arrow_size() : ball_size();
  for (std::size_t k = 0; k < tip_mm.size(); ++k) {
    if (is_arrows_) {
      set_arrow(drawable.mesh, k * size.n_vertices, tip_mm[k] - arrow_vector_mm[k], tip_mm[k],
                scale * normal_radius_mm);
    } else {
      set_ball(drawable.mesh, k * size.n_vertices, tip_mm[k], scale * ball_radius_mm);
    }
  }
  const auto n_indices = static_cast<std::ptrdiff_t>(tip_mm.size() * size.n_indices);
  std::copy_n(triangles_.begin(), n_indices, drawable.mesh.triangles.begin());
  std::fill(drawable.mesh.triangles.begin() + n_indices, drawable.mesh.triangles.end(), 0U);
  update_box(drawable);
  ++drawable.revision;
}

}  // namespace vrda::view

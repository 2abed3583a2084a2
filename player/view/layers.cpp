// Each layer adds its drawables to the scene once, then updates poses or vertices per frame without
// allocating. Meshes are in mm; poses take canonical vertices to the scene's frame.
#include "view/layers.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "core/text.hpp"
#include "core/units.hpp"
#include "geometry/laid_path.hpp"
#include "geometry/placement.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"
#include "model/ligaments.hpp"
#include "model/step_record.hpp"
#include "store/motion.hpp"
#include "view/structures.hpp"

namespace vrda::view {

// The balls or the arrows of contacts.

namespace {

// Sizes for a knee, mm: visible between condyle and plateau without hiding either.
constexpr double ball_radius_mm = 1.3, normal_radius_mm = 0.55;
constexpr double longest_arrow_mm = 26.0, shortest_arrow_mm = 3.0;
constexpr VertexColour ball_colour{226, 74, 28, 255}, arrow_colour{38, 132, 62, 255};

}  // namespace

ContactMarkers::ContactMarkers(Scene& scene, Layer layer, BodyIndex parent, const std::string& name,
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

namespace {

/// One layer: drawables at the poses of a joint.
class LayerDrawing {
 public:
  virtual ~LayerDrawing() = default;
  /// Without data for it in the model.
  virtual bool is_empty() const { return false; }
  /// Shows the layer, whose drawables are hidden, at a solved pose. Allocates nothing.
  virtual void update(Scene& scene, const store::Motion& motion, const DisplayedPose& shown) = 0;
  /// Of its colours; null if they have no scale.
  virtual const Legend* legend() const { return nullptr; }
};

/// Remembers a pose, so that what depends on it alone is computed once.
class LastPose {
 public:
  /// True if `X_reference_moving` is not that of the last call.
  bool takes(const Pose& X_reference_moving)
  {
    const bool is_same = is_made_ && X_reference_moving_.matrix() == X_reference_moving.matrix();
    X_reference_moving_ = X_reference_moving;
    is_made_ = true;
    return !is_same;
  }

 private:
  Pose X_reference_moving_ = Pose::Identity();
  bool is_made_ = false;
};

/// Appends a drawable of a body, whose mesh is relative to the rotation centre; returns its index.
std::size_t add_layer(Scene& scene, Layer layer, BodyIndex parent, const std::string& name,
                      const store::MotionModel& model)
{
  const std::size_t index = add_layer(scene, layer, parent, name);
  scene.drawables[index].origin_mm = model.rotation_centre_mm;
  return index;
}

// Axes.

// Sizes for a knee, mm: rods are longer than its width, so that their ends protrude from the bones.
constexpr double half_rod_mm = 62.0, arrow_mm = 48.0, delta_from_mm = -75.0, delta_to_mm = -40.0;
constexpr double rod_radius_mm = 0.8, arrow_radius_mm = 0.9, helical_radius_mm = 1.1;

struct Axis {
  const char* name;
  VertexColour colour;
};
enum AxisRow : std::size_t { anterior, proximal, right, flexion, varus, push, helical };
constexpr std::array<Axis, 7> axes{{{"anterior", {205, 52, 44, 255}},
                                    {"proximal", {62, 152, 66, 255}},
                                    {"right", {52, 92, 198, 255}},
                                    {"flexion axis", {238, 158, 32, 255}},
                                    {"varus axis", {178, 72, 178, 255}},
                                    {"Delta", {245, 245, 240, 255}},
                                    {"helical axis", {32, 186, 196, 255}}}};

/// Builds a rod through the origin, or an arrow, along +Y.
void set_mesh(Drawable& drawable, AxisRow row, double scale)
{
  const Eigen::Vector3d up = Eigen::Vector3d::UnitY();
  RenderMesh& mesh = drawable.mesh;
  if (row == flexion || row == varus || row == helical) {
    add_rods(mesh, 1);
    const double radius_mm = row == helical ? helical_radius_mm : rod_radius_mm;
    set_rod(mesh, 0, -scale * half_rod_mm * up, scale * half_rod_mm * up, scale * radius_mm);
  } else {
    add_arrows(mesh, 1);
    const double from_mm = row == push ? delta_from_mm : 0.0, to_mm = row == push ? delta_to_mm : arrow_mm;
    set_arrow(mesh, 0, scale * from_mm * up, scale * to_mm * up, scale * arrow_radius_mm);
  }
  update_box(drawable);
}

std::size_t add_axis(const store::MotionModel& model, Scene& scene, AxisRow row)
{
  const Layer layer = row == helical ? Layer::helical_axis : Layer::axes;
  const std::size_t index = add_layer(scene, layer, BodyIndex::world, axes[row].name);
  Drawable& drawable = scene.drawables[index];
  drawable.material = marker_material(axes[row].colour);
  set_mesh(drawable, row, marker_scale(model));
  return index;
}

/// Pose of a mesh along +Y through a world point along a world direction; the rotation about its axis is
/// arbitrary.
Pose aligned(const Eigen::Vector3d& through_world_mm, const Eigen::Vector3d& along_world)
{
  Pose X = Pose::Identity();
  X.linear() = shortest_rotation(Eigen::Vector3d::UnitY(), along_world.normalized());
  X.translation() = through_world_mm;
  return X;
}

/// The reference's canonical axes as arrows from the rotation centre, the flexion and varus axes as rods
/// through it, and Delta as an arrow towards it.
class AxesLayer final : public LayerDrawing {
 public:
  AxesLayer(const store::MotionModel& model, Scene& scene)
      : side_(side_named(model.side)),
        rotation_centre_mm_(model.rotation_centre_mm),
        first_drawable_(scene.drawables.size())
  {
    for (const AxisRow row : {anterior, proximal, right, flexion, varus, push}) add_axis(model, scene, row);
  }

  /// Updates the poses; the meshes are constant.
  void update(Scene& scene, const store::Motion& motion, const DisplayedPose& shown) override
  {
    const Pose& X_world_reference = shown.frames.X_world_reference;
    const Eigen::Vector3d centre_mm = X_world_reference * rotation_centre_mm_;
    const Eigen::Vector3d delta = motion.delta_of(shown.pose);
    // Flexion axis: Z of the solver frame rotated by the varus; varus axis: X of the solver frame.
    const SolverFrame frame{side_, rotation_centre_mm_, delta};
    const Eigen::Matrix3d R_world_push = shown.frames.X_world_push.linear();
    const auto on_screen = [&](const Eigen::Vector3d& v_solver) {
      return Eigen::Vector3d(R_world_push * world_from_solver(frame, v_solver));
    };
    std::array<Eigen::Vector3d, 6> along;
    for (const AxisRow row : {anterior, proximal, right})
      along[row] = X_world_reference.linear() * Eigen::Vector3d::Unit(static_cast<Eigen::Index>(row));
    along[flexion] = on_screen(rotation_x(-shown.pose.attitude.varus_rad) * Eigen::Vector3d::UnitZ());
    along[varus] = on_screen(Eigen::Vector3d::UnitX());
    along[push] = R_world_push * delta;
    for (std::size_t row = 0; row < along.size(); ++row) {
      Drawable& drawable = scene.drawables[first_drawable_ + row];
      drawable.is_shown = true;
      drawable.X_world_mesh = aligned(centre_mm, along[row]);
    }
  }

 private:
  Side side_ = Side::right;
  Eigen::Vector3d rotation_centre_mm_;
  std::size_t first_drawable_ = 0;
};

/// The helical axis of the moving body relative to the reference from 1 degree of flexion before to 1 degree
/// after, at constant varus, or of a sequence from one frame before to one after: a rod through the axis
/// point nearest to the rotation centre.
class HelicalAxisLayer final : public LayerDrawing {
 public:
  HelicalAxisLayer(const store::MotionModel& model, Scene& scene)
      : rotation_centre_mm_(model.rotation_centre_mm),
        is_empty_(model.flexion_deg.size() < 2),
        drawable_(add_axis(model, scene, helical))
  {
  }
  bool is_empty() const override { return is_empty_; }

  void update(Scene& scene, const store::Motion& motion, const DisplayedPose& shown) override
  {
    const auto [before, after] = poses_around(motion, shown.pose);
    if (before.status != store::PoseStatus::solved || after.status != store::PoseStatus::solved) return;
    const std::optional<HelicalAxis> axis =
        helical_axis(before.X_reference_moving, after.X_reference_moving, rotation_centre_mm_);
    if (!axis) return;
    Drawable& drawable = scene.drawables[drawable_];
    drawable.is_shown = true;
    const Pose& X_world_reference = shown.frames.X_world_reference;
    drawable.X_world_mesh =
        aligned(X_world_reference * axis->point_mm, X_world_reference.linear() * axis->direction);
  }

 private:
  static std::pair<store::JointPose, store::JointPose> poses_around(const store::Motion& motion,
                                                                    const store::JointPose& pose)
  {
    if (motion.is_sequence()) {
      const double position = motion.position_of(pose.key);
      return {motion.at_frame(motion.key_at(position - 1.0)), motion.at_frame(motion.key_at(position + 1.0))};
    }
    constexpr double step_rad = rad_from_deg(1.0);
    const double first_rad = std::max(pose.attitude.flexion_rad - step_rad, motion.first_flexion_rad());
    const double last_rad = std::min(pose.attitude.flexion_rad + step_rad, motion.last_flexion_rad());
    return {motion.at({first_rad, pose.attitude.varus_rad}), motion.at({last_rad, pose.attitude.varus_rad})};
  }

  Eigen::Vector3d rotation_centre_mm_;
  bool is_empty_ = false;
  std::size_t drawable_ = 0;
};

// The band of an uncertain job.

constexpr float copy_opacity = 0.5F;  // two overlapping outlines remain distinct
// The object covers the copies, which show beyond its outline: their intersections would show as patches.
constexpr double copy_depth_offset_mm = 10.0;

struct BandEnd {
  const char* set;
  VertexColour colour;
};
constexpr BandEnd band_ends[] = {{"quantile_5", {70, 130, 220, 255}},
                                 {"quantile_95", {235, 135, 50, 255}},
                                 {store::bones_alone_name, {150, 150, 150, 255}}};

/// Translucent copies of the moving object's contact parts at the poses of the samples at 5 and 95 % and of
/// the motion without the prior.
class BandLayer final : public LayerDrawing {
 public:
  BandLayer(const store::MotionModel& model, Scene& scene)
  {
    const std::vector<std::string> names = store::all_set_names(model);
    for (const BandEnd& end : band_ends) {
      if (std::find(names.begin(), names.end(), end.set) == names.end()) continue;
      QuantileCopy copies{store::Motion(model, end.set), {}};
      const std::size_t n_bodies = scene.drawables.size();
      for (std::size_t k = 0; k < n_bodies; ++k) {
        const Drawable& body = scene.drawables[k];
        if (body.layer != Layer::bodies || body.parent != BodyIndex::moving || !body.has_contact) continue;
        Drawable copy = body;
        copy.structure.clear();
        copy.name += ", " + std::string(end.set);
        copy.layer = Layer::band;
        copy.parent = BodyIndex::world;
        copy.is_shown = false;
        copy.material = marker_material(end.colour);
        copy.material.opacity = copy_opacity;
        copy.depth_offset_mm = copy_depth_offset_mm;
        copies.drawables.push_back(scene.drawables.size());
        scene.drawables.push_back(std::move(copy));
      }
      copies_.push_back(std::move(copies));
    }
  }
  bool is_empty() const override { return copies_.empty(); }

  void update(Scene& scene, const store::Motion& /*motion*/, const DisplayedPose& shown) override
  {
    for (const QuantileCopy& copies : copies_) {
      const store::JointPose pose = copies.motion.at(shown.pose.attitude);
      if (pose.status != store::PoseStatus::solved) continue;
      const Pose X_world_moving = shown.frames.X_world_reference * pose.X_reference_moving;
      for (const std::size_t k : copies.drawables) {
        scene.drawables[k].is_shown = true;
        place(scene.drawables[k], X_world_moving);
      }
    }
  }

 private:
  struct QuantileCopy {
    store::Motion motion;
    std::vector<std::size_t> drawables;
  };
  std::vector<QuantileCopy> copies_;
};

// Contacts.

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

/// Balls or arrows in compressed rows: those of cell c are [start[c], start[c + 1]).
struct MarkerRows {
  std::vector<std::size_t> start;
  std::vector<Eigen::Vector3d> tip_mm;    ///< moving body, from the rotation centre
  std::vector<Eigen::Vector3d> arrow_mm;  ///< from tail to tip
};

template <typename Rows, typename Length>
MarkerRows marker_rows(const store::MotionModel& model, const Rows& rows, const Length& length_mm)
{
  const store::Motion raw(model, "raw");
  MarkerRows markers;
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

/// Contact points with arrows along their normals.
MarkerRows contact_rows(const store::MotionModel& model)
{
  const double length_mm = marker_scale(model) * plain_arrow_mm;
  return marker_rows(model, model.contacts, [&](std::size_t) { return length_mm; });
}

/// Arrows as long as the contact forces on the moving object, limited to that of the largest force of the
/// informative cells.
MarkerRows force_rows(const store::MotionModel& model)
{
  const double highest_n = highest_force_n(model), scale = marker_scale(model);
  const store::ForceRows& forces = model.equilibrium->forces;
  return marker_rows(model, forces, [&](std::size_t row) {
    const double part = force_n(forces, row, model.delta) / highest_n;
    return scale * std::clamp(part * longest_arrow_mm, shortest_arrow_mm, longest_arrow_mm);
  });
}

/// The contacts of the nearest grid cell, fixed to the moving object: balls at the contact points (layer
/// contacts), or arrows with their tips there (layer normals).
class ContactLayer final : public LayerDrawing {
 public:
  ContactLayer(const store::MotionModel& model, Scene& scene, Layer layer, MarkerRows rows)
      : flexion_rad_(radians(model.flexion_deg)),
        varus_rad_(radians(model.varus_deg)),
        scale_(marker_scale(model)),
        rows_(std::move(rows)),
        drawn_(scene, layer, BodyIndex::moving,
               layer == Layer::contacts ? "contacts"
               : model.equilibrium      ? "contact forces"
                                        : "contact normals",
               model.rotation_centre_mm)
  {
    if (model.frames) keys_ = model.frames->key;
    drawn_.reserve(scene, most_rows(rows_.start));
  }
  bool is_empty() const override { return rows_.tip_mm.empty(); }

  void update(Scene& scene, const store::Motion& /*motion*/, const DisplayedPose& shown) override
  {
    const std::size_t cell = nearest_cell(shown.pose);
    const bool is_row = cell + 1 < rows_.start.size();
    const std::size_t first = is_row ? rows_.start[cell] : 0;
    const std::size_t n = is_row ? rows_.start[cell + 1] - first : 0;
    drawn_.show(scene, n > 0);
    if (n == 0 || cell_ == cell) return;
    cell_ = cell;
    drawn_.place(scene, std::span(rows_.tip_mm).subspan(first, n),
                 std::span(rows_.arrow_mm).subspan(first, n), scale_);
  }

 private:
  std::size_t nearest_cell(const store::JointPose& pose) const
  {
    if (!keys_.empty()) return nearest(keys_, pose.key);
    const Attitude& attitude = pose.attitude;
    return nearest(flexion_rad_, attitude.flexion_rad) * varus_rad_.size() +
           nearest(varus_rad_, attitude.varus_rad);
  }

  std::vector<double> flexion_rad_, varus_rad_;
  std::vector<double> keys_;  ///< of a sequence of frames
  double scale_ = 1.0;
  MarkerRows rows_;
  ContactMarkers drawn_;
  std::size_t cell_ = SIZE_MAX;  ///< the drawn one
};

// Contact paths: centres of contact over flexion as lines on the surfaces.

// Larger steps between neighbouring flexions are jumps to another facet or horn, not rolling or sliding.
constexpr double longest_step_mm = 4.0;
constexpr double path_radius_mm = 0.7;  // on a knee: half of the line is above the surface
// Colour-blind safe, after Okabe and Ito (2008); those of the page.
constexpr VertexColour medial_colour{11, 106, 168, 255}, lateral_colour{194, 80, 10, 255};

/// One stable cell of each flexion that has one: on the spine, otherwise of the least varus.
std::vector<std::size_t> path_cells(const store::MotionModel& model)
{
  std::vector<std::size_t> cells;
  const std::size_t n_varus = model.varus_deg.size();
  const std::vector<std::size_t> informative = informative_cells(model);
  const auto varus_deg = [&](std::size_t cell) { return std::abs(model.varus_deg[cell % n_varus]); };
  for (const std::size_t cell : informative) {
    const bool is_same_flexion = !cells.empty() && cells.back() / n_varus == cell / n_varus;
    if (!is_same_flexion)
      cells.push_back(cell);
    else if (varus_deg(cell) < varus_deg(cells.back()))
      cells.back() = cell;
  }
  return cells;
}

/// The centres of contact of the cells relative to the origin, split at jumps and at cells without contact.
std::vector<std::vector<Eigen::Vector3d>> pieces_of(const std::vector<double>& centre_mm,
                                                    const std::vector<std::size_t>& cells,
                                                    const Eigen::Vector3d& origin_mm, double scale)
{
  std::vector<std::vector<Eigen::Vector3d>> pieces;
  bool is_broken = true;
  for (const std::size_t cell : cells) {
    const Eigen::Vector3d p_mm = Eigen::Vector3d::Map(&centre_mm[3 * cell]) - origin_mm;
    const bool is_contact = p_mm.allFinite();
    is_broken = is_broken || !is_contact || (p_mm - pieces.back().back()).norm() > scale * longest_step_mm;
    if (!is_contact) continue;
    if (is_broken) pieces.emplace_back();
    is_broken = false;
    pieces.back().push_back(p_mm);
  }
  std::erase_if(pieces, [](const std::vector<Eigen::Vector3d>& piece) { return piece.size() < 2; });
  return pieces;
}

/// The centres of contact of both compartments over flexion, as lines on the surfaces of both bodies: of the
/// spine's cells, or of the cells with the least varus.
class ContactPathLayer final : public LayerDrawing {
 public:
  ContactPathLayer(const store::MotionModel& model, Scene& scene)
  {
    if (!model.contact_paths) return;
    struct Row {
      const char* name;
      const std::vector<double>& centre_mm;
      BodyIndex parent;
      VertexColour colour;
    };
    const store::ContactPaths& paths = *model.contact_paths;
    const std::vector<std::size_t> cells = path_cells(model);
    const double scale = marker_scale(model);
    for (const Row& row :
         {Row{"medial path, reference", paths[0].reference_mm, BodyIndex::reference, medial_colour},
          Row{"medial path, moving", paths[0].moving_mm, BodyIndex::moving, medial_colour},
          Row{"lateral path, reference", paths[1].reference_mm, BodyIndex::reference, lateral_colour},
          Row{"lateral path, moving", paths[1].moving_mm, BodyIndex::moving, lateral_colour}}) {
      const auto pieces = pieces_of(row.centre_mm, cells, model.rotation_centre_mm, scale);
      if (pieces.empty()) continue;
      drawables_.push_back(add_layer(scene, Layer::contact_paths, row.parent, row.name, model));
      Drawable& drawable = scene.drawables.back();
      drawable.structure = paths_structure;
      drawable.material = marker_material(row.colour);
      for (const std::vector<Eigen::Vector3d>& piece : pieces) {
        const std::size_t first = drawable.mesh.vertices.size();
        add_tube(drawable.mesh, piece.size());
        set_tube(drawable.mesh, first, piece, scale * path_radius_mm);
      }
      update_box(drawable);
    }
  }
  bool is_empty() const override { return drawables_.empty(); }

  void update(Scene& scene, const store::Motion& /*motion*/, const DisplayedPose& /*shown*/) override
  {
    for (const std::size_t k : drawables_) scene.drawables[k].is_shown = true;
  }

 private:
  std::vector<std::size_t> drawables_;
};

// The gap along Delta, as colours on the moving object's upward surface.

constexpr double range_mm = 6.0;    ///< about the height of a meniscus
constexpr double deepest_mm = 3.0;  ///< largest overlap of a smoothed motion; deeper hits are other surfaces
constexpr double above_mm =
    0.05;  ///< for a knee: far above the resolution of the depth buffer, far below visibility
constexpr double least_upward =
    0.3;  ///< smallest component of a face normal along Delta; steeper faces are omitted
constexpr double fades_from = 0.7;  ///< fraction of the range where the colours start to fade into the bone

Legend gap_scale()
{
  Legend legend;
  legend.title = "gap, mm";
  legend.highest = range_mm;
  legend.palette = gap_palette();
  legend.beyond_label = "no colour";
  return legend;
}

Eigen::Vector3d position_mm(const RenderVertex& vertex)
{
  return {vertex.position_mm[0], vertex.position_mm[1], vertex.position_mm[2]};
}

/// The faces oriented along `delta` and their vertices, with the normals of the whole mesh, so that the
/// shading matches the surface below.
RenderMesh upward_part(const RenderMesh& whole, const Eigen::Vector3d& delta)
{
  constexpr std::uint32_t unused = UINT32_MAX;
  RenderMesh part;
  std::vector<std::uint32_t> row(whole.vertices.size(), unused);
  for (std::size_t t = 0; t < whole.triangles.size(); t += 3) {
    const std::uint32_t* corner = &whole.triangles[t];
    const Eigen::Vector3d a = position_mm(whole.vertices[corner[0]]);
    const Eigen::Vector3d area =
        (position_mm(whole.vertices[corner[1]]) - a).cross(position_mm(whole.vertices[corner[2]]) - a);
    if (!(area.dot(delta) > least_upward * area.norm())) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& own = row[corner[k]];
      if (own == unused) {
        own = static_cast<std::uint32_t>(part.vertices.size());
        part.vertices.push_back(whole.vertices[corner[k]]);
      }
      part.triangles.push_back(own);
    }
  }
  return part;
}

/// Sheets slightly above the contact surfaces of the moving object oriented along Delta, coloured by the
/// directional gap from each vertex to the reference; hidden where the gap exceeds the range.
class GapLayer final : public LayerDrawing {
 public:
  GapLayer(const store::MotionModel& model, Scene& scene)
      : legend_(gap_scale()), reference_(model.reference.contact.mesh), tree_(reference_)
  {
    for (std::size_t c = 0; c < model.moving.components.size(); ++c) add_sheet(model, scene, c);
  }
  bool is_empty() const override { return sheets_.empty(); }
  const Legend* legend() const override { return &legend_; }

  void update(Scene& scene, const store::Motion& motion, const DisplayedPose& shown) override
  {
    const bool is_new = last_pose_.takes(shown.pose.X_reference_moving);
    // Theta rotates about Delta, so Delta has the same coordinates in the moving object.
    const Eigen::Vector3d delta_moving = motion.delta_of(shown.pose);
    for (Sheet& sheet : sheets_) {
      Drawable& drawable = scene.drawables[sheet.drawable];
      if (is_new) {
        update_sheet(drawable, sheet, shown.pose.X_reference_moving, delta_moving);
        ++drawable.revision;
      }
      drawable.is_shown = sheet.is_near;
    }
  }

 private:
  struct Sheet {
    std::size_t drawable = 0;
    VertexColour bone{};                    ///< the part's colour, into which the map fades
    std::vector<Eigen::Vector3d> point_mm;  ///< [n_vertices] canonical axes of the moving body
    std::vector<double> gap_mm;             ///< [n_vertices] at the last update; infinite beyond the range
    std::vector<std::uint32_t> triangles;   ///< all triangles of the sheet
    bool is_near = false;                   ///< any vertex was within the range at the last update
  };

  void add_sheet(const store::MotionModel& model, Scene& scene, std::size_t component)
  {
    const Part& contact = model.moving.contact;
    const RenderMesh whole = make_render_mesh(
        contact.mesh, triangles_by_component(model.moving, contact)[component], model.rotation_centre_mm,
        crease_rad_of(model.moving.components[component].material));
    RenderMesh upward = upward_part(whole, model.delta);
    if (upward.triangles.empty()) return;
    const Component& part = model.moving.components[component];
    Sheet sheet;
    sheet.drawable = add_layer(scene, Layer::gap_map, BodyIndex::moving, "gaps on " + part.name, model);
    Drawable& drawable = scene.drawables[sheet.drawable];
    drawable.structure = gap_structure;
    drawable.mesh = std::move(upward);
    drawable.material = material_of(part.material);
    drawable.material.mottling = 0.0F;
    sheet.bone = srgb_from_linear(drawable.material.colour);
    const auto lift_mm = static_cast<float>(above_mm * marker_scale(model));
    for (RenderVertex& vertex : drawable.mesh.vertices) {
      sheet.point_mm.push_back(position_mm(vertex) + drawable.origin_mm);
      for (std::size_t k = 0; k < 3; ++k) vertex.position_mm[k] += lift_mm * vertex.normal[k];
    }
    update_box(drawable);
    drawable.colours.assign(drawable.mesh.vertices.size(), sheet.bone);
    sheet.gap_mm.resize(sheet.point_mm.size());
    sheet.triangles = drawable.mesh.triangles;
    sheets_.push_back(std::move(sheet));
  }

  void update_sheet(Drawable& drawable, Sheet& sheet, const Pose& X_reference_moving,
                    const Eigen::Vector3d& delta_moving) const
  {
    // The rays are transformed to the reference's frame, so that its tree stays valid.
    geometry::Ray ray;
    ray.direction = X_reference_moving.linear() * delta_moving;
    ray.max_length_mm = deepest_mm + range_mm;
    for (std::size_t v = 0; v < sheet.point_mm.size(); ++v) {
      ray.from_mm = X_reference_moving * sheet.point_mm[v] - deepest_mm * ray.direction;
      const double gap_mm = geometry::ray_distance_mm(reference_, tree_, ray) - deepest_mm;
      sheet.gap_mm[v] = gap_mm;
      const double fading = (gap_mm / range_mm - fades_from) / (1.0 - fades_from);
      drawable.colours[v] = interpolated_colour(colour_of(legend_, std::min(gap_mm, range_mm)), sheet.bone,
                                                std::clamp(fading, 0.0, 1.0));
    }
    auto next = drawable.mesh.triangles.begin();
    for (std::size_t t = 0; t < sheet.triangles.size(); t += 3) {
      const auto corner = sheet.triangles.begin() + static_cast<std::ptrdiff_t>(t);
      const bool is_near =
          std::any_of(corner, corner + 3, [&](std::uint32_t v) { return sheet.gap_mm[v] < range_mm; });
      if (is_near) next = std::copy(corner, corner + 3, next);
    }
    sheet.is_near = next != drawable.mesh.triangles.begin();
    // The number of triangles is constant: unused ones are degenerate.
    std::fill(next, drawable.mesh.triangles.end(), 0U);
  }

  Legend legend_;
  Mesh reference_;  ///< contact part
  geometry::BoxTree tree_;
  std::vector<Sheet> sheets_;
  LastPose last_pose_;
};

// Ligament fibres, coloured by strain.

/// Points per fibre: on bone and on a wrap a few degrees of bend per segment.
constexpr std::size_t n_points = 24;
/// Of a path's middle above bone, so that a band's thickness is not in it.
constexpr double above_bone_mm = 0.7;
/// By which a band is wider at its footprints than in its middle.
constexpr double flare = 0.35;
/// A slack fibre is drawn as long as it is, in waves, unless they are higher than this.
constexpr double n_waves = 3.0, highest_wave_mm = 1.5;
// Half sizes of a band on a knee, where fibres lie 2 to 4 mm apart: neighbouring bands overlap a little.
constexpr double thickness_mm = 0.45, narrowest_mm = 1.0, widest_mm = 2.4, band_overlap = 1.2;
constexpr double slack_part = 0.7;  // of width and thickness
constexpr VertexColour slack_colour{205, 203, 196, 255};
// A line of constant tension, a muscle, has no strain.
constexpr VertexColour line_colour{170, 74, 68, 255};

/// The same line by points that are equally far from each other.
void space_evenly(std::array<Eigen::Vector3d, n_points>& path_mm)
{
  const std::array<Eigen::Vector3d, n_points> given_mm = path_mm;
  double length_mm = 0.0;
  for (std::size_t k = 1; k < n_points; ++k) length_mm += (given_mm[k] - given_mm[k - 1]).norm();
  std::size_t next = 1;
  double before_mm = 0.0;  // length up to the point before `next`
  for (std::size_t k = 1; k + 1 < n_points; ++k) {
    const double at_mm = length_mm * static_cast<double>(k) / static_cast<double>(n_points - 1);
    double link_mm = (given_mm[next] - given_mm[next - 1]).norm();
    while (before_mm + link_mm < at_mm && next + 1 < n_points) {
      before_mm += link_mm;
      ++next;
      link_mm = (given_mm[next] - given_mm[next - 1]).norm();
    }
    const double part = link_mm > 0.0 ? (at_mm - before_mm) / link_mm : 0.0;
    path_mm[k] = given_mm[next - 1] + part * (given_mm[next] - given_mm[next - 1]);
  }
}

/// The direction in which the fibres of a bundle lie side by side, as vectors of the reference and of the
/// moving body that correspond, and the mean distance of neighbours. Zero for a single fibre.
struct Arrangement {
  Eigen::Vector3d reference_mm = Eigen::Vector3d::Zero(), moving_mm = Eigen::Vector3d::Zero();
  double spacing_mm = 0.0;
};

/// The first principal component of both attachments together, so that the directions at both ends agree in
/// sign also for a twisted bundle.
Arrangement arrangement_of(const std::vector<model::Fibre>& fibres, const std::string& bundle)
{
  std::vector<const model::Fibre*> own;
  for (const model::Fibre& fibre : fibres) {
    if (fibre.bundle == bundle) own.push_back(&fibre);
  }
  Arrangement found;
  const auto n = static_cast<Eigen::Index>(own.size());
  if (n < 2) return found;
  Eigen::MatrixXd ends_mm(n, 6);
  for (Eigen::Index i = 0; i < n; ++i) {
    const model::Fibre& fibre = *own[static_cast<std::size_t>(i)];
    ends_mm.row(i) << fibre.reference_mm.transpose(), fibre.moving_mm.transpose();
  }
  const Eigen::RowVectorXd mean_mm = ends_mm.colwise().mean();
  ends_mm.rowwise() -= mean_mm;
  const Eigen::MatrixXd covariance = ends_mm.transpose() * ends_mm;
  const Eigen::VectorXd first =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(covariance).eigenvectors().col(5);
  // A fibre's coordinate along the component is the mean of the two ends times the root of 2.
  const Eigen::VectorXd along_mm = ends_mm * first;
  const double width_mm = (along_mm.maxCoeff() - along_mm.minCoeff()) / std::sqrt(2.0);
  found.reference_mm = first.head<3>();
  found.moving_mm = first.tail<3>();
  found.spacing_mm = width_mm / static_cast<double>(n - 1);
  return found;
}

/// Of strains, the same for every model and on the page: taut fibres to 8 %.
Legend strain_legend()
{
  Legend legend;
  legend.title = "strain, %";
  legend.highest = 8.0;
  legend.palette = strain_palette();
  legend.below = slack_colour;
  legend.below_label = "slack";
  legend.beyond = VertexColour{84, 22, 140, 255};
  legend.beyond_label = "more";
  return legend;
}

/// One drawable a bundle: a flat band along each fibre's path, over its wrap and over bone; the width is in
/// the direction in which the bundle's fibres lie side by side. The joint's fibres first, then those of the
/// bodies that follow it.
class LigamentLayer final : public LayerDrawing {
 public:
  LigamentLayer(const store::MotionModel& model, Scene& scene)
  {
    groups_.push_back({store::ligaments_of(model), {}, {}});
    legend_ = strain_legend();
    scale_ = marker_scale(model);
    add_bundles(groups_.back(), model, scene, ligaments_path(""));
    for (const store::FollowerRows* follower : store::in_order(model.followers)) {
      groups_.push_back({store::ligaments_of(*follower), {}, {}});
      add_bundles(groups_.back(), model, scene, ligaments_path(follower->name));
    }
    if (is_empty()) return;
    surfaces_.reserve(2 + model.followers.size());
    surfaces_.emplace_back(model.reference);
    surfaces_.emplace_back(model.moving);
    for (const store::FollowerRows* follower : store::in_order(model.followers))
      surfaces_.emplace_back(follower->body);
    beside_.resize(surfaces_.size());
  }
  bool is_empty() const override
  {
    return std::ranges::all_of(groups_, [](const Group& group) { return group.ligaments.fibres.empty(); });
  }
  const Legend* legend() const override { return &legend_; }

  void update(Scene& scene, const store::Motion& /*motion*/, const DisplayedPose& shown) override
  {
    bool is_new = last_pose_.takes(shown.pose.X_reference_moving);
    for (std::size_t k = 0; k < last_followers_.size(); ++k)
      is_new = last_followers_[k].takes(shown.pose.X_reference_follower[k]) || is_new;
    if (is_new) place_bodies(shown);
    for (const Group& group : groups_) {
      for (const Bundle& bundle : group.bundles) {
        Drawable& drawable = scene.drawables[bundle.drawable];
        drawable.is_shown = true;
        if (!is_new) continue;
        std::size_t vertex = 0;
        for (const std::size_t i : bundle.fibres) vertex = draw(drawable, group, i, shown, vertex);
        update_box(drawable);
        ++drawable.revision;
      }
    }
  }

 private:
  struct Bundle {
    std::size_t drawable = 0;
    std::vector<std::size_t> fibres;
  };
  struct Group {
    model::Ligaments ligaments;
    std::vector<BandSection> bands;  ///< [n_fibres] of taut fibres; each end in its body's frame
    std::vector<Bundle> bundles;
  };

  void add_bundles(Group& group, const store::MotionModel& model, Scene& scene, const std::string& path)
  {
    const std::vector<model::Fibre>& fibres = group.ligaments.fibres;
    for (std::size_t i = 0; i < fibres.size(); ++i) {
      const std::string id = path + "/" + fibres[i].bundle;
      auto bundle = std::ranges::find_if(group.bundles, [&](const Bundle& other) {
        return scene.drawables[other.drawable].structure == id;
      });
      if (bundle == group.bundles.end()) {
        const std::size_t drawable = add_layer(scene, Layer::ligaments, BodyIndex::reference, id, model);
        scene.drawables[drawable].structure = id;
        scene.drawables[drawable].is_solid = true;
        scene.drawables[drawable].material = marker_material({255, 255, 255, 255});
        bundle = group.bundles.insert(group.bundles.end(), Bundle{drawable, {}});
      }
      bundle->fibres.push_back(i);
      Drawable& drawable = scene.drawables[bundle->drawable];
      add_tube(drawable.mesh, n_points);
      drawable.colours.resize(drawable.mesh.vertices.size());
      const Arrangement arrangement = arrangement_of(fibres, fibres[i].bundle);
      const double half_mm =
          std::clamp(0.5 * band_overlap * arrangement.spacing_mm, scale_ * narrowest_mm, scale_ * widest_mm);
      group.bands.push_back(
          {half_mm, scale_ * thickness_mm, arrangement.reference_mm, arrangement.moving_mm, flare});
    }
  }

  void place_bodies(const DisplayedPose& shown)
  {
    n_beside_ = 0;
    for (std::size_t b = 0; b < surfaces_.size(); ++b) {
      const auto body = static_cast<BodyIndex>(b);
      if (shown.frames.has(body)) beside_[n_beside_++] = {&surfaces_[b], shown.pose.X_reference(body)};
    }
  }

  // As a path of the fibre's length would be: its ends stay.
  void wave(std::span<Eigen::Vector3d> path_mm, double strain, const Eigen::Vector3d& across) const
  {
    const Eigen::Vector3d chord_mm = path_mm.back() - path_mm.front();
    const Eigen::Vector3d wanted = chord_mm.cross(across).cross(chord_mm);
    const Eigen::Vector3d aside = wanted.norm() > 0.0 ? wanted.normalized() : chord_mm.unitOrthogonal();
    const double height_mm = std::min(scale_ * highest_wave_mm,
                                      chord_mm.norm() * std::sqrt(-strain / (1.0 + strain)) / (pi * n_waves));
    for (std::size_t k = 0; k < path_mm.size(); ++k) {
      const double part = static_cast<double>(k) / static_cast<double>(path_mm.size() - 1);
      path_mm[k] += height_mm * std::sin(2.0 * pi * n_waves * part) * aside;
    }
  }

  // Returns the vertex after its own.
  std::size_t draw(Drawable& drawable, const Group& group, std::size_t i, const DisplayedPose& shown,
                   std::size_t vertex) const
  {
    const model::Fibre& fibre = group.ligaments.fibres[i];
    // Fibre lengths do not depend on the common frame: that of the first body.
    const Pose X_reference_from = shown.pose.X_reference(fibre.from);
    const model::JointPlacement placement = placement_of(fibre, shown.pose);
    std::array<Eigen::Vector3d, n_points> path_mm;
    const model::SampledFibre path =
        model::sample_fibre_path(fibre, group.ligaments.wraps, placement, path_mm);
    const bool is_line = fibre.tension_n > 0.0;
    const double strain = is_line ? 0.0 : path.length_mm / fibre.slack_length_mm - 1.0;
    // Without a pose of its body a fibre has no width.
    const bool is_placed = shown.frames.has(fibre.to) && shown.frames.has(fibre.from);
    const double part = !is_placed ? 1e-4 : strain < 0.0 ? slack_part : 1.0;
    BandSection band = group.bands[i];
    band.half_width_mm *= part;
    band.half_thickness_mm *= part;
    band.across_first = X_reference_from.linear() * band.across_first;
    band.across_last = X_reference_from.linear() * (placement.R_S_moving * band.across_last);
    for (Eigen::Vector3d& p_mm : path_mm) {
      if (fibre.from != BodyIndex::reference) p_mm = X_reference_from * p_mm;
    }
    if (path.is_wrapped) space_evenly(path_mm);
    if (is_placed) geometry::lay_over(path_mm, std::span(beside_).first(n_beside_), scale_ * above_bone_mm);
    if (is_placed && strain < 0.0) wave(path_mm, strain, band.across_first + band.across_last);
    for (Eigen::Vector3d& p_mm : path_mm) p_mm -= drawable.origin_mm;
    set_band(drawable.mesh, vertex, path_mm, band);
    const auto first = drawable.colours.begin() + static_cast<std::ptrdiff_t>(vertex);
    vertex += tube_size(path_mm.size()).n_vertices;
    std::fill(first, drawable.colours.begin() + static_cast<std::ptrdiff_t>(vertex),
              is_line ? line_colour : colour_of(legend_, 100.0 * strain));
    return vertex;
  }

  std::vector<Group> groups_;
  std::vector<geometry::LazyDistance> surfaces_;  // of the reference, the moving body and those that follow
  std::vector<geometry::BesidePath> beside_;      // of those that have a pose, `n_beside_`
  std::size_t n_beside_ = 0;
  double scale_ = 1.0;
  Legend legend_;
  LastPose last_pose_;
  std::array<LastPose, model::most_followers> last_followers_;
};

}  // namespace

struct JointLayers::Parts {
  std::vector<std::pair<Layer, std::unique_ptr<LayerDrawing>>> all;
};

JointLayers::JointLayers(const store::MotionModel& model, Scene& scene) : parts_(std::make_unique<Parts>())
{
  const auto add = [&](Layer layer, std::unique_ptr<LayerDrawing> drawing) {
    available_.set(layer, !drawing->is_empty());
    parts_->all.emplace_back(layer, std::move(drawing));
  };
  const MarkerRows contacts = contact_rows(model);
  const MarkerRows arrows = model.equilibrium ? force_rows(model) : contacts;
  add(Layer::contacts, std::make_unique<ContactLayer>(model, scene, Layer::contacts, contacts));
  add(Layer::normals, std::make_unique<ContactLayer>(model, scene, Layer::normals, arrows));
  add(Layer::axes, std::make_unique<AxesLayer>(model, scene));
  add(Layer::helical_axis, std::make_unique<HelicalAxisLayer>(model, scene));
  add(Layer::gap_map, std::make_unique<GapLayer>(model, scene));
  add(Layer::ligaments, std::make_unique<LigamentLayer>(model, scene));
  add(Layer::contact_paths, std::make_unique<ContactPathLayer>(model, scene));
  add(Layer::band, std::make_unique<BandLayer>(model, scene));
  available_.set(Layer::normals, available_.has(Layer::contacts));
  available_.set(Layer::labels, true);  // drawn as text
}

JointLayers::~JointLayers() = default;
JointLayers::JointLayers(JointLayers&&) noexcept = default;
JointLayers& JointLayers::operator=(JointLayers&&) noexcept = default;

void JointLayers::update(Scene& scene, const store::Motion& motion, const DisplayedPose& shown)
{
  for (Drawable& drawable : scene.drawables) {
    if (drawable.layer != Layer::bodies) drawable.is_shown = false;
  }
  if (shown.pose.status != store::PoseStatus::solved) return;
  for (const auto& [layer, drawing] : parts_->all) {
    if (shown.layers.has(layer)) drawing->update(scene, motion, shown);
  }
  for (Drawable& drawable : scene.drawables)
    if (drawable.is_hidden) drawable.is_shown = false;
}

const Legend& JointLayers::legend(Layer layer) const
{
  for (const auto& [own, drawing] : parts_->all) {
    if (own == layer && drawing->legend() != nullptr) return *drawing->legend();
  }
  throw InternalError("only gaps and ligaments have a legend");
}

const std::vector<Label>& JointLayers::axis_labels()
{
  static const std::vector<Label> labels = [] {
    std::vector<Label> made;
    made.reserve(axes.size());
    for (const Axis& axis : axes) made.push_back({axis.name, axis.colour});
    return made;
  }();
  return labels;
}

}  // namespace vrda::view

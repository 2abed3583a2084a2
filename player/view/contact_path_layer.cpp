// Layer of the contact paths: centres of contact over flexion as lines on the surfaces.
#include <array>
#include <cmath>

#include "model/step_record.hpp"
#include "view/layers.hpp"
#include "view/solids.hpp"

namespace vrda::view {
namespace {

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

}  // namespace

ContactPathLayer::ContactPathLayer(const store::MotionModel& model, Scene& scene)
{
  if (!model.contact_paths) return;
  struct Row {
    const char* name;
    const std::vector<double>& centre_mm;
    ParentFrame parent;
    VertexColour colour;
  };
  const store::ContactPaths& paths = *model.contact_paths;
  const std::vector<std::size_t> cells = path_cells(model);
  const double scale = marker_scale(model);
  for (const Row& row :
       {Row{"medial path, reference", paths.medial_reference_mm, ParentFrame::reference, medial_colour},
        Row{"medial path, moving", paths.medial_moving_mm, ParentFrame::moving, medial_colour},
        Row{"lateral path, reference", paths.lateral_reference_mm, ParentFrame::reference, lateral_colour},
        Row{"lateral path, moving", paths.lateral_moving_mm, ParentFrame::moving, lateral_colour}}) {
    const auto pieces = pieces_of(row.centre_mm, cells, model.rotation_centre_mm, scale);
    if (pieces.empty()) continue;
    drawables_.push_back(add_layer(scene, Layer::contact_paths, row.parent, row.name));
    Drawable& drawable = scene.drawables.back();
    drawable.origin_mm = model.rotation_centre_mm;
    drawable.material = marker_material(row.colour);
    for (const std::vector<Eigen::Vector3d>& piece : pieces) {
      const std::size_t first = drawable.mesh.vertices.size();
      add_tube(drawable.mesh, piece.size());
      set_tube(drawable.mesh, first, piece, scale * path_radius_mm);
    }
    update_box(drawable);
  }
}

void ContactPathLayer::show(Scene& scene) const
{
  for (const std::size_t k : drawables_) scene.drawables[k].is_shown = true;
}

}  // namespace vrda::view

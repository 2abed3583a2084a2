// Layer of the ligament fibres, coloured by strain.
#include "view/layers.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "store/joint_parts.hpp"
#include "view/scene.hpp"
#include "view/solids.hpp"

namespace vrda::view {
namespace {

/// Points per fibre: four suffice for straight ones; on a wrap 12 points give a few degrees of bend per
/// segment.
constexpr std::size_t n_straight = 4, n_wrapped = 14;
// Half sizes of a band on a knee, where fibres lie 2 to 4 mm apart: neighbouring bands overlap a little.
constexpr double thickness_mm = 0.45, narrowest_mm = 1.0, widest_mm = 2.4, overlap = 1.2;
constexpr double slack_part = 0.7;  // of width and thickness
constexpr VertexColour slack_colour{205, 203, 196, 255};

std::size_t n_points(const model::Fibre& fibre)
{
  return fibre.wrap < 0 ? n_straight : n_wrapped;
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

/// Scale from 0 to the 95 % quantile of positive strains in the informative cells, rounded up to steps of 2
/// %.
Legend legend_of(const store::MotionModel& model, std::size_t n_fibres)
{
  constexpr double step = 0.02, most = 0.95;
  std::vector<double> taut;
  for (const std::size_t cell : informative_cells(model)) {
    for (std::size_t fibre = 0; fibre < n_fibres; ++fibre) {
      const double strain = model.ligaments->strain[cell * n_fibres + fibre];
      if (strain > 0.0) taut.push_back(strain);
    }
  }
  double highest = step;
  if (!taut.empty()) {
    const auto quantile =
        taut.begin() + static_cast<std::ptrdiff_t>(most * static_cast<double>(taut.size() - 1));
    std::nth_element(taut.begin(), quantile, taut.end());
    highest = std::max(step, step * std::ceil(*quantile / step - 1e-9));
  }
  Legend legend;
  legend.title = "strain, %";
  legend.highest = 100.0 * highest;
  legend.palette = strain_palette();
  legend.below = slack_colour;
  legend.below_label = "slack";
  return legend;
}

}  // namespace

LigamentLayer::LigamentLayer(const store::MotionModel& model, Scene& scene)
    : ligaments_(store::ligaments_of(model)),
      legend_(legend_of(model, ligaments_.fibres.size())),
      origin_mm_(model.rotation_centre_mm),
      scale_(marker_scale(model)),
      drawable_(add_layer(scene, Layer::ligaments, ParentFrame::reference, "ligaments")),
      strain_(ligaments_.fibres.size())
{
  Drawable& drawable = scene.drawables[drawable_];
  drawable.origin_mm = origin_mm_;
  drawable.is_solid = true;
  drawable.material = marker_material({255, 255, 255, 255});
  for (const model::Fibre& fibre : ligaments_.fibres) {
    add_tube(drawable.mesh, n_points(fibre));
    const Arrangement arrangement = arrangement_of(ligaments_.fibres, fibre.bundle);
    const double half_mm =
        std::clamp(0.5 * overlap * arrangement.spacing_mm, scale_ * narrowest_mm, scale_ * widest_mm);
    bands_.push_back({half_mm, scale_ * thickness_mm, arrangement.reference_mm, arrangement.moving_mm});
  }
  drawable.colours.resize(drawable.mesh.vertices.size());
}

void LigamentLayer::update(Scene& scene, const store::JointPose& pose)
{
  scene.drawables[drawable_].is_shown = !is_empty();
  if (is_made_ && X_reference_moving_.matrix() == pose.X_reference_moving.matrix()) return;
  X_reference_moving_ = pose.X_reference_moving;
  is_made_ = true;
  Drawable& drawable = scene.drawables[drawable_];
  // Fibre lengths do not depend on the common frame: use the reference's.
  const model::JointPlacement placement{Eigen::Matrix3d::Identity(), pose.X_reference_moving.linear(),
                                           pose.X_reference_moving.translation()};
  std::array<Eigen::Vector3d, n_wrapped> points_mm;
  std::size_t vertex = 0;
  for (std::size_t i = 0; i < ligaments_.fibres.size(); ++i) {
    const model::Fibre& fibre = ligaments_.fibres[i];
    const std::span<Eigen::Vector3d> path_mm(points_mm.data(), n_points(fibre));
    const model::SampledFibre path =
        model::sample_fibre_path(fibre, ligaments_.wraps, placement, path_mm);
    strain_[i] = path.length_mm / fibre.slack_length_mm - 1.0;
    for (Eigen::Vector3d& p_mm : path_mm) p_mm -= origin_mm_;
    BandSection band = bands_[i];
    const double part = strain_[i] < 0.0 ? slack_part : 1.0;
    band.half_width_mm *= part;
    band.half_thickness_mm *= part;
    band.across_last = placement.R_S_moving * band.across_last;
    set_band(drawable.mesh, vertex, path_mm, band);
    const auto first = drawable.colours.begin() + static_cast<std::ptrdiff_t>(vertex);
    vertex += tube_size(path_mm.size()).n_vertices;
    std::fill(first, drawable.colours.begin() + static_cast<std::ptrdiff_t>(vertex),
              colour_of(legend_, 100.0 * strain_[i]));
  }
  update_box(drawable);
  ++drawable.revision;
}

}  // namespace vrda::view

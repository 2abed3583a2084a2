// Thickness of cartilage where a scan shows bones only.
#include "prepare/slack_lengths.hpp"

#include <algorithm>
#include <cmath>

#include "core/units.hpp"
#include "geometry/gap_query.hpp"

namespace vrda::prepare {

double scanned_gap_mm(const geometry::KneeFit& fit, const geometry::KneeSurfaces& subject)
{
  const auto in_tibia_frame = [&](const geometry::BoneSurfaces& surfaces) {
    Mesh mesh = joined(surfaces);
    mesh.vertices_mm *= fit.unit_mm;
    return transformed(mesh, fit.X_scan_tibia.inverse());
  };
  const Mesh femur = in_tibia_frame(subject.femur), tibia = in_tibia_frame(subject.tibia);
  const geometry::GapTree above(femur);
  double sum = 0.0;
  for (const double side : {-1.0, 1.0}) {
    const geometry::GapTree below = plateau_tree(tibia, side);
    sum += below.is_empty() ? nan : geometry::GapQuery(above, below).travel_mm({});
  }
  return std::isfinite(sum) ? 0.5 * sum : nan;
}

double cartilage_in_gap_mm(double gap_mm)
{
  constexpr double least_mm = 1.5, most_mm = 5.0;
  return std::isfinite(gap_mm) ? std::clamp(gap_mm, least_mm, most_mm) : most_mm;
}

}  // namespace vrda::prepare

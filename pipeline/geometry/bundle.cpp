#include "geometry/bundle.hpp"

namespace vrda::geometry {
namespace {

// The nearest point on the surface, by Newton steps along the gradient.
Eigen::Vector3d on_surface(double (*field)(const Eigen::Vector3d&), const Eigen::Vector3d& near_mm)
{
  constexpr int most_steps = 20;
  constexpr double step_mm = 1e-4;
  Eigen::Vector3d p = near_mm;
  for (int i = 0; i < most_steps; ++i) {
    Eigen::Vector3d slope;
    for (Eigen::Index k = 0; k < 3; ++k) {
      const Eigen::Vector3d h = step_mm * Eigen::Vector3d::Unit(k);
      slope[k] = (field(p + h) - field(p - h)) / (2.0 * step_mm);
    }
    p -= field(p) / slope.squaredNorm() * slope;
  }
  return p;
}

}  // namespace

std::vector<ShapeFibre> fibres_of(const std::vector<Bundle>& bundles,
                                  double (*femur_field)(const Eigen::Vector3d&), double clearance_mm)
{
  std::vector<ShapeFibre> fibres;
  for (const Bundle& bundle : bundles) {
    for (int i = 0; i < bundle.n_fibres; ++i) {
      const double t = static_cast<double>(i) / (bundle.n_fibres - 1);
      const Eigen::Vector3d femur_mm =
          on_surface(femur_field, (1.0 - t) * bundle.first_femur_mm + t * bundle.last_femur_mm);
      const Eigen::Vector3d tibia_mm =
          on_surface(bundle.moving_field, (1.0 - t) * bundle.first_tibia_mm + t * bundle.last_tibia_mm);
      const double length_mm = (tibia_mm - femur_mm).norm();
      fibres.push_back({bundle.name + std::to_string(i + 1), bundle.name, femur_mm,
                        tibia_mm - clearance_mm * Eigen::Vector3d::UnitY(),
                        bundle.stiffness_n / bundle.n_fibres, length_mm / (1.0 + bundle.reference_strain)});
    }
  }
  return fibres;
}

}  // namespace vrda::geometry

#include "shapes/knee.hpp"

namespace vrda {
namespace {

// Fibres of a bundle start evenly between two places on the femur and end between two on the tibia (or the
// fibula's head). The places are those of an anatomical subject with the same origin and axes (Lenhart et al.
// 2015, shared by OpenSim-JAM), moved onto this knee's own surfaces.
struct Bundle {
  const char* name;
  int n_fibres;
  double stiffness_n;       // of all its fibres together
  double reference_strain;  // of each in the design pose
  Eigen::Vector3d first_femur_mm, last_femur_mm;
  Eigen::Vector3d first_tibia_mm, last_tibia_mm;
  double (*moving_field)(const Eigen::Vector3d&);
};

// The nearest place on the surface, by Newton's steps along the gradient.
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

std::vector<Bundle> bundles()
{
  return {
      {"ACLam", 3, 4920, -0.06, {-8, -3, 10}, {-10, -1, 11}, {16, -21, -4}, {16, -21, -1}, tibia_field},
      {"ACLpl", 3, 4920, -0.02, {-10, -6, 10}, {-13, -5, 11}, {12, -21, 0}, {12, -21, 4}, tibia_field},
      {"PCLal", 3, 4500, -0.02, {-2, -10, -10}, {0, -12, -10}, {-14, -27, 1}, {-14, -27, 5}, tibia_field},
      {"PCLpm", 3, 1500, -0.09, {-6, -10, -10}, {-5, -13, -10}, {-15, -31, -5}, {-15, -31, 0}, tibia_field},
      {"MCLs", 4, 3000, 0.039, {-1, 12, -40}, {5, 12, -40}, {5, -66, -17}, {14, -64, -15}, tibia_field},
      {"MCLd", 3, 2500, 0.016, {-1, 3, -42}, {3, 3, -42}, {0, -32, -34}, {6, -32, -34}, tibia_field},
      {"MCLp", 3, 2500, 0.030, {-8, -6, -40}, {-5, -6, -40}, {-16, -34, -26}, {-12, -34, -30}, tibia_field},
      {"LCL", 4, 2400, 0.060, {-2, 3, 41}, {0, 6, 41}, {-15, -50, 45}, {-11, -52, 46}, fibula_field},
  };
}

}  // namespace

const char* const knee_fibre_sources =
    "# Ligaments of the generic knee, canonical axes in mm: X anterior, Y proximal, Z to the subject's "
    "right\n"
    "# Stiffness and reference strain of each bundle: Lenhart et al. 2015, Ann Biomed Eng 43:2675-2685\n"
    "# (OpenSim-JAM lenhart2015.osim). Stiffness agrees with the bundles of Blankevoort et al. 1991,\n"
    "# J Biomech 24:1019-1031, within a third but for the posterior cruciate.\n";

std::vector<ShapeFibre> right_knee_fibres()
{
  std::vector<ShapeFibre> fibres;
  for (const Bundle& bundle : bundles()) {
    for (int i = 0; i < bundle.n_fibres; ++i) {
      const double t = static_cast<double>(i) / (bundle.n_fibres - 1);
      const Eigen::Vector3d femur_mm =
          on_surface(femur_field, (1.0 - t) * bundle.first_femur_mm + t * bundle.last_femur_mm);
      const Eigen::Vector3d tibia_mm =
          on_surface(bundle.moving_field, (1.0 - t) * bundle.first_tibia_mm + t * bundle.last_tibia_mm);
      const double length_mm = (tibia_mm - femur_mm).norm();
      fibres.push_back({bundle.name + std::to_string(i + 1), bundle.name, femur_mm,
                        tibia_mm - apart_mm() * Eigen::Vector3d::UnitY(),
                        bundle.stiffness_n / bundle.n_fibres, length_mm / (1.0 + bundle.reference_strain)});
    }
  }
  return fibres;
}

}  // namespace vrda

/// A ball with a cylindrical neck along -Y in a cup with a plane rim: its range of motion has a closed form.
#pragma once

#include "analysis/range_of_motion.hpp"
#include "core/units.hpp"

namespace vrda::test::cup {

inline constexpr double ball_mm = 24.0, cup_mm = 24.5, wall_mm = 6.0, neck_mm = 8.0;
inline constexpr double depth_mm = 2.0;  ///< of the rim below the centre
inline constexpr double step_rad = rad_from_deg(4.0);

using Profile = std::vector<Eigen::Vector2d>;  ///< (radius, y) from the axis to the axis
void add_arc(Profile& profile, double radius_mm, double from_rad, double to_rad);
/// The surface of revolution about Y, with outward normals if it is closed.
Mesh revolved(const Profile& profile);

/// The inside of a cup alone: a sheet whose border is above the centre, where it still faces down.
inline constexpr double sheet_depth_mm = -3.0;
Mesh cup_sheet();

void set_body(Body& body, const std::string& name, const Mesh& mesh);
job::Case ball_in_cup();

/// From -to_deg to to_deg at most.
std::vector<double> angles_rad(double to_deg, double spacing_rad = step_rad);
/// Flexion and varus, with limits of little more than the facets' height, so that the neck cannot lift the
/// ball.
analysis::RomPlan cup_plan(int n_threads, double spacing_rad);

}  // namespace vrda::test::cup

// Prints poses of every set of a motion model as JSON, computed by the player's library.
// usage: print_poses FILE, with attitudes on standard input: flexion and varus in degrees
#include <exception>
#include <iostream>
#include <limits>

#include "core/units.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"

namespace {

void print_matrix(const vrda::Pose& X)
{
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column)
      std::cout << (row + column > 0 ? "," : "[") << X.matrix()(row, column);
  }
  std::cout << "]";
}

// `followers`: by their BodyIndex from 2, null without a pose.
void print(const vrda::store::JointPose& pose, const vrda::Attitude& requested_deg, std::size_t n_followers)
{
  std::cout << std::boolalpha << R"({"flexion":)" << requested_deg.flexion_rad << R"(,"varus":)"
            << requested_deg.varus_rad << R"(,"is_solved":)"
            << (pose.status == vrda::store::PoseStatus::solved) << R"(,"is_flexion_clamped":)"
            << pose.is_flexion_clamped << R"(,"is_varus_clamped":)" << pose.is_varus_clamped
            << R"(,"theta_rad":)" << pose.theta_rad << R"(,"X":)";
  print_matrix(pose.X_reference_moving);
  std::cout << R"(,"followers":[)";
  for (std::size_t k = 0; k < n_followers; ++k) {
    if (k > 0) std::cout << ",";
    if (pose.has_follower[k]) {
      print_matrix(pose.X_reference_follower[k]);
    } else {
      std::cout << "null";
    }
  }
  std::cout << "]}";
}

}  // namespace

int main(int argc, char** argv)
{
  try {
    const vrda::store::MotionModel model = vrda::store::read_motion_model(argc > 1 ? argv[1] : "");
    std::vector<vrda::Attitude> requested_deg;
    for (vrda::Attitude a; std::cin >> a.flexion_rad >> a.varus_rad;) requested_deg.push_back(a);
    std::cout.precision(std::numeric_limits<double>::max_digits10);
    const char* before = "{\"";
    for (const std::string& set : vrda::store::all_set_names(model)) {
      const vrda::store::Motion motion(model, set);
      std::cout << before << set << "\":";
      before = "],\n\"";
      const char* opening = "[";
      for (const vrda::Attitude& a : requested_deg) {
        std::cout << opening;
        opening = ",\n";
        print(motion.at({vrda::rad_from_deg(a.flexion_rad), vrda::rad_from_deg(a.varus_rad)}), a,
              model.followers.size());
      }
    }
    std::cout << "]}\n";
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "print_poses: " << error.what() << "\n";
    return 2;
  }
}

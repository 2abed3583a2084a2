// Prints poses of every set of a motion model at seeded attitudes as JSON, computed by the player's library.
// usage: print_poses FILE COUNT SEED
#include <cstdint>
#include <exception>
#include <iostream>
#include <limits>
#include <string>

#include "core/units.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"

namespace {

/// 64-bit linear congruential generator of Numerical Recipes; its upper bits suffice to scatter attitudes.
class Seeded {
 public:
  explicit Seeded(std::uint64_t seed) : state_(seed) {}
  /// On [0, 1).
  double next()
  {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(state_ >> 11U) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

/// One third nodes, one third between nodes, one third from a range 1.5 times as wide.
double angle_deg(const std::vector<double>& axis_deg, int k, Seeded& seeded)
{
  const double first = axis_deg.front(), last = axis_deg.back(), share = seeded.next();
  if (k % 3 == 0) return axis_deg[static_cast<std::size_t>(share * static_cast<double>(axis_deg.size()))];
  if (k % 3 == 1) return first + share * (last - first);
  const double margin = 0.25 * (last - first) + 1.0;
  return first - margin + share * (last - first + 2.0 * margin);
}

void print(const vrda::store::JointPose& pose, const vrda::Attitude& requested_deg)
{
  std::cout << R"({"flexion":)" << requested_deg.flexion_rad << R"(,"varus":)" << requested_deg.varus_rad
            << R"(,"is_solved":)" << (pose.status == vrda::store::PoseStatus::solved ? "true" : "false")
            << R"(,"is_flexion_clamped":)" << (pose.is_flexion_clamped ? "true" : "false")
            << R"(,"is_varus_clamped":)" << (pose.is_varus_clamped ? "true" : "false") << R"(,"theta_rad":)"
            << pose.theta_rad << R"(,"X":[)";
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column)
      std::cout << (row + column > 0 ? "," : "") << pose.X_reference_moving.matrix()(row, column);
  }
  std::cout << "]}";
}

void print_set(const vrda::store::MotionModel& model, const std::string& set, int count, std::uint64_t seed)
{
  const vrda::store::Motion motion(model, set);
  Seeded seeded(seed);
  for (int k = 0; k < count; ++k) {
    // Kept in degrees, so that both implementations get the same numbers.
    const double flexion_deg = angle_deg(model.flexion_deg, k, seeded);
    const double varus_deg = angle_deg(model.varus_deg, k, seeded);
    if (k > 0) std::cout << ",\n";
    print(motion.at({vrda::rad_from_deg(flexion_deg), vrda::rad_from_deg(varus_deg)}),
          {flexion_deg, varus_deg});
  }
}

void print_model(const std::string& file, int count, std::uint64_t seed)
{
  const vrda::store::MotionModel model = vrda::store::read_motion_model(file);
  std::cout.precision(std::numeric_limits<double>::max_digits10);
  std::cout << "{";
  bool is_first = true;
  for (const std::string& set : vrda::store::all_set_names(model)) {
    std::cout << (is_first ? "" : ",\n") << '"' << set << "\":[";
    print_set(model, set, count, seed);
    std::cout << "]";
    is_first = false;
  }
  std::cout << "}\n";
}

}  // namespace

int main(int argc, char** argv)
{
  if (argc != 4) {
    std::cerr << "usage: print_poses FILE COUNT SEED\n";
    return 2;
  }
  try {
    print_model(argv[1], std::stoi(argv[2]), std::stoull(argv[3]));
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "print_poses: " << error.what() << "\n";
    return 2;
  }
}

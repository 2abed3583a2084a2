#include "model/joint_kind.hpp"

#include <algorithm>

#include "core/error.hpp"

namespace vrda::inline model {
namespace {

constexpr CoordinateWords anterior{"anterior", "posterior"};
constexpr CoordinateWords proximal{"proximal", "distal"};
constexpr CoordinateWords lateral{"lateral", "medial"};
constexpr CoordinateWords internal{"internal rotation", "external rotation"};
constexpr CoordinateWords plantarflexion{"plantarflexion", "dorsiflexion"};
constexpr CoordinateWords inversion{"inversion", "eversion"};

constexpr AngleRange any_angle{-360.0, 360.0};

constexpr std::array<JointKind, joint_kind_names.size()> kinds{{
    {"knee",
     {{{"flexion", "extension"}, {"varus", "valgus"}, internal, anterior, proximal, lateral}},
     {-15.0, 145.0},
     {-25.0, 25.0},
     true},
    // The same rotation about Z that bends a knee swings a thigh backwards.
    {"hip",
     {{{"extension", "flexion"}, {"adduction", "abduction"}, internal, anterior, proximal, lateral}},
     {-140.0, 30.0},
     {-60.0, 45.0},
     false},
    {"ankle",
     {{plantarflexion, inversion, internal, anterior, proximal, lateral}},
     {-35.0, 60.0},
     {-40.0, 40.0},
     false},
    {"subtalar",
     {{plantarflexion, inversion, internal, anterior, proximal, lateral}},
     {-30.0, 30.0},
     {-40.0, 40.0},
     false,
     false},
    {"other",
     {{{"flexion", "extension"}, {"varus", "valgus"}, internal, anterior, proximal, lateral}},
     any_angle,
     any_angle,
     false,
     false},
}};

}  // namespace

const JointKind& joint_kind(const std::string& name)
{
  const auto* const found =
      std::find_if(kinds.begin(), kinds.end(), [&](const JointKind& kind) { return kind.name == name; });
  check(found != kinds.end(), "a joint has one of the names of joint_kind_names");
  return *found;
}

bool has_own_words(const JointKind& kind)
{
  return kind.name != std::string("knee") && kind.name != std::string("other");
}

std::string label_of(const JointKind& kind, JointCoordinate coordinate)
{
  const CoordinateWords& words = kind.words.at(static_cast<std::size_t>(coordinate));
  const bool is_plain = coordinate != JointCoordinate::flexion && coordinate != JointCoordinate::varus;
  if (is_plain || !has_own_words(kind)) return words.positive;
  return std::string(words.positive) + " (" + words.negative + " -)";
}

}  // namespace vrda::inline model

/// The kinds of joints that a job may name, and their words for the six coordinates.
///
/// Every kind has the same coordinates with the same signs (schemas/clinical.md); a kind says how they are
/// called. Source: Grood and Suntay (1983) for the knee; Wu et al. (2002), J Biomech 35:543-548, for hip and
/// ankle.
#pragma once

#include <array>
#include <string>

#include "model/joint_coordinates.hpp"

namespace vrda::inline model {

/// A coordinate by the direction that counts positive, and the opposite direction.
struct CoordinateWords {
  const char* positive;
  const char* negative;
};

/// Angles in degrees, from `least` to `most`.
struct AngleRange {
  double least_deg, most_deg;
};

struct JointKind {
  const char* name;  ///< as in jobs and files
  std::array<CoordinateWords, n_joint_coordinates> words;
  /// Healthy joints stay within these (schemas/clinical.md).
  AngleRange usual_flexion, usual_varus;
  bool has_compartments = false;  ///< medial and lateral, where the job names none
  bool has_large_flexion = true;  ///< false: it may turn more about its other axes
};

inline constexpr std::array<const char*, 5> joint_kind_names{"knee", "hip", "ankle", "subtalar", "other"};

/// `name` is one of joint_kind_names.
const JointKind& joint_kind(const std::string& name);

/// Whether it calls the rotations otherwise than their keys: all but knee and other.
bool has_own_words(const JointKind& kind);

/// "flexion" and "varus" of a knee, "adduction (abduction -)" of a hip.
std::string label_of(const JointKind& kind, JointCoordinate coordinate);

}  // namespace vrda::inline model

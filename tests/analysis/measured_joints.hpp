/// Real bones and their measured motion; tests that need them are skipped if they are missing.
#pragma once

#include <filesystem>

#include "analysis/repair.hpp"

namespace vrda::test {

struct MeasuredJoint {
  Mesh reference, moving;
  analysis::MeasuredMotion motion;
};

/// Binary STL, mm, vertices with equal coordinates merged.
Mesh stl_mesh(const std::filesystem::path& file);

/// A folder of shared/data/subtalar: talus, calcaneus and motion.csv with columns T11 to T34 over `frame`.
MeasuredJoint subtalar_joint(const std::filesystem::path& folder);

/// The rows of a table with columns T11 to T34 and the key in the first column; # starts a comment.
analysis::MeasuredMotion motion_table(const std::filesystem::path& file);

}  // namespace vrda::test

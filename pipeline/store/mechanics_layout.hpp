/// The part of a motion model's layout that says what pushes and holds the joint: /push, /contact_paths,
/// /equilibrium and /ligaments (schemas/motion-model.md).
#pragma once

#include "store/layout.hpp"

namespace vrda {

/// Adds what version 1.1 brought; nothing where `shape` is of version 1.0.
void add_mechanics(FileLayout& layout, const FileShape& shape);

}  // namespace vrda

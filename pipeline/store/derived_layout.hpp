/// The part of a motion model's layout that is made of the raw surfaces: smoothed sets, zero-varus motion and
/// audits (DESIGN.md 5.5).
#pragma once

#include "store/layout.hpp"

namespace vrda {

/// The surfaces of a set in the order of the file, by the names of SmoothedSurface: tx, ty, tz, theta, and
/// varus where there is a fifth.
const std::vector<std::string>& smoothed_names(const SmoothedShape& shape);

/// "/smoothed/degree_6".
std::string smoothed_group(std::int32_t degree);

/// "/smoothed/degree_6/tx" of surface "tx". That of "varus" is `varus_solved`, as the raw one: xarray cannot
/// open a `varus` over (flexion, varus).
std::string smoothed_path(std::int32_t degree, const std::string& name);

/// "/smoothed/degree_6/coefficients_tx".
std::string coefficients_path(std::int32_t degree, const std::string& name);

/// Whether an audit may have this name: "raw", "zero_varus", "degree_6" or "degree_6_recontacted".
bool is_audit_name(const std::string& name);

/// "/audit/raw".
std::string audit_group(const std::string& name);

/// Append them to the layout, each in the order of its visit (derived_binding.hpp).
void add_smoothed(FileLayout& layout, const FileShape& shape);
void add_zero_varus(FileLayout& layout, const FileShape& shape);
void add_audits(FileLayout& layout, const FileShape& shape);

}  // namespace vrda

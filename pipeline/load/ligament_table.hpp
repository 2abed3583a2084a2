/// Fibres in a CSV file: schemas/ligaments.md.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "load/job.hpp"

namespace vrda {

/// The fibres of a table, in its order, not yet mapped. `file` is its name in messages.
/// Throws InputError naming the file, line and column: unknown, missing and double columns, values that are
/// no numbers or out of range, a name twice, no fibre at all.
std::vector<FibreJob> read_ligament_table(const std::string& file, std::string_view text);

/// What a fibre without a bundle belongs to: its name without the digits at its end and one of "_", "-", "."
/// or a blank before them ("ACLam3" and "ACLam_3" to "ACLam"); the name itself when nothing is left.
std::string bundle_of(const std::string& fibre_name);

}  // namespace vrda

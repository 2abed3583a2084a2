/// Ligament fibres in a CSV file: schemas/ligaments.md.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "job/job.hpp"

namespace vrda::job {

/// The fibres of a table, in order, in the axes of the mesh files. `file` is its name in messages. Throws
/// InputError with file, line and column for unknown, missing and duplicate columns, invalid values, and no
/// fibres.
std::vector<FibreJob> read_ligament_table(const std::string& file, std::string_view text);

/// Default bundle of a fibre: its name without trailing digits and one preceding "_", "-", "." or blank
/// ("ACLam" for "ACLam3" and "ACLam_3"); the whole name if nothing remains.
std::string default_bundle(const std::string& fibre_name);

}  // namespace vrda::job

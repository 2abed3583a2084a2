/// From what a job says about ligaments to fibres in canonical axes.
#pragma once

#include "core/body.hpp"
#include "ligament/ligaments.hpp"
#include "load/axis_map.hpp"

namespace vrda {

struct LoadedLigaments {
  Ligaments ligaments;              ///< canonical, own side; empty when the job has none
  std::vector<FibreJob> jobs;       ///< where each fibre comes from
  std::vector<LoadedInput> inputs;  ///< files read, or the generator's name
};

/// Reads the files that the job names (data folder first), maps attachments and wraps like meshes, finds
/// wraps by name and slack lengths from reference strains. Throws InputError naming the file with line or
/// key.
LoadedLigaments load_ligaments(const Job& job, const std::string& data_directory, const AxisMap& map);

/// Throws InputError when an attachment lies outside its object: outside the bounding box of all its
/// components, drawn ones too, grown on each side by half its longest edge.
void check_attachments(const LoadedLigaments& loaded, const Body& reference, const Body& moving);

}  // namespace vrda

/// From what a job says about ligaments to fibres in canonical axes.
#pragma once

#include "core/mesh.hpp"
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

/// "ligaments.fibre.3.stiffness_n" of a fibre in the job, "line 7, stiffness_n" of one in a table.
std::string key_of_fibre(const FibreJob& fibre, const std::string& key);

/// Throws InputError when all fibres are shorter than 1 mm (attachments in m), or an attachment lies outside
/// its object: outside the bounding box of all its components, drawn ones too, grown on each side by half its
/// longest edge.
void check_attachments(const LoadedLigaments& loaded, const Body& reference, const Body& moving);

}  // namespace vrda

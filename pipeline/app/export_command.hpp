/// `vrda export`: a motion model in the formats of other programs (schemas/exports.md).
#pragma once

#include <string>
#include <vector>

#include "talk/talk.hpp"

namespace vrda {

struct ExportOptions {
  std::string file;     ///< motion model
  std::string format;   ///< sto, mot, csv, gltf or vtk
  std::string output;   ///< with the format's extension: .sto, .mot, .csv, .glb or .pvd
  std::string set;      ///< empty: the set that the player shows
  std::string flexion;  ///< FROM:TO:STEP, degrees; empty: the model's
  std::string varus;    ///< degrees, "spine" or "zero"; empty: zero where reduced, else spine
  std::vector<std::string> coordinates;  ///< COORDINATE=NAME of sto and mot
  bool in_degrees = false;               ///< angles of sto and mot
  bool every_cell = false;               ///< csv: the whole grid
  double degrees_per_second = 30.0;      ///< what time is in sto, mot and gltf
  bool as_json = false;
};

/// Prints the files written. Attitudes without a pose are left out and said so. Throws InputError, with
/// nothing written, for options that the format has no use for and where nothing is left to export.
ExitCode export_command(const ExportOptions& options);

}  // namespace vrda

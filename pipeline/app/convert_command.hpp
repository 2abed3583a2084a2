/// `vrda convert`: the thesis's own formats to ours, and mesh files from one format to another.
#pragma once

#include <string>

#include "talk/talk.hpp"

namespace vrda {

struct ConvertObjectOptions {
  std::string prefix;  ///< PREFIX.coor, PREFIX.norm, PREFIX.elem
  std::string folder;
};

struct ConvertMeshOptions {
  std::string input;
  std::string output;
};

struct ConvertConfigOptions {
  std::string file;
  std::string output;
  std::string unit = "m";  ///< of the meshes and of every length in the file: m, cm or mm
};

/// Writes NAME.obj (Vertices-Faces) and NAME.normals for each component; prints the table of thesis 5.2.
ExitCode convert_object_command(const ConvertObjectOptions& options);

ExitCode convert_mesh_command(const ConvertMeshOptions& options);

/// Models are looked for in `models` beside the configuration, or beside its folder.
ExitCode convert_config_command(const ConvertConfigOptions& options);

}  // namespace vrda

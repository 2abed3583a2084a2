/// Where components come from: mesh files and generators.
#pragma once

#include <map>

#include "load/axis_map.hpp"
#include "load/clean_mesh.hpp"
#include "shapes/shapes.hpp"

namespace vrda {

struct LoadedComponent {
  CleanMesh clean;  ///< canonical axes, mm
  LoadedInput input;
  ComponentSurvey survey;  ///< but for the body's name
};

/// The shape with its parameters in alphabetical order: "knee resolution=2 side=left".
std::string request_text(const GenerateJob& generate);

/// Loads components one after the other; a shape with several parts is generated once.
class ComponentSource {
 public:
  /// `job` has to outlive this.
  ComponentSource(const Job& job, const std::string& data_directory);

  /// Files are looked for in the data folder, then beside the job file. Their coordinates go through the
  /// axis map; generated parts are in canonical axes and mm already and skip it.
  /// Throws InputError naming the mesh file, or the job's key.
  LoadedComponent load(const ComponentJob& component);

 private:
  CleanMesh from_file(const ComponentJob& component, LoadedInput& input) const;
  CleanMesh generated(const ComponentJob& component, LoadedInput& input);
  const Shape& shape_of(const ComponentJob& component);

  const Job& job_;
  AxisMap map_;
  std::string data_directory_;
  std::map<std::string, Shape> shapes_;  // by name and parameters
};

}  // namespace vrda

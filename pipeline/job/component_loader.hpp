/// Loads components from mesh files and generators.
#pragma once

#include <map>
#include <optional>

#include "core/error.hpp"
#include "job/axis_map.hpp"
#include "job/clean_mesh.hpp"
#include "geometry/shapes.hpp"

namespace vrda::job {

struct LoadedComponent {
  CleanMesh clean;  ///< canonical axes, mm
  LoadedInput input;
  std::optional<LoadedInput> normals;  ///< the file of a Vertices-Faces mesh's normals, where there is one
  Points native;                       ///< vertices of a file, in its axes and unit; else empty
  ComponentSurvey survey;              ///< without the name of the body
};

/// The shape with its parameters in alphabetical order: "knee resolution=2 side=left".
std::string shape_request_text(const GenerateJob& generate);

/// Calls generate_it(), which generates `generate` for the job's table `key`. A generator's error names its
/// own field: thrown again with the job's key, that of the parameter if the job sets it.
template <typename Generate>
auto with_job_key(const Job& job, const std::string& key, const GenerateJob& generate,
                  const Generate& generate_it)
{
  try {
    return generate_it();
  } catch (const InputError& error) {
    const InputError::Facts& facts = error.facts();
    const bool is_parameter = generate.numbers.contains(facts.field) || generate.words.contains(facts.field);
    job.document.refuse(is_parameter ? key + "." + facts.field : key, facts.found, facts.wanted);
  }
}

/// Loads components one by one. A shape with several parts is generated once.
class ComponentLoader {
 public:
  /// `job` must outlive this object.
  ComponentLoader(const Job& job, const std::string& data_directory);

  /// Files are searched in the data folder, then in the folder of the job. Their coordinates are converted by
  /// `map`; generated parts are canonical and in mm already.
  /// Throws InputError naming the mesh file or the key of the job.
  LoadedComponent load(const ComponentJob& component, const AxisMap& map);

 private:
  CleanMesh from_file(const ComponentJob& component, const AxisMap& map, LoadedComponent& out) const;
  CleanMesh generated(const ComponentJob& component, LoadedInput& input);
  const geometry::Shape& shape_of(const ComponentJob& component);

  const Job& job_;
  std::string data_directory_;
  std::map<std::string, geometry::Shape> shapes_;  // by name and parameters
  Eigen::Index n_generated_ = 0;                 // triangles of all shapes
};

}  // namespace vrda::job

/// From the coordinates of the mesh files to canonical axes (schemas/frames.md).
#pragma once

#include <Eigen/Core>

#include <map>
#include <optional>

#include "core/text.hpp"
#include "geometry/shapes.hpp"
#include "job/case.hpp"
#include "job/clean_mesh.hpp"
#include "job/job.hpp"

namespace vrda::job {

/// p_canonical = X_canonical_native * (unit_mm * p_native). Order: conversion to mm; alignment in the files'
/// axes (R = Rz Ry Rx about fixed axes, then the translation); renaming of the axes (X anterior, Y proximal,
/// Z to the subject's right).
struct AxisMap {
  double unit_mm = 1.0;
  Pose X_canonical_native = Pose::Identity();

  Eigen::Vector3d operator()(const Eigen::Vector3d& p_native) const
  {
    return X_canonical_native * (unit_mm * p_native);
  }
};

/// 1, 10 or 1000 for "mm", "cm" and "m".
double mm_per_unit(const std::string& unit);
/// "mm", "cm" or "m", the unit of 1, 10 or 1000 mm.
const char* unit_of_mm(double mm);

/// The map of [frame]. Throws InputError if two directions name the same axis or the map is left-handed.
AxisMap axis_map(const Job& job);

/// The map of a body's files: that of [frame], or with a frame of its own: unit and alignment about its
/// origin, which goes to the rotation centre of the job, axes, then the translation.
AxisMap body_map(const Job& job, const BodyJob& body);
struct BodyMaps {
  AxisMap reference, moving;
};
BodyMaps body_maps(const Job& job);

// Loads components from mesh files and generators.

struct LoadedComponent {
  CleanMesh clean;  ///< canonical axes, mm
  LoadedInput input;
  std::optional<LoadedInput> normals;  ///< the file of a Vertices-Faces mesh's normals, where there is one
  Points native;                       ///< vertices of a file, in its axes and unit; else empty
  std::vector<std::string> notes;      ///< of a file (RawMesh), until they are in the survey
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
  Eigen::Index n_generated_ = 0;                   // triangles of all shapes
};

// Parts of a case that follow from its meshes: compartments and the start of the motion.

/// The compartment of each triangle, [n_triangles of moving.contact]; empty if the job has no compartments.
/// Compartments given by component names are assigned first; then one given by a half-space takes the
/// remaining triangles with their centroid on that side of the rotation centre (canonical z). All others are
/// `none`. Throws InputError for a name that is not a moving contact component or is in both compartments.
std::vector<Compartment> compartments_of(const Job& job, const Body& moving, double centre_z_mm);

/// Bounding box of all components of a body, visual ones included.
Box box_of(const Body& body);

/// The start of a joint whose job gives none: travel of the moving object from the pose of the meshes along
/// Delta there to 0.1 mm before the next contact ahead; if the meshes overlap, from the first pose back
/// against Delta without overlap. Zero if nothing is ahead. Attitude zero, theta of `loaded.initial`. Needs
/// the meshes. Cost: a few queries.
double start_travel_mm(const Case& loaded);

// [scaling] of a job: scales a case to the subject's size by a factor or a landmark table.
// schemas/scaling.md defines what is scaled and when the steps are kept.

/// The requested scaling; empty members if the job has no [scaling] or no landmarks.
struct RequestedScaling {
  std::optional<Scaling> scaling;
  std::vector<LoadedInput> inputs;
  std::vector<std::string> warnings;  ///< a poor fit of the landmarks
};

/// Reads the landmark table if the job names one (data folder first) and fits the factor.
/// Throws InputError naming the key of the job or the table; also for a factor outside 0.1 to 10.
RequestedScaling load_scaling(const Job& job, const std::string& data_directory, const AxisMap& map);

/// Applies `requested` to a case at factor 1 and sets `steps_job_text`. If a uniform factor keeps the steps,
/// `loaded` stays at factor 1 and `steps_scale` is set for the results; otherwise its lengths are scaled and
/// `rerun_reason` gives the reason. Throws InputError for a non-uniform factor with a wrapping surface or
/// with a fibre whose attachments coincide.
void apply_scaling(Case& loaded, const Job& job, const RequestedScaling& requested);

}  // namespace vrda::job

/// The meshes of a subject in `vrda prepare`.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/console.hpp"
#include "core/text.hpp"
#include "geometry/knee_fit.hpp"
#include "job/case_picture.hpp"
#include "prepare/job_files.hpp"

namespace vrda::app {

/// `vrda prepare`: a job from the meshes of two bones.
struct PrepareOptions {
  std::string joint = "knee";
  std::string pelvis, talus, calcaneus;
  std::vector<std::string> pelvis_cartilage, talus_cartilage, calcaneus_cartilage;
  std::string femur, tibia;  ///< mesh files of the bones; may be empty where cartilage is given
  std::vector<std::string> femur_cartilage, tibia_cartilage, menisci;
  std::string fibula;
  std::string patella;  ///< mesh file
  std::vector<std::string> patella_cartilage;
  bool has_template_patella = false;  ///< the template's, fitted to the femur
  std::string landmarks;              ///< TOML file of points (schemas/prepare.md); alone: no mesh is given
  std::string side;                   ///< left or right; empty: found
  std::string unit;                   ///< mm, cm or m; empty: found
  std::string cartilage = "auto";     ///< auto, none, or the thickness in mm on a bone without cartilage
  std::string template_job;           ///< empty: the generic knee
  std::string data_directory;         ///< of the template
  bool has_ligaments = true;
  bool has_prior = true;
  bool keeps_specks = false;   ///< keep small separate pieces in the joint space
  bool keeps_noise = false;    ///< leave rough surfaces as they are
  bool is_simplified = false;  ///< write the simpler copies of large meshes
  std::string folder;
  bool may_replace = false;
  int n_threads = 0;  ///< 0: one per processor
  bool as_json = false;
};

/// A mesh file, in the axes and the unit of the scan.
struct SubjectPart {
  prepare::JobComponent component;
  std::string file;
  Mesh mesh;
  std::vector<std::vector<Eigen::Index>> small_shells;  ///< of job/clean_mesh.hpp, in `mesh`
  std::vector<double> moved_mm;                         ///< by smoothing, of each vertex; empty: not smoothed
  Mesh simpler = {};  ///< a copy of `mesh` that stands for it; empty: `mesh` itself

  const Mesh& working() const { return simpler.triangles.rows() > 0 ? simpler : mesh; }
};

struct Subject {
  std::vector<SubjectPart> reference, moving;
  std::vector<SubjectPart> patella = {};  ///< empty: not scanned
};

/// The mesh of a bone and those of its cartilage, by its name.
struct BoneFiles {
  const std::string* bone;
  const std::vector<std::string>* cartilage;
};
BoneFiles files_of(const PrepareOptions& options, const std::string& bone);

/// The space (job/slicer_files.hpp) of the meshes, as far as they say it. Throws InputError where they
/// differ.
std::string scan_space_of(const PrepareOptions& options);

/// Reads the files of the options, without surfaces that are inside others; `warnings` name what is left out.
/// Throws InputError.
Subject subject_of(const PrepareOptions& options, std::vector<std::string>& warnings);

/// Gives each part of a subject with more than 200,000 triangles a simpler copy, within 0.05 mm. In the
/// scan's axes and unit. Returns what was done as `prepare.json` has it; null: nothing.
nlohmann::ordered_json simplify_copies(Subject& subject, double unit_mm, const PrepareOptions& options);

/// The small shells in the joint space (job/case_warnings.hpp), each with a warning. Unless they are
/// kept, the meshes are left without them: then true. In the scan's axes and unit.
bool leave_specks_out(Subject& subject, const geometry::KneeFit& fit, const PrepareOptions& options,
                      nlohmann::ordered_json& report, std::vector<std::string>& warnings);

/// Measures the noise of each surface (geometry/surface_noise.hpp) and smooths the noisy ones, unless noise
/// is kept, with a warning; `report` has a row for each. True if one was smoothed. In the scan's axes and
/// unit.
bool smooth_noise(Subject& subject, double unit_mm, const PrepareOptions& options,
                  nlohmann::ordered_json& report, std::vector<std::string>& warnings);

/// Warns of cartilage of one compartment only. In the frames of the bones, mm.
void warn_of_one_compartment(const Subject& subject, std::vector<std::string>& warnings);

/// What is registered: bone and cartilage, without the fibula.
geometry::BoneSurfaces surfaces_of(const std::vector<SubjectPart>& parts);

/// The first part that is not what its option says, such as the cartilage of the other bone; doubtful ones
/// are added to `warnings`. In the scan's axes and unit.
std::optional<InputError::Facts> wrong_part(const Subject& subject, const geometry::KneeSurfaces& surfaces,
                                            double unit_mm, std::vector<std::string>& warnings);

/// The text of a file of landmarks. Throws InputError naming `--landmarks` for an absent file.
std::string landmark_text(const std::string& file);

/// Takes vertices of the files to the anatomical frame of a bone.
Eigen::Matrix4d anatomical_from_file(double unit_mm, const Pose& X_scan_bone);

/// Four rows.
nlohmann::ordered_json matrix_json(const Eigen::Matrix4d& X);

void move_to_frame(std::vector<SubjectPart>& parts, double unit_mm, const Pose& X_scan_bone);

/// Thickens bones whose cartilage is not given.
void add_cartilage(const PrepareOptions& options, const geometry::KneeFit& fit,
                   const geometry::KneeSurfaces& surfaces, Subject& subject, nlohmann::ordered_json& report,
                   std::vector<std::string>& warnings);

/// The components of a body of the template in its bone's frame, scaled.
std::vector<SubjectPart> scaled_parts(const Body& body, const Eigen::Vector3d& scale,
                                      const Eigen::Vector3d& origin_mm);

/// The vertices that smoothing moved, for the picture.
job::MovedVertices moved_by_smoothing(const std::vector<SubjectPart>& parts);
/// The sentence of the picture's caption, from the report; empty: nothing was smoothed.
std::string smoothing_text(const nlohmann::ordered_json& report);

/// `vrda prepare --joint` of a hip, an ankle or a subtalar joint: its meshes in its frame and a job.
core::ExitCode prepare_other_joint(const PrepareOptions& options);

/// Names of components are names of files, too; in the template's job they may be any text.
void set_file_names(Subject& subject);

}  // namespace vrda::app

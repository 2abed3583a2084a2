/// The meshes of a subject in `vrda prepare`.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/staged_folder.hpp"
#include "core/console.hpp"
#include "core/text.hpp"
#include "geometry/knee_fit.hpp"
#include "job/case_picture.hpp"
#include "prepare/job_files.hpp"

namespace vrda::app {

/// The mesh file of a bone, which may be empty where cartilage is given, and those of its cartilage.
struct BoneFiles {
  std::string bone;
  std::vector<std::string> cartilage;
};

/// `vrda prepare`: a job from the meshes of two bones.
struct PrepareOptions {
  std::string joint = "knee";
  std::map<std::string, BoneFiles> bones;  ///< by name
  std::vector<std::string> menisci;
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
  bool keeps_triangles = false;  ///< write large meshes instead of their simpler copies
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

/// What a preparation makes: the files of its folder, its report and its warnings.
struct Prepared {
  /// Makes the folder. Throws InputError where the spaces of the meshes (job/slicer_files.hpp) differ.
  explicit Prepared(const PrepareOptions& options);

  /// Throws InputError for an existing output and for one that is an input. `others`: names of files besides
  /// job, report, picture and meshes.
  void check_output(std::vector<std::string> others = {}) const;
  /// With the title and the meshes.
  prepare::JobDescription description() const;
  void write_mesh(const std::string& name, const Mesh& mesh) const;
  /// Writes the meshes. The case of the job, which is not written.
  job::Case written_case(const prepare::JobDescription& job) const;
  void write_picture(const job::Case& drawn, const std::string& name, const std::string& refusal = {}) const;
  /// Writes report and job, publishes all files and prints. Files of `obsolete` that were not made are
  /// removed.
  core::ExitCode publish(const std::string& job_text, const std::vector<std::string>& obsolete = {});
  /// The path of a file in the folder.
  std::string path_of(const std::string& name) const;

  const PrepareOptions& options;
  std::string job_name;
  StagedFolder files;
  std::string scan_space;
  Subject subject;  ///< in the axes of the files, until the fit
  nlohmann::ordered_json report = nlohmann::ordered_json::object();
  std::vector<std::string> warnings = {};
};

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

/// Two parts NAME_1 and NAME_2, one on each side of the knee, become NAME_medial and NAME_lateral.
/// `X_scan_bone`: anatomical frame in the scan, mm.
void name_by_side(std::vector<SubjectPart>& parts, double unit_mm, const Pose& X_scan_bone, Side side);

void move_to_frame(std::vector<SubjectPart>& parts, double unit_mm, const Pose& X_scan_bone);

/// Thickens bones whose cartilage is not given.
void add_cartilage(const PrepareOptions& options, const geometry::KneeFit& fit,
                   const geometry::KneeSurfaces& surfaces, Subject& subject, nlohmann::ordered_json& report,
                   std::vector<std::string>& warnings);

/// The components of a body of the template in its bone's frame, scaled.
std::vector<SubjectPart> scaled_parts(const Body& body, const Eigen::Vector3d& scale,
                                      const Eigen::Vector3d& origin_mm);

/// `vrda prepare --joint` of a hip, an ankle or a subtalar joint: its meshes in its frame and a job.
core::ExitCode prepare_other_joint(const PrepareOptions& options);

/// Names of components are names of files, too; in the template's job they may be any text.
void set_file_names(Subject& subject);

}  // namespace vrda::app

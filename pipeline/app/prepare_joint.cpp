// `vrda prepare --joint hip`, ankle and subtalar: frame, unit, side and cartilage from the bones.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/prepare_subject.hpp"
#include "app/printing.hpp"
#include "app/staged_folder.hpp"
#include "core/document.hpp"
#include "core/fields_json.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "job/component_loader.hpp"
#include "job/job.hpp"
#include "job/thesis_files.hpp"
#include "prepare/joint_frame.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

// About the origin.
double open_volume(const Mesh& mesh)
{
  double sum = 0.0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    sum += a.dot(b.cross(c));
  }
  return sum;
}

bool has_cartilage(const std::vector<SubjectPart>& parts)
{
  return std::any_of(parts.begin(), parts.end(),
                     [](const SubjectPart& part) { return part.component.material == "cartilage"; });
}

// Of an open bone, as a scan cuts it, the file's winding may be either.
void orient_outward(std::vector<SubjectPart>& parts)
{
  for (SubjectPart& part : parts) {
    Mesh centred = part.mesh;
    centred.vertices_mm.rowwise() -= centred.vertices_mm.colwise().mean().eval();
    if (part.component.material == "bone" && open_volume(centred) < 0.0) geometry::reverse_winding(part.mesh);
  }
}

std::string file_of(const std::vector<SubjectPart>& parts)
{
  return parts.front().file;
}

class JointPreparation {
 public:
  explicit JointPreparation(const PrepareOptions& options)
      : options_(options),
        folder_(options.folder),
        job_name_(options.joint + ".toml"),
        files_(options.folder, job_name_, "vrda prepare"),
        scan_space_(scan_space_of(options))
  {
  }

  core::ExitCode run()
  {
    if (!files_.is_locked()) return core::ExitCode::interrupted;
    const std::vector<prepare::NamedPoint> landmarks = landmarks_of_joint();
    subject_ = subject_of(options_, warnings_);
    check_output();
    orient_outward(subject_.reference);
    orient_outward(subject_.moving);
    frame_ = frame(landmarks);
    if (smooth_noise(subject_, frame_.unit_mm, options_, report_, warnings_)) frame_ = frame(landmarks);
    warnings_.insert(warnings_.end(), frame_.warnings.begin(), frame_.warnings.end());
    if (core::is_interrupted()) return core::ExitCode::interrupted;
    for (std::vector<SubjectPart>* parts : {&subject_.reference, &subject_.moving})
      move_to_frame(*parts, frame_.unit_mm, frame_.X_scan_joint);
    add_cartilage();
    write();
    return core::ExitCode::done;
  }

 private:
  std::vector<prepare::NamedPoint> landmarks_of_joint() const
  {
    const std::string& file = options_.landmarks;
    if (file.empty()) return {};
    return prepare::read_joint_landmarks(
        file, landmark_text(file),
        {scan_space_, options_.unit.empty() ? 1.0 : job::mm_per_unit(options_.unit)});
  }

  void check_output() const
  {
    std::vector<std::string> names{job_name_, "prepare.json", "prepare.png"}, inputs;
    for (const std::vector<SubjectPart>* parts : {&subject_.reference, &subject_.moving}) {
      for (const SubjectPart& part : *parts) {
        names.push_back(part.component.name + ".stl");
        inputs.push_back(part.file);
      }
    }
    files_.check_replaced(names, inputs, options_.may_replace);
  }

  prepare::JointFrame frame(const std::vector<prepare::NamedPoint>& landmarks) const
  {
    prepare::JointFrameOptions known;
    known.joint = options_.joint;
    known.reference_file = file_of(subject_.reference);
    known.moving_file = file_of(subject_.moving);
    if (!options_.side.empty()) known.side = side_named(options_.side);
    if (!options_.unit.empty()) known.unit_mm = job::mm_per_unit(options_.unit);
    known.landmarks = landmarks;
    prepare::JointSurfaces surfaces{
        joined(surfaces_of(subject_.reference)), joined(surfaces_of(subject_.moving)), {}};
    for (const SubjectPart& part : subject_.reference) {
      if (part.component.name == "fibula") surfaces.fibula = part.mesh;
    }
    return prepare::joint_frame(surfaces, known);
  }

  // Thickens bones whose cartilage is not given.
  void add_cartilage()
  {
    const int n_bare = (has_cartilage(subject_.reference) ? 0 : 1) + (has_cartilage(subject_.moving) ? 0 : 1);
    const bool is_auto = options_.cartilage == "auto";
    if (n_bare == 0 && !is_auto && options_.cartilage != "none")
      throw InputError({"--cartilage", "", options_.cartilage + " and cartilage of both bones",
                        "no thickness, or a bone without cartilage"});
    if (n_bare == 0 || options_.cartilage == "none") return;
    const double each_mm =
        is_auto ? prepare::joint_cartilage_mm(frame_.gap_mm, n_bare) : std::stod(options_.cartilage);
    report_["cartilage"] = {{"scanned_gap_mm", json_value(frame_.gap_mm)}, {"thickness_mm", each_mm}};
    if (each_mm == 0.0) return;
    for (std::vector<SubjectPart>* parts : {&subject_.reference, &subject_.moving}) {
      if (has_cartilage(*parts)) continue;
      for (SubjectPart& part : *parts) part.component.inset_mm = -each_mm;
      warnings_.push_back(parts->front().component.name + ": no cartilage given; the bone is thickened by " +
                          shortest_decimal(each_mm) + " mm" + (is_auto ? ", from the gap in the scan" : ""));
    }
  }

  prepare::JobDescription description() const
  {
    prepare::JobDescription job;
    job.title = folder_.stem().string().empty() ? options_.joint : folder_.stem().string();
    job.joint = options_.joint;
    job.side = frame_.side;
    for (const SubjectPart& part : subject_.reference) job.reference.push_back(part.component);
    for (const SubjectPart& part : subject_.moving) job.moving.push_back(part.component);
    job.X_scan_reference = frame_.X_scan_joint;
    job.scan_space = scan_space_;
    job.scan_unit = job::unit_of_mm(frame_.unit_mm);
    job.axes = frame_.found;
    job.delta = frame_.delta;
    job.axis = frame_.axis;
    if (options_.has_ligaments) job.fibres = frame_.fibres;
    job.least_flexion_deg = frame_.least_flexion_deg;
    job.most_flexion_deg = frame_.most_flexion_deg;
    return job;
  }

  void set_report()
  {
    const Json rows = matrix_json(anatomical_from_file(frame_.unit_mm, frame_.X_scan_joint));
    const Eigen::Vector3d centre = frame_.X_scan_joint.translation() / frame_.unit_mm, &axis = frame_.axis;
    Json report = {{"joint", options_.joint},
                   {"unit", job::unit_of_mm(frame_.unit_mm)},
                   {"side", side_name(frame_.side)},
                   {"side_margin", frame_.side_margin},
                   {"centre", {centre.x(), centre.y(), centre.z()}},
                   {"radius_mm", json_value(frame_.radius_mm)},
                   {"residual_mm", frame_.residual_mm},
                   {"axes", frame_.found}};
    if (options_.joint != "hip") report["axis"] = {axis.x(), axis.y(), axis.z()};
    const prepare::JointBones bones = prepare::bones_of(options_.joint);
    for (const char* bone : {bones.reference, bones.moving}) report[bone] = {{"anatomical_from_file", rows}};
    report.update(report_);
    report["warnings"] = warnings_;
    report_ = std::move(report);
  }

  void write()
  {
    for (const std::vector<SubjectPart>* parts : {&subject_.reference, &subject_.moving}) {
      for (const SubjectPart& part : *parts)
        write_atomically(files_.file(part.component.name + ".stl"),
                         {job::stl_bytes(part.mesh, "vrda prepare, mm, anatomical frame")});
    }
    const std::string text = prepare::job_text(description());
    const job::Case prepared = job::load_case(job::parse_job(files_.file(job_name_), text), "");
    job::PictureNotes notes;
    notes.n_warnings = warnings_.size();
    notes.has_four_views = true;
    notes.moved = {moved_by_smoothing(subject_.reference), moved_by_smoothing(subject_.moving)};
    notes.smoothing = smoothing_text(report_);
    write_atomically(files_.file("prepare.png"), {job::case_picture(prepared, notes)});
    set_report();
    write_atomically(files_.file("prepare.json"), {core::json_text(report_, 2) + "\n"});
    write_atomically(files_.file(job_name_), {text});
    files_.publish_all({});
    core::log_info("side " + side_name(frame_.side) + ", unit " + job::unit_of_mm(frame_.unit_mm));
    for (const std::string& axis : frame_.found) core::log_info(axis);
    for (const std::string& warning : warnings_) core::log_warning(warning);
    if (options_.as_json) {
      print_json(report_);
    } else {
      std::printf("%s\n", (folder_ / job_name_).c_str());
    }
  }

  const PrepareOptions& options_;
  fs::path folder_;
  std::string job_name_;
  StagedFolder files_;
  std::string scan_space_;
  Subject subject_;
  prepare::JointFrame frame_;
  Json report_ = Json::object();
  std::vector<std::string> warnings_;
};

}  // namespace

core::ExitCode prepare_other_joint(const PrepareOptions& options)
{
  return JointPreparation(options).run();
}

}  // namespace vrda::app

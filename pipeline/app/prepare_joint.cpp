// `vrda prepare --joint hip`, ankle and subtalar: frame, unit, side and cartilage from the bones.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/prepare_subject.hpp"
#include "core/fields_json.hpp"
#include "core/text.hpp"
#include "job/component_loader.hpp"
#include "job/job.hpp"
#include "prepare/joint_frame.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;

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
  explicit JointPreparation(const PrepareOptions& options) : options_(options), out_(options) {}

  core::ExitCode run()
  {
    if (!out_.files.is_locked()) return core::ExitCode::interrupted;
    const std::vector<prepare::NamedPoint> landmarks = landmarks_of_joint();
    out_.subject = subject_of(options_, out_.warnings);
    out_.check_output();
    orient_outward(out_.subject.reference);
    orient_outward(out_.subject.moving);
    frame_ = frame(landmarks);
    if (smooth_noise(out_.subject, frame_.unit_mm, options_, out_.report, out_.warnings))
      frame_ = frame(landmarks);
    out_.warnings.insert(out_.warnings.end(), frame_.warnings.begin(), frame_.warnings.end());
    if (core::is_interrupted()) return core::ExitCode::interrupted;
    for (std::vector<SubjectPart>* parts : {&out_.subject.reference, &out_.subject.moving})
      move_to_frame(*parts, frame_.unit_mm, frame_.X_scan_joint);
    add_cartilage();
    return write();
  }

 private:
  std::vector<prepare::NamedPoint> landmarks_of_joint() const
  {
    const std::string& file = options_.landmarks;
    if (file.empty()) return {};
    return prepare::read_joint_landmarks(
        file, landmark_text(file),
        {out_.scan_space, options_.unit.empty() ? 1.0 : job::mm_per_unit(options_.unit)});
  }

  prepare::JointFrame frame(const std::vector<prepare::NamedPoint>& landmarks) const
  {
    prepare::JointFrameOptions known;
    known.joint = options_.joint;
    known.reference_file = file_of(out_.subject.reference);
    known.moving_file = file_of(out_.subject.moving);
    if (!options_.side.empty()) known.side = side_named(options_.side);
    if (!options_.unit.empty()) known.unit_mm = job::mm_per_unit(options_.unit);
    known.landmarks = landmarks;
    prepare::JointSurfaces surfaces{
        joined(surfaces_of(out_.subject.reference)), joined(surfaces_of(out_.subject.moving)), {}};
    for (const SubjectPart& part : out_.subject.reference) {
      if (part.component.name == "fibula") surfaces.fibula = part.mesh;
    }
    return prepare::joint_frame(surfaces, known);
  }

  // Thickens bones whose cartilage is not given.
  void add_cartilage()
  {
    const int n_bare =
        (has_cartilage(out_.subject.reference) ? 0 : 1) + (has_cartilage(out_.subject.moving) ? 0 : 1);
    const bool is_auto = options_.cartilage == "auto";
    if (n_bare == 0 && !is_auto && options_.cartilage != "none")
      throw InputError({"--cartilage", "", options_.cartilage + " and cartilage of both bones",
                        "no thickness, or a bone without cartilage"});
    if (n_bare == 0 || options_.cartilage == "none") return;
    const double each_mm =
        is_auto ? prepare::joint_cartilage_mm(frame_.gap_mm, n_bare) : std::stod(options_.cartilage);
    out_.report["cartilage"] = {{"scanned_gap_mm", json_value(frame_.gap_mm)}, {"thickness_mm", each_mm}};
    if (each_mm == 0.0) return;
    for (std::vector<SubjectPart>* parts : {&out_.subject.reference, &out_.subject.moving}) {
      if (has_cartilage(*parts)) continue;
      for (SubjectPart& part : *parts) part.component.inset_mm = -each_mm;
      out_.warnings.push_back(parts->front().component.name +
                              ": no cartilage given; the bone is thickened by " + shortest_decimal(each_mm) +
                              " mm" + (is_auto ? ", from the gap in the scan" : ""));
    }
  }

  prepare::JobDescription description() const
  {
    prepare::JobDescription job = out_.description();
    job.side = frame_.side;
    job.X_scan_reference = frame_.X_scan_joint;
    job.scan_space = out_.scan_space;
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
    report.update(out_.report);
    out_.report = std::move(report);
  }

  core::ExitCode write()
  {
    const job::Case prepared = out_.written_case(description());
    out_.write_picture(prepared, "prepare.png");
    set_report();
    core::log_info("side " + side_name(frame_.side) + ", unit " + job::unit_of_mm(frame_.unit_mm));
    for (const std::string& axis : frame_.found) core::log_info(axis);
    return out_.publish(prepared.job_text);
  }

  const PrepareOptions& options_;
  Prepared out_;
  prepare::JointFrame frame_;
};

}  // namespace

core::ExitCode prepare_other_joint(const PrepareOptions& options)
{
  return JointPreparation(options).run();
}

}  // namespace vrda::app

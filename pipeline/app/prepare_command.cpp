#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/file_commands.hpp"
#include "convert/mesh_writer.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "job_run/run_output.hpp"
#include "job_run/summary.hpp"
#include "load/axis_map.hpp"
#include "load/clean_mesh.hpp"
#include "load/file_bytes.hpp"
#include "load/job.hpp"
#include "picture/case_picture.hpp"
#include "prepare/carried_ligaments.hpp"
#include "prepare/cartilage_gap.hpp"
#include "prepare/fit_checks.hpp"
#include "prepare/job_files.hpp"
#include "prepare/slack_lengths.hpp"

namespace vrda::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using registration::BoneSurfaces;
using registration::KneeFit;
using registration::KneeSurfaces;

// A mesh file of the subject, in the axes and the unit of the scan.
struct SubjectPart {
  prepare::JobComponent component;
  std::string file;
  Mesh mesh;
};

struct Subject {
  std::vector<SubjectPart> reference, moving;
};

Mesh mesh_of(const std::string& file, const std::string& option)
{
  std::string bytes = load::file_bytes(file, {file, option, "", "a mesh file"}, load::largest_mesh_bytes);
  load::CleanMesh clean =
      load::clean_mesh(load::read_mesh(file, std::move(bytes)), load::Winding::outward, Side::right);
  if (clean.mesh.triangles.rows() == 0) throw InputError({file, option, "no faces", "a mesh with faces"});
  return clean.mesh;
}

// NAME, or NAME_1, NAME_2, ... for several files.
void add_parts(std::vector<SubjectPart>& parts, const std::vector<std::string>& files,
               const prepare::JobComponent& component, const std::string& option)
{
  for (std::size_t i = 0; i < files.size(); ++i) {
    SubjectPart part{component, files[i], mesh_of(files[i], option)};
    if (files.size() > 1) part.component.name += "_" + std::to_string(i + 1);
    parts.push_back(part);
  }
}

std::vector<std::string> list_of(const std::string& file)
{
  return file.empty() ? std::vector<std::string>{} : std::vector<std::string>{file};
}

Subject subject_of(const PrepareOptions& options)
{
  for (const auto& [bone, cartilage, option] :
       {std::tuple(&options.femur, &options.femur_cartilage, "--femur"),
        std::tuple(&options.tibia, &options.tibia_cartilage, "--tibia")}) {
    if (bone->empty() && cartilage->empty())
      throw InputError({option, "", "nothing", "the mesh of the bone, or of its cartilage"});
  }
  Subject subject;
  add_parts(subject.reference, list_of(options.femur), {"femur", "bone"}, "--femur");
  add_parts(subject.reference, options.femur_cartilage, {"femur_cartilage", "cartilage"},
            "--femur-cartilage");
  add_parts(subject.moving, list_of(options.tibia), {"tibia", "bone"}, "--tibia");
  add_parts(subject.moving, options.tibia_cartilage, {"tibia_cartilage", "cartilage"}, "--tibia-cartilage");
  add_parts(subject.moving, options.menisci, {"meniscus", "meniscus", false}, "--meniscus");
  add_parts(subject.moving, list_of(options.fibula), {"fibula", "bone", false}, "--fibula");
  return subject;
}

BoneSurfaces surfaces_of(const std::vector<SubjectPart>& parts)
{
  BoneSurfaces surfaces;
  for (const SubjectPart& part : parts) {
    if (part.component.name == "fibula") continue;
    if (part.component.material == "bone") append(surfaces.bone, part.mesh);
    if (part.component.material == "cartilage") append(surfaces.cartilage, part.mesh);
  }
  return surfaces;
}

void move_to_frame(std::vector<SubjectPart>& parts, double unit_mm, const Pose& X_scan_bone)
{
  for (SubjectPart& part : parts) {
    part.mesh.vertices_mm *= unit_mm;
    part.mesh = transformed(part.mesh, X_scan_bone.inverse());
  }
}

Json matrix_json(const Eigen::Matrix4d& X)
{
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < 4; ++i) rows.push_back({X(i, 0), X(i, 1), X(i, 2), X(i, 3)});
  return rows;
}

// Takes vertices of the files to the bone's anatomical frame.
Eigen::Matrix4d anatomical_from_file(const KneeFit& fit, const Pose& X_scan_bone)
{
  Eigen::Matrix4d X = X_scan_bone.inverse().matrix();
  X.leftCols<3>() *= fit.unit_mm;
  X(3, 3) = 1.0;
  return X;
}

Json bone_json(const KneeFit& fit, const registration::BoneFit& bone, const Pose& X_scan_bone)
{
  return {{"anatomical_from_file", matrix_json(anatomical_from_file(fit, X_scan_bone))},
          {"scale", {bone.scale.x(), bone.scale.y(), bone.scale.z()}},
          {"residual_mm", bone.residual_mm}};
}

Json number_or_null(double value)
{
  return std::isfinite(value) ? Json(value) : Json();
}

const char* side_name(Side side)
{
  return side == Side::right ? "right" : "left";
}

Json fit_json(const KneeFit& fit)
{
  const ClinicalCoordinates& scanned = fit.scanned;
  return {{"unit", load::unit_of_mm(fit.unit_mm)},
          {"side", side_name(fit.side)},
          {"side_margin", fit.side_margin},
          {"coarse_residual_mm", fit.coarse_residual_mm},
          {"femur", bone_json(fit, fit.femur, fit.X_scan_femur)},
          {"tibia", bone_json(fit, fit.tibia, fit.X_scan_tibia)},
          {"scanned",
           {{"flexion_deg", deg_from_rad(scanned.flexion_rad)},
            {"varus_deg", deg_from_rad(scanned.varus_rad)},
            {"internal_rotation_deg", deg_from_rad(scanned.internal_rotation_rad)},
            {"anterior_mm", scanned.anterior_mm},
            {"proximal_mm", scanned.proximal_mm},
            {"lateral_mm", scanned.lateral_mm},
            {"X_femur_tibia", matrix_json((fit.X_scan_femur.inverse() * fit.X_scan_tibia).matrix())}}}};
}

// Strain and tension a bundle, with a warning for those out of range.
Json bundles_json(const ligament::Ligaments& ligaments, const prepare::SlackResult& slack,
                  std::vector<std::string>& warnings)
{
  constexpr double largest_strain = 0.15, largest_tension_n = 1000.0;
  struct Sum {
    double strain = 0.0, tension_n = 0.0;
  };
  std::vector<std::pair<std::string, Sum>> bundles;
  for (std::size_t i = 0; i < ligaments.fibres.size(); ++i) {
    const std::string& name = ligaments.fibres[i].bundle;
    auto found = std::find_if(bundles.begin(), bundles.end(), [&](const auto& b) { return b.first == name; });
    if (found == bundles.end()) found = bundles.insert(bundles.end(), {name, {}});
    found->second.strain = std::max(found->second.strain, slack.loads.largest_strain[i]);
    found->second.tension_n += slack.loads.largest_tension_n[i];
  }
  Json rows = Json::array();
  for (const auto& [name, sum] : bundles) {
    rows.push_back({{"name", name}, {"largest_strain", sum.strain}, {"largest_tension_n", sum.tension_n}});
    if (sum.strain <= largest_strain && sum.tension_n <= largest_tension_n) continue;
    warnings.push_back("ligament " + name + ": strain " +
                       shortest_decimal(std::round(1e3 * sum.strain) / 1e3) + " and tension " +
                       shortest_decimal(std::round(sum.tension_n)) + " N, usual are at most 0.15 and 1000 N");
  }
  return rows;
}

Json fibres_json(const prepare::CarriedLigaments& carried, const prepare::SlackResult& slack)
{
  Json rows = Json::array();
  for (std::size_t i = 0; i < carried.moves.size(); ++i) {
    rows.push_back({{"name", carried.ligaments.fibres[i].name},
                    {"moved_femur_mm", number_or_null(carried.moves[i].reference_mm)},
                    {"moved_tibia_mm", number_or_null(carried.moves[i].moving_mm)},
                    {"largest_strain", slack.loads.largest_strain[i]},
                    {"template_strain", slack.template_strain[i]}});
  }
  return rows;
}

prepare::TemplateJoint template_of(const PrepareOptions& options)
{
  if (options.template_job.empty()) return prepare::generic_template();
  return prepare::template_of(load::load_case(options.template_job, {options.data_directory, {}}));
}

// Thickens bones whose cartilage is not given.
void add_cartilage(const PrepareOptions& options, const KneeFit& fit, const KneeSurfaces& surfaces,
                   Subject& subject, Json& report, std::vector<std::string>& warnings)
{
  const bool is_femur_bare = surfaces.femur.cartilage.triangles.rows() == 0;
  const bool is_tibia_bare = surfaces.tibia.cartilage.triangles.rows() == 0;
  if (options.cartilage == "none" || (!is_femur_bare && !is_tibia_bare)) return;
  const double gap_mm = prepare::scanned_gap_mm(fit, surfaces);
  const bool is_auto = options.cartilage == "auto";
  const double half_mm =
      0.5 * prepare::cartilage_in_gap_mm(is_femur_bare && is_tibia_bare ? gap_mm : 2.0 * gap_mm);
  const double each_mm = std::round(100.0 * (is_auto ? half_mm : std::stod(options.cartilage))) / 100.0;
  for (auto& [parts, is_bare, name] : {std::tuple(&subject.reference, is_femur_bare, "femur"),
                                       std::tuple(&subject.moving, is_tibia_bare, "tibia")}) {
    if (!is_bare) continue;
    for (SubjectPart& part : *parts) {
      if (part.component.name == name) part.component.inset_mm = -each_mm;
    }
    warnings.push_back(std::string(name) + ": no cartilage given; the bone is thickened by " +
                       shortest_decimal(each_mm) + " mm" + (is_auto ? ", from the gap in the scan" : ""));
  }
  report["cartilage"] = {{"scanned_gap_mm", number_or_null(gap_mm)}, {"thickness_mm", each_mm}};
}

class Preparation {
 public:
  explicit Preparation(const PrepareOptions& options)
      : options_(options),
        folder_(options.folder),
        reference_(template_of(options)),
        subject_(subject_of(options))
  {
  }

  void run()
  {
    const KneeSurfaces surfaces{surfaces_of(subject_.reference), surfaces_of(subject_.moving)};
    registration::KneeFitOptions known;
    if (!options_.side.empty()) known.side = options_.side == "left" ? Side::left : Side::right;
    if (!options_.unit.empty()) known.unit_mm = load::mm_per_unit(options_.unit);
    fit_ = registration::fit_knee(surfaces, reference_.knee, known);
    report_ = fit_json(fit_);
    console::log_info("side " + std::string(side_name(fit_.side)) + ", unit " +
                      load::unit_of_mm(fit_.unit_mm) + ", scanned at " +
                      shortest_decimal(std::round(deg_from_rad(fit_.scanned.flexion_rad))) +
                      " degrees of flexion");
    move_to_frame(subject_.reference, fit_.unit_mm, fit_.X_scan_femur);
    move_to_frame(subject_.moving, fit_.unit_mm, fit_.X_scan_tibia);
    job_run::make_folder(options_.folder);
    fs::remove(file("knee.toml"));  // of an earlier preparation, whose meshes are replaced
    warnings_ = prepare::doubts(fit_, surfaces, known.side.has_value());
    for (const SubjectPart& part : subject_.moving) {
      if (part.component.name == "fibula" && !prepare::is_fibula_lateral(part.mesh, fit_.side))
        warnings_.push_back("--fibula: its head is not lateral of the tibia; check it and the side");
    }
    refuse_other_objects(surfaces);
    add_cartilage(options_, fit_, surfaces, subject_, report_, warnings_);
    if (options_.menisci.empty()) warnings_.push_back("no menisci given: the knee moves without them");
    if (reference_.joint.frame.side != fit_.side) reference_ = prepare::mirrored(reference_);
    write();
  }

 private:
  // The picture of a refused knee shows what went wrong.
  void refuse_other_objects(const KneeSurfaces& surfaces)
  {
    const std::vector<std::string> found = prepare::objections(fit_, surfaces);
    if (found.empty()) return;
    std::string all = prepare::explanation(fit_, surfaces, reference_.knee);
    for (const std::string& objection : found) all += (all.empty() ? "" : "; ") + objection;
    const load::Case drawn = written_case(false);
    write_picture(drawn, found.size());
    throw InputError({subject_.reference.front().file + ", " + subject_.moving.front().file, "", all,
                      "femur and tibia of one knee in one pose, similar to the template \"" +
                          reference_.joint.title + "\"; see " + file("prepare.png")});
  }

  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  prepare::JobDescription description(bool has_ligaments) const
  {
    prepare::JobDescription job;
    job.title = folder_.stem().string();
    if (job.title.empty()) job.title = "knee";
    job.side = fit_.side;
    for (const SubjectPart& part : subject_.reference) job.reference.push_back(part.component);
    for (const SubjectPart& part : subject_.moving) job.moving.push_back(part.component);
    job.has_ligaments = has_ligaments;
    job.has_wraps = has_ligaments && !reference_.joint.ligaments.wraps.empty();
    return job;
  }

  // The case of the files in the folder; the job is not written yet.
  load::Case written_case(bool has_ligaments)
  {
    for (const std::vector<SubjectPart>* parts : {&subject_.reference, &subject_.moving}) {
      for (const SubjectPart& part : *parts)
        write_atomically(file(part.component.name + ".stl"),
                         {convert::stl_bytes(part.mesh, "vrda prepare, mm, anatomical frame")});
    }
    return load::load_case(load::parse_job(file("knee.toml"), prepare::job_text(description(has_ligaments))),
                           "");
  }

  void write_picture(const load::Case& drawn, std::size_t n_warnings) const
  {
    picture::PictureNotes notes;
    notes.n_warnings = n_warnings;
    notes.has_four_views = true;
    write_atomically(file("prepare.png"), {picture::case_picture(drawn, notes)});
  }

  void write_ligaments(const ligament::Ligaments& ligaments) const
  {
    write_atomically(
        file("ligaments.csv"),
        {prepare::ligament_table(ligaments, "Fibres of \"" + reference_.joint.title +
                                                "\" carried over by vrda prepare; mm, anatomical frames")});
    if (!ligaments.wraps.empty()) write_atomically(file("wraps.json"), {prepare::wraps_text(ligaments)});
  }

  load::Case case_with_ligaments()
  {
    prepare::SubjectBones bones{{surfaces_of(subject_.reference), surfaces_of(subject_.moving)}, {}};
    for (const SubjectPart& part : subject_.moving) {
      if (part.component.name == "fibula") bones.fibula = part.mesh;
    }
    const prepare::CarriedLigaments carried = prepare::carried_ligaments(reference_, fit_, bones);
    write_ligaments(carried.ligaments);
    load::Case prepared = written_case(true);
    const prepare::SlackResult slack = prepare::set_slack_lengths(
        prepared, reference_.joint, job_run::thread_count_or_all(options_.n_threads));
    write_ligaments(prepared.ligaments);
    report_["fibres"] = fibres_json(carried, slack);
    report_["bundles"] = bundles_json(prepared.ligaments, slack, warnings_);
    report_["settled"] = {{"varus_deg", deg_from_rad(slack.settled.attitude.varus_rad)},
                          {"travel_mm", slack.settled.pose.translation_mm.y()},
                          {"has_contact", slack.settled.has_contact}};
    report_["fibres_lengthened"] = slack.lengthenings;
    report_["solved_flexions"] = {slack.loads.n_solved, slack.loads.n_flexions};
    if (slack.loads.n_solved < slack.loads.n_flexions)
      warnings_.push_back("solved " + std::to_string(slack.loads.n_solved) + " of " +
                          std::to_string(slack.loads.n_flexions) + " flexions");
    return prepared;
  }

  void write()
  {
    const load::Case prepared = options_.has_ligaments ? case_with_ligaments() : written_case(false);
    write_picture(prepared, warnings_.size());
    report_["template"] = reference_.joint.title;
    report_["warnings"] = warnings_;
    write_atomically(file("prepare.json"), {report_.dump(2) + "\n"});
    write_atomically(file("knee.toml"), {prepared.job_text});
    for (const std::string& warning : warnings_) console::log_warning(warning);
    if (options_.as_json) {
      std::printf("%s\n", report_.dump(2).c_str());
    } else {
      std::printf("%s\n", file("knee.toml").c_str());
    }
  }

  const PrepareOptions& options_;
  fs::path folder_;
  prepare::TemplateJoint reference_;  // of a right knee, until the side is known
  Subject subject_;                   // in the axes of the files, until the fit
  KneeFit fit_;
  Json report_;
  std::vector<std::string> warnings_;
};

}  // namespace

console::ExitCode prepare_command(const PrepareOptions& options)
{
  Preparation(options).run();
  return console::ExitCode::done;
}

}  // namespace vrda::app

// `vrda prepare`: a job from the meshes of two bones; of a knee, by a template, from landmarks alone too.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/commands.hpp"
#include "app/prepare_subject.hpp"
#include "core/document.hpp"
#include "core/fields_json.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "geometry/knee_fit.hpp"
#include "job/case_picture.hpp"
#include "job/component_loader.hpp"
#include "job/job.hpp"
#include "model/frames.hpp"
#include "prepare/bone_wraps.hpp"
#include "prepare/job_files.hpp"
#include "prepare/joint_frame.hpp"
#include "prepare/knee_landmarks.hpp"
#include "prepare/template_joint.hpp"
#include "prepare/transfer.hpp"
#include "run/run_output.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;
using geometry::KneeFit;
namespace fs = std::filesystem;
using geometry::BoneSurfaces;
using geometry::KneeSurfaces;

Json bone_json(const KneeFit& fit, const geometry::BoneFit& bone, const Pose& X_scan_bone)
{
  return {{"anatomical_from_file", matrix_json(anatomical_from_file(fit.unit_mm, X_scan_bone))},
          {"scale", {bone.scale.x(), bone.scale.y(), bone.scale.z()}},
          {"residual_mm", bone.residual_mm}};
}

Json bone_scale_json(const Scaling& scaling)
{
  Json distances = Json::array();
  for (std::size_t i = 0; i < scaling.landmark.size(); ++i) {
    distances.push_back({{"name", scaling.landmark[i]},
                         {"template_mm", scaling.model_mm[i]},
                         {"subject_mm", scaling.subject_mm[i]},
                         {"residual_mm", scaling.residual_mm[i]}});
  }
  return {{"scale", {scaling.factor.x(), scaling.factor.y(), scaling.factor.z()}},
          {"residual_rms_mm", json_value(scaling.residual_rms_mm)},
          {"distances", distances}};
}

Json fit_json(const KneeFit& fit)
{
  Json scanned = Json::object();
  for (std::size_t k = 0; k < n_joint_coordinates; ++k)
    scanned[std::string(k == 2 ? "internal_rotation" : joint_coordinate_names[k]) + unit_suffix(k)] =
        in_files(fit.scanned)[k];
  scanned["X_femur_tibia"] = matrix_json((fit.X_scan_femur.inverse() * fit.X_scan_tibia).matrix());
  return {{"unit", job::unit_of_mm(fit.unit_mm)},
          {"side", side_name(fit.side)},
          {"side_margin", fit.side_margin},
          {"coarse_residual_mm", fit.coarse_residual_mm},
          {"femur", bone_json(fit, fit.femur, fit.X_scan_femur)},
          {"tibia", bone_json(fit, fit.tibia, fit.X_scan_tibia)},
          {"scanned", scanned}};
}

Json landmarks_json(const prepare::KneeLandmarks& landmarks, const std::vector<double>& residuals_mm,
                    std::vector<std::string>& warnings)
{
  constexpr double usual_mm = 10.0;
  Json rows = Json::array();
  for (std::size_t i = 0; i < landmarks.points.size(); ++i) {
    const std::string& name = landmarks.points[i].name;
    const double residual_mm = residuals_mm[i];
    rows.push_back({{"name", name}, {"residual_mm", json_value(residual_mm)}});
    if (!std::isfinite(residual_mm)) {
      warnings.push_back("landmarks." + name + ": not used; the template does not have this bone");
    } else if (residual_mm > usual_mm) {
      warnings.push_back("landmarks." + name + ": " + short_decimal(residual_mm, 0) +
                         " mm from where the bones have it");
    }
  }
  return rows;
}

Json scales_json(const prepare::LandmarkScales& scales, Side side)
{
  return {{"side", side_name(side)},
          {"femur", bone_scale_json(scales.femur)},
          {"tibia", bone_scale_json(scales.tibia)}};
}

Json bundles_json(const model::Ligaments& ligaments, const prepare::SlackResult& slack,
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
    warnings.push_back("ligament " + name + ": strain " + short_decimal(sum.strain, 3) + " and tension " +
                       short_decimal(sum.tension_n, 0) + " N, usual are at most 0.15 and 1000 N");
  }
  return rows;
}

Json fibres_json(const prepare::TransferredLigaments& transferred, const prepare::SlackResult& slack)
{
  Json rows = Json::array();
  for (std::size_t i = 0; i < transferred.moves.size(); ++i) {
    rows.push_back({{"name", transferred.ligaments.fibres[i].name},
                    {"moved_femur_mm", json_value(transferred.moves[i].reference_mm)},
                    {"moved_tibia_mm", json_value(transferred.moves[i].moving_mm)},
                    {"largest_strain", slack.loads.largest_strain[i]},
                    {"template_strain", slack.template_strain[i]}});
  }
  return rows;
}

// Rounded to 0.01, as printed.
Json crossings_json(const std::vector<prepare::BundleCrossing>& crossings, std::vector<std::string>& warnings)
{
  constexpr double allowed_mm = 1.0;
  const auto hundredths = [](double value) { return std::round(100.0 * value) / 100.0; };
  Json rows = Json::array();
  for (const prepare::BundleCrossing& bundle : crossings) {
    const double straight_mm = hundredths(bundle.straight_mm), left_mm = hundredths(bundle.left_mm);
    rows.push_back({{"bundle", bundle.bundle},
                    {"bone", bundle.bone},
                    {"fibres", bundle.n_fibres},
                    {"wrapped", bundle.n_wrapped},
                    {"straight_mm", straight_mm},
                    {"flexion_deg", hundredths(deg_from_rad(bundle.flexion_rad))},
                    {"left_mm", left_mm}});
    if (bundle.n_wrapped > 0)
      core::log_info("ligament " + bundle.bundle + ": " + std::to_string(bundle.n_wrapped) + " of " +
                     std::to_string(bundle.n_fibres) + " fibres go over the " + bundle.bone + "; straight " +
                     shortest_decimal(straight_mm) + " mm inside bone, now " + shortest_decimal(left_mm));
    if (bundle.left_mm > allowed_mm)
      warnings.push_back("ligament " + bundle.bundle + ": " + shortest_decimal(left_mm) +
                         " mm inside bone at the deepest, wanted at most 1");
  }
  return rows;
}

Json kneecap_json(const prepare::Kneecap& cap, double offset_mm)
{
  Json scanned = Json::object();
  for (std::size_t k = 0; k < n_joint_coordinates; ++k)
    scanned[std::string(follower_coordinate_names[k]) + unit_suffix(k)] = in_files(cap.scanned)[k];
  return {{"is_template", std::isnan(cap.residual_mm)},
          {"residual_mm", json_value(cap.residual_mm)},
          {"scale", {cap.scale.x(), cap.scale.y(), cap.scale.z()}},
          {"gap_mm", json_value(cap.gap_mm)},
          {"offset_mm", offset_mm},
          {"scanned", scanned}};
}

prepare::TemplateJoint template_of(const PrepareOptions& options)
{
  if (options.template_job.empty()) return prepare::generic_template();
  return prepare::template_of(job::load_case(options.template_job, {options.data_directory, {}}));
}

bool is_thickness(const std::string& cartilage)
{
  return cartilage != "auto" && cartilage != "none";
}

prepare::KneeLandmarks landmarks_of(const PrepareOptions& options, const std::string& space)
{
  if (options.landmarks.empty()) return {};
  return prepare::read_knee_landmarks(options.landmarks, landmark_text(options.landmarks),
                                      {space, options.unit.empty() ? 1.0 : job::mm_per_unit(options.unit)});
}

class Preparation {
 public:
  explicit Preparation(const PrepareOptions& options)
      : options_(options),
        out_(options),
        reference_(template_of(options)),
        landmarks_(landmarks_of(options, out_.scan_space))
  {
    prepare::check_fibre_names(landmarks_, reference_.joint.ligaments);
  }

  core::ExitCode run()
  {
    if (!out_.files.is_locked()) return core::ExitCode::interrupted;
    const bool has_meshes = !options_.fibula.empty() || !options_.menisci.empty() ||
                            std::ranges::any_of(options_.bones, [](const auto& bone) {
                              return !bone.second.bone.empty() || !bone.second.cartilage.empty();
                            });
    if (has_meshes || options_.landmarks.empty()) {
      prepare_meshes();
    } else {
      prepare_scaled_template();
    }
    if (core::is_interrupted()) return core::ExitCode::interrupted;
    job::Case prepared = options_.has_ligaments ? case_with_ligaments() : written_case(false);
    if (core::is_interrupted()) return core::ExitCode::interrupted;
    if (has_patella()) prepared = case_with_patella();
    return write(prepared);
  }

 private:
  void prepare_meshes()
  {
    out_.subject = subject_of(options_, out_.warnings);
    check_output();
    Json copies = simplify_copies(out_.subject, scanned_unit_mm(), options_);
    KneeSurfaces surfaces{surfaces_of(out_.subject.reference), surfaces_of(out_.subject.moving)};
    geometry::KneeFitOptions known;
    if (!options_.side.empty()) known.side = side_named(options_.side);
    if (!options_.unit.empty()) known.unit_mm = job::mm_per_unit(options_.unit);
    refuse_thickness(surfaces);
    known.femur_points = prepare::known_points(landmarks_, reference_, prepare::Bone::femur);
    known.tibia_points = prepare::known_points(landmarks_, reference_, prepare::Bone::tibia);
    core::log_info("registering \"" + reference_.joint.title + "\" onto the bones");
    known.is_stopped = core::is_interrupted;
    known.n_threads = run::thread_count_or_all(options_.n_threads);
    fit_ = geometry::fit_knee(surfaces, reference_.knee, known);
    if (core::is_interrupted()) return;
    recognise_generated_knee(surfaces, known);
    name_by_side(out_.subject.reference, fit_.unit_mm, fit_.X_scan_femur, fit_.side);
    name_by_side(out_.subject.moving, fit_.unit_mm, fit_.X_scan_tibia, fit_.side);
    Json cleaned = Json::object();
    const bool has_left_out = leave_specks_out(out_.subject, fit_, options_, cleaned, out_.warnings);
    if (smooth_noise(out_.subject, fit_.unit_mm, options_, cleaned, out_.warnings) || has_left_out) {
      copies = simplify_copies(out_.subject, fit_.unit_mm, options_);
      surfaces = {surfaces_of(out_.subject.reference), surfaces_of(out_.subject.moving)};
      fit_ = geometry::fit_knee(surfaces, reference_.knee, known);
      if (core::is_interrupted()) return;
    }
    out_.report = fit_json(fit_);
    out_.report.update(cleaned);
    if (!copies.is_null()) out_.report["copies"] = copies;
    const std::optional<InputError::Facts> wrong_part =
        app::wrong_part(out_.subject, surfaces, fit_.unit_mm, out_.warnings);
    move_to_frame(out_.subject.reference, fit_.unit_mm, fit_.X_scan_femur);
    move_to_frame(out_.subject.moving, fit_.unit_mm, fit_.X_scan_tibia);
    move_to_frame(out_.subject.patella, fit_.unit_mm, fit_.X_scan_femur);
    refuse_other_objects(surfaces, known, wrong_part);
    if (core::is_interrupted()) return;
    if (wrong_part) throw InputError(*wrong_part);
    core::log_info("side " + side_name(fit_.side) + ", unit " + job::unit_of_mm(fit_.unit_mm) +
                   ", scanned at " + short_decimal(deg_from_rad(fit_.scanned.flexion_rad), 0) +
                   " degrees of flexion");
    const std::vector<std::string> doubts = geometry::fit_warnings(fit_, surfaces, known.side.has_value());
    out_.warnings.insert(out_.warnings.end(), doubts.begin(), doubts.end());
    if (reference_.joint.frame.side != fit_.side) reference_ = prepare::mirrored(reference_);
    check_fibula();
    warn_of_one_compartment(out_.subject, out_.warnings);
    add_landmarks();
    add_cartilage(options_, fit_, surfaces, out_.subject, out_.report, out_.warnings);
    if (options_.menisci.empty())
      out_.warnings.push_back("no menisci given: the knee is modelled without them");
  }

  // Before the fit, which finds the same one.
  double scanned_unit_mm() const
  {
    if (!options_.unit.empty()) return job::mm_per_unit(options_.unit);
    return geometry::unit_mm_of(joined(surfaces_of(out_.subject.reference)),
                                joined(surfaces_of(out_.subject.moving)));
  }

  // The knee of `vrda shape` has no shafts in its bones' files; its own template needs none.
  void recognise_generated_knee(const KneeSurfaces& surfaces, const geometry::KneeFitOptions& known)
  {
    if (!options_.template_job.empty() || geometry::rejection_reasons(fit_, surfaces).empty()) return;
    prepare::TemplateJoint generated = prepare::generated_knee();
    const KneeFit fit = geometry::fit_knee(surfaces, generated.knee, known);
    if (core::is_interrupted() || !geometry::is_template_itself(fit) ||
        !geometry::rejection_reasons(fit, surfaces).empty())
      return;
    core::log_info("the bones are those of the generated knee, which is the template");
    fit_ = fit;
    reference_ = std::move(generated);
  }

  // Landmarks alone: the bones are the template's, by three factors each.
  void prepare_scaled_template()
  {
    if (options_.side.empty())
      throw InputError({"--side", "", "nothing", "left or right: landmarks alone do not determine the side"});
    if (is_thickness(options_.cartilage))
      throw InputError({"--cartilage", "", options_.cartilage,
                        "no thickness: without meshes the bones are the "
                        "template's with their cartilage"});
    fit_.side = side_named(options_.side);
    if (reference_.joint.frame.side != fit_.side) reference_ = prepare::mirrored(reference_);
    const double unit_mm = options_.unit.empty() ? 1.0 : job::mm_per_unit(options_.unit);
    const prepare::LandmarkScales scales = prepare::landmark_scales(landmarks_, reference_, unit_mm);
    fit_.femur.scale = scales.femur.factor;
    fit_.tibia.scale = scales.tibia.factor;
    out_.report = scales_json(scales, fit_.side);
    out_.warnings = scales.warnings;
    out_.warnings.push_back("no meshes given: the bones are those of \"" + reference_.joint.title +
                            "\", scaled");
    const job::Case& joint = reference_.joint;
    out_.subject = {scaled_parts(joint.reference, fit_.femur.scale, reference_.knee.origin_mm),
                    scaled_parts(joint.moving, fit_.tibia.scale, reference_.knee.origin_mm)};
    set_file_names(out_.subject);
    check_output();
  }

  // Before the long part; no input may be replaced.
  void check_output() const
  {
    std::vector<std::string> names;
    if (options_.has_ligaments) names = {"ligaments.csv", "wraps.json"};
    if (has_patella()) names.insert(names.end(), {"patella.stl", "patella_fibres.csv", "patella_wraps.json"});
    out_.check_output(names);
  }

  void check_fibula()
  {
    for (const SubjectPart& part : out_.subject.moving) {
      if (part.component.name != "fibula") continue;
      BoneSurfaces tibia = surfaces_of(out_.subject.moving);
      if (tibia.bone.triangles.rows() == 0) {  // only cartilage is given, far from the fibula: the template's
        const Mesh& bone = reference_.knee.surfaces.tibia.bone;
        tibia.bone = bone;
        tibia.bone.vertices_mm = (bone.vertices_mm.rowwise() - reference_.knee.origin_mm.transpose()) *
                                 fit_.tibia.scale.asDiagonal();
      }
      const std::string found = geometry::fibula_rejection(part.working(), joined(tibia), fit_.size);
      if (!found.empty())
        throw InputError({part.file, "--fibula", found, "the fibula beside this tibia, in the scan's unit"});
      if (!geometry::is_fibula_lateral(part.working(), fit_.side))
        out_.warnings.push_back("--fibula: its head is not lateral of the tibia; check it and the side");
    }
  }

  void refuse_thickness(const KneeSurfaces& surfaces) const
  {
    const bool has_bare =
        surfaces.femur.cartilage.triangles.rows() == 0 || surfaces.tibia.cartilage.triangles.rows() == 0;
    if (has_bare || !is_thickness(options_.cartilage)) return;
    throw InputError({"--cartilage", "", options_.cartilage + " and cartilage of both bones",
                      "no thickness, or a bone without --femur-cartilage or --tibia-cartilage"});
  }

  void add_landmarks()
  {
    if (!landmarks_.fibres.empty() && !options_.has_ligaments)
      out_.warnings.push_back("fibre: attachments are not used with --no-ligaments");
    if (!landmarks_.distances.empty())
      out_.warnings.push_back("distance: not used, since the meshes give the size");
    if (landmarks_.points.empty()) return;
    out_.report["landmarks"] = landmarks_json(
        landmarks_, prepare::landmark_residuals_mm(landmarks_, reference_, fit_), out_.warnings);
  }

  // In the frames of the bones, mm.
  std::vector<prepare::FibreEnds> known_ends() const
  {
    std::vector<prepare::FibreEnds> ends = landmarks_.fibres;
    for (prepare::FibreEnds& fibre : ends) {
      if (fibre.femur) fibre.femur = fit_.X_scan_femur.inverse() * (fit_.unit_mm * *fibre.femur);
      if (fibre.tibia) fibre.tibia = fit_.X_scan_tibia.inverse() * (fit_.unit_mm * *fibre.tibia);
    }
    return ends;
  }

  // The picture of a refused knee shows what went wrong.
  void refuse_other_objects(const KneeSurfaces& surfaces, const geometry::KneeFitOptions& known,
                            const std::optional<InputError::Facts>& wrong_part)
  {
    const std::vector<std::string> found = geometry::rejection_reasons(fit_, surfaces);
    if (found.empty()) return;
    core::log_info("the bones do not fit; looking for the reason");
    std::string reason = geometry::probable_cause(fit_, surfaces, reference_.knee, known);
    if (core::is_interrupted()) return;
    if (reason.empty() && wrong_part) throw InputError(*wrong_part);
    if (reason.empty()) {
      for (const std::string& one : found) reason += (reason.empty() ? "" : "; ") + one;
    }
    throw InputError({out_.subject.reference.front().file + ", " + out_.subject.moving.front().file, "",
                      reason,
                      "femur and tibia of one knee in one pose, similar to the template \"" +
                          reference_.joint.title + "\"" + refused_picture(reason)});
  }

  // Where it is; empty if the meshes cannot be drawn, for example in a wrong unit.
  std::string refused_picture(const std::string& reason)
  {
    try {
      out_.write_picture(written_case(false), "refused.png", "Refused: " + reason);
    } catch (const InputError&) {
      return "";
    }
    out_.files.publish("refused.png");
    return "; see " + out_.path_of("refused.png");
  }

  // Without one the landmarks only scale: they are in coordinates of their own.
  bool has_scan() const { return !out_.subject.reference.front().file.empty(); }

  std::string file(const std::string& name) const { return out_.files.file(name); }

  prepare::JobDescription description(bool has_ligaments) const
  {
    prepare::JobDescription job = out_.description();
    job.side = fit_.side;
    if (has_scan()) {
      job.scanned = fit_.scanned;
      job.X_scan_reference = fit_.X_scan_femur;
      job.scan_space = out_.scan_space;
      job.scan_unit = job::unit_of_mm(fit_.unit_mm);
    }
    job.has_ligaments = has_ligaments;
    job.has_prior = options_.has_prior;
    job.has_wraps = has_ligaments && has_wraps_;
    job.patella = patella_;
    return job;
  }

  // The case of the files in the folder; the job is not written yet.
  job::Case written_case(bool has_ligaments) const { return out_.written_case(description(has_ligaments)); }

  void write_ligaments(const model::Ligaments& ligaments)
  {
    has_wraps_ = !ligaments.wraps.empty();
    write_atomically(
        file("ligaments.csv"),
        {prepare::ligament_table(ligaments, "Fibres of \"" + reference_.joint.title +
                                                "\" transferred by vrda prepare; mm, anatomical frames")});
    if (has_wraps_) write_atomically(file("wraps.json"), {prepare::wraps_text(ligaments)});
  }

  job::Case case_with_ligaments()
  {
    prepare::SubjectBones bones{{surfaces_of(out_.subject.reference), surfaces_of(out_.subject.moving)}, {}};
    for (const SubjectPart& part : out_.subject.moving) {
      if (part.component.name == "fibula") bones.fibula = part.working();
    }
    if (has_scan()) bones.known_ends = known_ends();
    const prepare::TransferredLigaments transferred = prepare::transferred_ligaments(reference_, fit_, bones);
    write_ligaments(transferred.ligaments);
    job::Case prepared = written_case(true);
    core::log_info("slack lengths of " + std::to_string(transferred.ligaments.fibres.size()) +
                   " fibres: the knee is solved at 10 flexions, at most 5 times");
    const int n_threads = run::thread_count_or_all(options_.n_threads);
    prepare::SlackLengths lengths(prepared, reference_.joint, n_threads, core::is_interrupted);
    prepare::SlackResult slack = lengths.set();
    const std::vector<prepare::BundleCrossing> crossings =
        core::is_interrupted() ? std::vector<prepare::BundleCrossing>{}
                               : prepare::wrap_over_bones(prepared, lengths, slack);
    if (core::is_interrupted()) return prepared;
    write_ligaments(prepared.ligaments);
    if (has_wraps_) prepared = written_case(true);  // its job names the wraps
    out_.report["fibres"] = fibres_json(transferred, slack);
    out_.report["bundles"] = bundles_json(prepared.ligaments, slack, out_.warnings);
    out_.report["settled"] = {{"varus_deg", deg_from_rad(slack.settled.attitude.varus_rad)},
                              {"travel_mm", slack.settled.pose.translation_mm.y()},
                              {"has_contact", slack.settled.has_contact}};
    out_.report["fibres_lengthened"] = slack.lengthenings;
    if (!crossings.empty()) out_.report["bone_crossings"] = crossings_json(crossings, out_.warnings);
    out_.report["solved_flexions"] = {slack.loads.n_solved, slack.loads.n_flexions};
    if (slack.loads.n_solved < slack.loads.n_flexions)
      out_.warnings.push_back("solved " + std::to_string(slack.loads.n_solved) + " of " +
                              std::to_string(slack.loads.n_flexions) + " flexions");
    return prepared;
  }

  bool has_patella() const { return options_.has_template_patella || !options_.patella.empty(); }

  // Smaller than the joint's: it is not known how far the surfaces that are drawn were apart.
  double kneecap_offset_mm(const prepare::Kneecap& cap)
  {
    constexpr double most_mm = 6.0, doubted_overlap_mm = -1.0;
    if (std::isnan(cap.residual_mm) || options_.cartilage == "none") return 0.0;
    double added_mm = 0.0;
    for (const SubjectPart& part : out_.subject.reference)
      added_mm = std::max(added_mm, -part.component.inset_mm);
    const std::string where = options_.patella + ": --patella: ";
    if (cap.gap_mm < doubted_overlap_mm)
      out_.warnings.push_back(where + fixed_text(-cap.gap_mm, 1) + " mm inside the femur in the scan");
    const double gap_mm = cap.gap_mm - added_mm;
    if (gap_mm > most_mm)
      out_.warnings.push_back(where + fixed_text(cap.gap_mm, 1) +
                              " mm from the femur in the scan; layers of " + shortest_decimal(most_mm) +
                              " mm in all are assumed");
    return std::round(100.0 * std::clamp(gap_mm, 0.0, most_mm)) / 100.0;
  }

  job::Case case_with_patella()
  {
    constexpr double scan_strain = 0.02;  // of a relaxed knee
    const prepare::SubjectBones bones{{surfaces_of(out_.subject.reference), surfaces_of(out_.subject.moving)},
                                      {}};
    const bool is_scanned = !out_.subject.patella.empty();
    const prepare::Kneecap cap =
        is_scanned ? prepare::registered_kneecap(reference_, fit_, bones, surfaces_of(out_.subject.patella),
                                                 options_.patella)
                   : prepare::fitted_kneecap(reference_, fit_, bones);
    prepare::JobKneecap patella;
    patella.centre_mm = cap.centre_mm;
    patella.scanned = cap.scanned;
    if (is_scanned && has_scan()) patella.scanned_joint = fit_.scanned.rows();
    patella.directions = reference_.patella->directions;
    patella.has_wraps = !cap.ligaments.wraps.empty();
    const double offset_mm = kneecap_offset_mm(cap);
    place_patella(cap, offset_mm);
    for (const SubjectPart& part : out_.subject.patella) patella.components.push_back(part.component);
    patella_ = patella;
    const std::string comment = "Patella of \"" + reference_.joint.title + "\" " +
                                (is_scanned ? "registered" : "fitted to the femur") +
                                " by vrda prepare; mm, anatomical frames";
    write_atomically(file("patella_fibres.csv"),
                     {prepare::follower_table(cap.ligaments, {"patella"}, scan_strain, comment)});
    if (patella.has_wraps)
      write_atomically(file("patella_wraps.json"), {prepare::wraps_text(cap.ligaments, {"patella"})});
    out_.report["patella"] = kneecap_json(cap, offset_mm);
    if (!is_scanned)
      out_.warnings.push_back("patella: that of \"" + reference_.joint.title +
                              "\", fitted to the femur: illustrative; --patella gives the scanned one");
    return written_case(options_.has_ligaments);
  }

  // Its surfaces in the frame of the job, with the layer that the scan shows as a gap.
  void place_patella(const prepare::Kneecap& cap, double offset_mm)
  {
    std::vector<SubjectPart> placed;
    const auto add = [&](const Mesh& mesh, const char* name, const char* material) {
      if (mesh.triangles.rows() == 0) return;
      SubjectPart part;
      part.component = {name, material};
      part.component.inset_mm = offset_mm > 0.0 ? -offset_mm : 0.0;
      part.mesh = mesh;
      placed.push_back(part);
    };
    add(cap.surfaces.bone, "patella", "bone");
    add(cap.surfaces.cartilage, "patella_cartilage", "cartilage");
    out_.subject.patella = placed;
  }

  core::ExitCode write(const job::Case& prepared)
  {
    out_.write_picture(prepared, "prepare.png");
    for (const std::vector<SubjectPart>* parts : {&out_.subject.reference, &out_.subject.moving}) {
      for (const SubjectPart& part : *parts) {
        if (options_.keeps_triangles && part.simpler.triangles.rows() > 0)
          out_.write_mesh(part.component.name, part.mesh);
      }
    }
    out_.report["template"] = reference_.joint.title;
    return out_.publish(prepared.job_text, {"ligaments.csv", "wraps.json", "patella.stl",
                                            "patella_fibres.csv", "patella_wraps.json", "refused.png"});
  }

  const PrepareOptions& options_;
  Prepared out_;
  prepare::TemplateJoint reference_;  // of a right knee, until the side is known
  prepare::KneeLandmarks landmarks_;
  KneeFit fit_;
  std::optional<prepare::JobKneecap> patella_;
  bool has_wraps_ = false;
};

// Each option that only some joints have.
void require_options_of_joint(const PrepareOptions& o)
{
  struct Row {
    std::string option;
    bool is_given;
    std::vector<std::string> joints;
  };
  std::vector<Row> rows{
      Row{"--fibula", !o.fibula.empty(), {"knee", "ankle"}},
      Row{"--meniscus", !o.menisci.empty(), {"knee"}},
      Row{"--patella", !o.patella.empty(), {"knee"}},
      Row{"--template-patella", o.has_template_patella, {"knee"}},
      Row{"--template", !o.template_job.empty(), {"knee"}},
      Row{"--no-ligaments", !o.has_ligaments, {"knee", "ankle"}},
      Row{"--no-prior", !o.has_prior, {"knee"}},
      Row{"--keep-specks", o.keeps_specks, {"knee"}},
      Row{"--every-triangle", o.keeps_triangles, {"knee"}},
  };
  for (const auto& [name, files] : o.bones) {
    Row row{"--" + name, !files.bone.empty(), {}};
    for (const char* joint : {"knee", "hip", "ankle", "subtalar"}) {
      const prepare::JointBones bones = prepare::bones_of(joint);
      if (bones.reference == name || bones.moving == name) row.joints.emplace_back(joint);
    }
    rows.push_back(row);
    rows.push_back({row.option + "-cartilage", !files.cartilage.empty(), row.joints});
  }
  for (const auto& [option, is_given, joints] : rows) {
    if (!is_given || std::find(joints.begin(), joints.end(), o.joint) != joints.end()) continue;
    const prepare::JointBones bones = prepare::bones_of(o.joint);
    throw InputError({option, "", "--joint " + o.joint,
                      "--joint " + joints[0] + (joints.size() > 1 ? " or " + joints[1] : "") + "; a " +
                          o.joint + " joint has --" + bones.reference + " and --" + bones.moving});
  }
}

// Writes meshes in anatomical frames, job, ligaments, prepare.json and prepare.png, all at the end. Throws
// InputError for objects that are not the bones of one knee: then refused.png is the only file written.
core::ExitCode prepare_command(const PrepareOptions& options)
{
  run::require_plain_text("--output", fs::path(options.folder).stem().string());
  require_options_of_joint(options);
  core::install_signal_handlers();
  if (options.joint != "knee") return prepare_other_joint(options);
  return Preparation(options).run();
}

}  // namespace

void declare_prepare(Command& c)
{
  auto& o = c.options<PrepareOptions>();
  const std::vector<std::string> bones{"femur", "tibia", "pelvis", "talus", "calcaneus"};
  c.option("--joint", o.joint,
           "knee (femur, tibia), hip (pelvis, femur), ankle (tibia, talus) or subtalar (talus, calcaneus)")
      .one_of({"knee", "hip", "ankle", "subtalar"})
      .shows_default();
  for (const std::string& bone : bones)
    c.option("--" + bone, o.bones[bone].bone,
             "Mesh of the " + bone + (bone == "pelvis" ? ", or of the hip bone" : ""));
  for (const std::string& bone : bones)
    c.option("--" + bone + "-cartilage", o.bones[bone].cartilage, "Meshes of its cartilage").takes_several();
  c.option("--meniscus", o.menisci, "Meshes of the menisci, drawn only").takes_several();
  c.option("--fibula", o.fibula, "Mesh of the fibula, for the lateral ligaments; part of an ankle's mortise");
  const Option patella =
      c.option("--patella", o.patella, "Mesh of the patella, in the scan of the bones; it follows the joint");
  c.option("--patella-cartilage", o.patella_cartilage, "Meshes of its cartilage")
      .takes_several()
      .needs(patella);
  c.flag("--template-patella", o.has_template_patella,
         "Without a mesh: the template's patella, fitted to the femur, as an illustration")
      .excludes(patella);
  c.option(
      "--landmarks", o.landmarks,
      "Known points of the joint, TOML (schemas/prepare.md) or of 3D Slicer; of a knee without meshes, they "
      "scale the template's bones");
  c.option("--side", o.side, "left or right; default: found").one_of({"left", "right"});
  c.option("--unit", o.unit, "mm, cm or m; default: found").one_of({"mm", "cm", "m"});
  c.option("--cartilage", o.cartilage, "auto, none, or mm: thickness added to a bone without cartilage")
      .number(0.0, 10.0, {"auto", "none"})
      .shows_default();
  const Option job =
      c.option("--template", o.template_job, "Job of a knee with ligaments; default: the generic knee");
  c.data(o.data_directory, "Base folder of the template's file names").needs(job);
  c.flag_for(
      "--no-ligaments", [&o] { o.has_ligaments = false; }, "Write no ligaments");
  c.flag_for(
      "--no-prior", [&o] { o.has_prior = false; },
      "Write no prior of the motion: bones and fibres alone (schemas/prior.md)");
  c.flag("--keep-specks", o.keeps_specks,
         "Keep small separate pieces in the joint space; default: they are left out, with a warning");
  c.flag(
      "--every-triangle", o.keeps_triangles,
      "Write meshes beyond 200,000 triangles in all as they are; default: copies within 0.05 mm, which vrda "
      "run solves several times as fast");
  c.flag("--no-smooth", o.keeps_noise,
         "Leave rough surfaces as they are; default: where noise is measured, they are smoothed without "
         "shrinking, with a warning");
  c.option("-o,--output", o.folder, "Output folder").required();
  c.flag("--replace", o.may_replace, "Replace existing files, such as those of an earlier preparation");
  c.threads(o.n_threads);
  c.json(o.as_json, "Print prepare.json");
  c.runs([&o] { return prepare_command(o); });
}

}  // namespace vrda::app

// `vrda info` and `validate`: what a motion model contains, and gaps and penetrations measured again.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <future>
#include <limits>
#include <nlohmann/json.hpp>

#include "analysis/audit.hpp"
#include "analysis/flexion_curves.hpp"
#include "analysis/reduce.hpp"
#include "app/commands.hpp"
#include "app/printing.hpp"
#include "core/document.hpp"
#include "core/fields_json.hpp"
#include "core/text.hpp"
#include "model/coordinates.hpp"
#include "model/mesh.hpp"
#include "report/model_json.hpp"
#include "run/result.hpp"
#include "run/run_output.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "store/solved_cells.hpp"
#include "store/verdict.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;

struct InfoOptions {
  std::string file;
  bool as_json = false;
};

template <typename Values>
Json range_json(const Values& values)
{
  return {{"min", store::smallest_of(values)}, {"max", store::largest_of(values)}};
}

std::vector<double> values_of(const store::GridD& surface)
{
  return {surface.data(), surface.data() + surface.size()};
}

// Of frames, whose theta is found from their poses.
Json theta_json(const store::MotionModel& model)
{
  if (!model.frames) return range_json(model.theta_deg);
  return range_json(unwrapped(values_of(model.theta_deg), 360.0));
}

// Internal rotation along the spine: the screw-home motion of the joint.
Json screw_home(const store::MotionModel& model)
{
  const store::FlexionCurve rotation = store::spine_rotation(model);
  const store::CurveFigures f = store::curve_figures(rotation);
  Json curve = Json::array();
  std::size_t row = 0;
  for (Eigen::Index cell = 0; cell < model.is_spine.size(); ++cell) {
    if (model.is_spine.data()[cell] != 1) continue;
    const auto varus = static_cast<std::size_t>(cell % model.is_spine.cols());
    curve.push_back({{"flexion_deg", rotation.flexion_deg[row]},
                     {"varus_deg", model.varus_deg[varus]},
                     {"internal_rotation_deg", rotation.value[row]}});
    ++row;
  }
  return {{"net", {{"deg", f.net_deg}, {"from_flexion_deg", f.first_deg}, {"to_flexion_deg", f.last_deg}}},
          {"peak", {{"deg", f.peak_deg}, {"flexion_deg", f.peak_at_deg}}},
          {"largest_change",
           {{"deg", f.change_deg},
            {"within_deg", store::change_window_deg},
            {"from_flexion_deg", f.change_from_deg},
            {"to_flexion_deg", f.change_to_deg}}},
          {"spine", curve}};
}

// Null where theta does not jump along the spine.
Json spine_jump_json(const store::MotionModel& model)
{
  const store::SpineJump jump = store::spine_jump(model);
  if (store::text_of(jump).empty() || store::has_turned_axes(model)) return {};
  return {{"deg", jump.change_deg}, {"from_flexion_deg", jump.from_deg}, {"to_flexion_deg", jump.to_deg}};
}

// Null unless no polynomial follows the raw motion.
Json jump_json(const store::MotionModel& model)
{
  const analysis::RawJump jump = analysis::raw_jump(model);
  if (jump.size <= analysis::largest_raw_jump) return {};
  return {{"perceptible_errors", jump.size},
          {"from_flexion_deg", jump.from_deg},
          {"to_flexion_deg", jump.to_deg}};
}

Json default_motion_json(const store::MotionModel& model)
{
  const store::DefaultMotion shown = store::default_motion(model);
  return {{"set", shown.set},
          {"reason", shown.reason},
          {"is_compared", model.default_motion.has_value()},
          {"statement", shown.statement}};
}

// Attitudes that are not stable, in attitude order.
Json unsolved_json(const store::MotionModel& model)
{
  Json list = Json::array();
  for (Eigen::Index i = 0; i < model.status.rows(); ++i) {
    for (Eigen::Index j = 0; j < model.status.cols(); ++j) {
      const auto status = static_cast<StepStatus>(model.status(i, j));
      if (status == StepStatus::stable) continue;
      list.push_back({{"flexion_deg", model.flexion_deg[static_cast<std::size_t>(i)]},
                      {"varus_deg", model.varus_deg[static_cast<std::size_t>(j)]},
                      {"status", name_of(status)}});
    }
  }
  return list;
}

Json doubtful_json(const store::MotionModel& model)
{
  Json list = Json::array();
  for (const run::DoubtfulCell& cell : run::doubtful_cells(model)) {
    list.push_back({{"flexion_deg", cell.flexion_deg},
                    {"varus_deg", cell.varus_deg},
                    {"plausibility", name_of(cell.plausibility)}});
    if (!cell.follower.empty()) list.back()["follower"] = cell.follower;
  }
  return list;
}

Json iterations_json(const store::MotionModel& model)
{
  const double n = static_cast<double>(model.iterations.size());
  return {{"mean", static_cast<double>(model.iterations.cast<std::int64_t>().sum()) / n},
          {"largest", model.iterations.maxCoeff()},
          {"queries_mean", static_cast<double>(model.queries.cast<std::int64_t>().sum()) / n}};
}

Json smoothed_json(const store::MotionModel& model)
{
  Json sets = Json::array();
  for (const store::SmoothedSet& set : model.smoothed) {
    Json surfaces = Json::object();
    for (const store::SmoothedSurface& s : set.surfaces) {
      surfaces[s.name] = {{"rms", s.rms}, {"largest_residual", s.largest_residual}, {"cells", s.n_cells}};
    }
    for (const store::SmoothedFollower& follower : set.followers) {
      for (const store::SmoothedSurface& s : follower.surfaces)
        surfaces[follower.name + " " + s.name] = {
            {"rms", s.rms}, {"largest_residual", s.largest_residual}, {"cells", s.n_cells}};
    }
    sets.push_back({{"degree", set.degree}, {"surfaces", surfaces}});
  }
  return sets;
}

// Largest share over all cells of the contact force along Delta that a compartment carries.
double largest_share(const store::ForceRows& forces, Compartment compartment)
{
  std::vector<double> shares;
  for (std::size_t cell = 0; cell + 1 < forces.row_start.size(); ++cell) {
    const store::CellForces of_cell = store::forces_in(forces, cell);
    if (of_cell.all_n > 0.0)
      shares.push_back(of_cell.of_n[static_cast<std::size_t>(compartment)] / of_cell.all_n);
  }
  return store::largest_of(shares);
}

Json equilibrium_json(const store::MotionModel& model)
{
  if (!model.equilibrium) return {};
  const store::EquilibriumSurfaces& e = *model.equilibrium;
  const auto n_several =
      std::count_if(e.spine.n_optima.begin(), e.spine.n_optima.end(), [](std::int32_t n) { return n > 1; });
  return {{"worst_gap_mm", store::smallest_of(e.worst_gap_mm)},
          {"largest_balance_residual_n", store::largest_of(e.balance_residual_n)},
          {"largest_share",
           {{"medial", largest_share(e.forces, Compartment::medial)},
            {"lateral", largest_share(e.forces, Compartment::lateral)}}},
          {"flexions_with_several_optima", n_several}};
}

// For free varus reports the range of solved angles; the grid then has a single column.
Json grid_json(const store::MotionModel& model, const store::ClinicalSurfaces& clinical)
{
  const bool is_varus_free = store::Motion(model, "raw").is_varus_free();
  // The attitudes of frames are found from their poses, like the joint's own angles.
  const bool has_own_axes = model.frames && !store::has_turned_axes(model);
  const auto axis = [](const std::vector<double>& values) {
    return Json{values.front(), values.back(), values.size()};
  };
  const std::vector<double> flexions = has_own_axes   ? values_of(clinical[JointCoordinate::flexion])
                                       : model.frames ? unwrapped(model.flexion_deg, 360.0)
                                                      : model.flexion_deg;
  const store::GridD& varus = has_own_axes ? clinical[JointCoordinate::varus] : model.varus_solved_deg;
  const auto role = [&](std::size_t c) {
    return model.coordinates          ? name_of(static_cast<CoordinateRole>(model.coordinates->role[c]))
           : model.method == "import" ? "measured"
           : c < 1 || (c == 1 && !is_varus_free) ? "driven"
                                                 : "free";
  };
  Json roles = Json::object();
  for (std::size_t c = 0; c < n_joint_coordinates; ++c) roles[joint_coordinate_names[c]] = role(c);
  Json undetermined = Json::object();
  for (std::size_t c = 0; model.coordinates && c < n_joint_coordinates; ++c) {
    int n = 0;
    for (std::size_t at = c; at < model.coordinates->determined.size(); at += n_joint_coordinates)
      n += model.coordinates->determined[at] == 0 ? 1 : 0;
    if (n > 0) undetermined[joint_coordinate_names[c]] = n;
  }
  return {{"roles", roles},
          {"undetermined", undetermined},
          {"flexion_deg", Json{store::smallest_of(flexions), store::largest_of(flexions), flexions.size()}},
          {"varus_deg", is_varus_free ? Json() : axis(model.varus_deg)},
          {"varus_is_free", is_varus_free},
          {"varus_found_deg", is_varus_free ? range_json(varus) : Json()}};
}

Json samples_json(const store::MotionModel& model)
{
  if (!model.uncertainty) return {};
  const store::UncertainMotion& motion = *model.uncertainty;
  return {{"samples", motion.n_samples()},
          {"poses", motion.status.size()},
          {"stable", std::count(motion.status.begin(), motion.status.end(), status_stable)}};
}

Json frames_json(const store::MotionModel& model)
{
  if (!model.frames) return {};
  const std::vector<double>& key = model.frames->key;
  return {{"key_name", model.frames->key_name}, {"key", {key.front(), key.back(), key.size()}}};
}

using TwoSidedByMotion = std::vector<std::pair<std::string, store::TwoSidedFigures>>;

// The gap alone finds most poses free, in a tenth of the time of `vrda audit`. Of the joint: followers are
// not printed.
store::AuditSet measured_again(const store::MotionModel& model, const std::string& set,
                               analysis::AuditScenes& scenes)
{
  return analysis::audit_joint(model, set, 1, {run::thread_count_or_all(0), &scenes},
                               analysis::OverlapTest::sweep);
}

// Raw and two-sided motion measured again, the others as audited.
TwoSidedByMotion two_sided_by_motion(const store::MotionModel& model, const analysis::AuditFigures& raw,
                                     analysis::AuditScenes& scenes)
{
  TwoSidedByMotion motions{{"raw", raw.two_sided}};
  if (model.two_sided)
    motions.emplace_back("two_sided", store::two_sided_figures(measured_again(model, "two_sided", scenes)));
  for (const store::AuditSet& audit : model.audits) {
    if (audit.name != "raw" && audit.name != "two_sided")
      motions.emplace_back(audit.name, store::two_sided_figures(audit));
  }
  return motions;
}

Json motions_json(const TwoSidedByMotion& motions)
{
  Json list = Json::object();
  for (const auto& [name, figures] : motions) {
    if (figures.n_poses > 0) list[name] = report::two_sided_json(figures);
  }
  return list;
}

// Ranges and values along the spine, whose flexions are in screw_home.
Json curves_json(const std::vector<analysis::CurveGroup>& curves)
{
  Json list = Json::object();
  for (const analysis::CurveGroup& group : curves) {
    for (const analysis::Curve& curve : group.curves) {
      Json one = {{"title", group.title}, {"label", curve.label}, {"unit", group.unit}};
      one.update(range_json(curve.values));
      one["spine"] = curve.values;
      list[curve.name] = one;
    }
  }
  return list;
}

std::string short_text(const Json& number)
{
  return number.is_null() ? "none" : formatted("%.4g", number.get<double>());
}

// Ranges of their coordinates and the certificate, over the cells with a pose.
Json followers_json(const store::MotionModel& model)
{
  Json list = Json::array();
  for (const store::FollowerRows* follower : store::in_order(model.followers)) {
    Json one = {{"name", follower->name},
                {"stable", (follower->status == status_stable).count()},
                {"attitudes", follower->status.size()},
                {"has_reaction", follower->has_reaction}};
    for (std::size_t k = 0; k < n_joint_coordinates; ++k)
      one[std::string(follower_coordinate_names[k]) + unit_suffix(k)] = range_json(follower->coordinates[k]);
    one["worst_gap_mm"] = store::smallest_of(follower->worst_gap_mm);
    one["largest_balance_residual_n"] = store::largest_of(follower->balance_residual_n);
    list.push_back(one);
  }
  return list;
}

void print_followers(const Json& s)
{
  for (const Json& follower : s["followers"]) {
    print_filled("{name} follows: {stable} of {attitudes} attitudes solved", follower);
    std::printf("%s\n", follower["has_reaction"].get<bool>() ? ", with its reaction on the joint" : "");
    if (follower["stable"] == 0) continue;  // no ranges
    for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
      const Json& range = follower[std::string(follower_coordinate_names[k]) + unit_suffix(k)];
      std::printf("  %-9s %s to %s %s\n", follower_coordinate_names[k], short_text(range["min"]).c_str(),
                  short_text(range["max"]).c_str(), is_rotation(k) ? "degrees" : "mm");
    }
  }
}

// `verdict`: on the default motion.
Json summary_of(const store::MotionModel& model, const analysis::AuditFigures& measured,
                const TwoSidedByMotion& motions, const std::vector<analysis::CurveGroup>& curves,
                const std::optional<store::Verdict>& verdict)
{
  const auto n_stable = (model.status == status_stable).count();
  const bool has_gap = n_stable > 0 && measured.n_nothing_ahead == 0;
  const store::ClinicalCurves clinical = store::clinical_curves(model);
  Json statuses = Json::object();
  for (const auto& [name, n] : run::cells_by_status(model)) statuses[name] = n;
  return {{"title", model.title},
          {"joint", model.joint},
          {"side", model.side},
          {"method", model.method},
          {"grid", grid_json(model, clinical.surfaces)},
          {"frames", frames_json(model)},
          {"scaling", run::scaling_json(model.job.scaling)},
          {"warnings", model.job.warnings},
          {"status", statuses},
          {"triangles",
           {{"reference", model.reference.contact.mesh.triangles.rows()},
            {"moving", model.moving.contact.mesh.triangles.rows()}}},
          {"unsolved", unsolved_json(model)},
          {"doubtful", doubtful_json(model)},
          {"samples", samples_json(model)},
          {"iterations", iterations_json(model)},
          {"surfaces",
           {{"tx_mm", range_json(model.tx_mm)},
            {"ty_mm", range_json(model.ty_mm)},
            {"tz_mm", range_json(model.tz_mm)},
            {"theta_deg", theta_json(model)}}},
          {"axes_are_turned", store::has_turned_axes(model)},
          {"clinical",
           {{"flexion_deg", range_json(clinical.surfaces[0])},
            {"varus_deg", range_json(clinical.surfaces[1])},
            {"internal_rotation_deg", range_json(clinical.surfaces[2])}}},
          {"gimbal_lock_poses", clinical.n_locked},
          {"default_motion", default_motion_json(model)},
          {"verdict", json_value(verdict)},
          {"screw_home", screw_home(model)},
          {"curves", curves_json(curves)},
          {"spine_jump", spine_jump_json(model)},
          {"jump", jump_json(model)},
          {"remeasured",
           {{"overlapping_attitudes", measured.n_overlapping},
            {"attitudes", n_stable},
            {"largest_penetration_mm", n_stable > 0 ? Json(measured.largest_penetration.value_mm) : Json()},
            {"largest_gap_mm", has_gap ? Json(measured.largest_gap.value_mm) : Json()},
            {"resolution_mm", model.contact_resolution_mm}}},
          {"two_sided", motions_json(motions)},
          {"zero_varus_cut_off", model.zero_varus ? Json(std::count(model.zero_varus->is_cut_off.begin(),
                                                                    model.zero_varus->is_cut_off.end(), 1))
                                                  : Json()},
          {"equilibrium", equilibrium_json(model)},
          {"fibres", model.ligaments ? model.ligaments->name.size() : 0},
          {"followers", followers_json(model)},
          {"smoothed", smoothed_json(model)}};
}

void print_extent(const char* name, const Json& axis)
{
  std::printf("  %-8s ", name);
  print_filled("{0%g} to {1%g} degrees, {2} values\n", axis);
}

void print_varus(const char* name, const Json& grid)
{
  if (!grid["varus_is_free"].get<bool>()) {
    print_extent(name, grid["varus_deg"]);
    return;
  }
  const Json& found = grid["varus_found_deg"];
  const std::string role = grid["roles"]["varus"];
  std::printf("  %-8s %s, %s %s to %s degrees\n", name, role.c_str(), role == "free" ? "found from" : "from",
              short_text(found["min"]).c_str(), short_text(found["max"]).c_str());
}

// With Delta other than proximal the attitude has other angles than the joint.
void print_angles(const Json& s, const JointKind& kind)
{
  const Json& grid = s["grid"];
  if (!s["axes_are_turned"].get<bool>()) {
    print_extent(label_of(kind, JointCoordinate::flexion).c_str(), grid["flexion_deg"]);
    print_varus(label_of(kind, JointCoordinate::varus).c_str(), grid);
  } else {
    std::printf("joint's own angles (Grood-Suntay, /clinical), degrees\n");
    std::size_t coordinate = 0;
    for (const auto& [name, range] : s["clinical"].items()) {
      const std::string role = grid["roles"][joint_coordinate_names[coordinate]];
      const std::string label = label_of(kind, static_cast<JointCoordinate>(coordinate++));
      std::printf("  %-22s %s, %s to %s\n", has_own_words(kind) ? label.c_str() : name.c_str(), role.c_str(),
                  short_text(range["min"]).c_str(), short_text(range["max"]).c_str());
    }
    const Json& varus = grid["varus_is_free"].get<bool>() ? grid["varus_found_deg"] : grid["varus_deg"];
    const bool is_range = varus.is_object();
    std::printf(
        "  Delta is not proximal: attitude and theta are about axes turned with it, flexion %g to %g, "
        "varus %s to %s\n",
        grid["flexion_deg"][0].get<double>(), grid["flexion_deg"][1].get<double>(),
        short_text(is_range ? varus["min"] : varus[0]).c_str(),
        short_text(is_range ? varus["max"] : varus[1]).c_str());
  }
  for (const auto& [name, n] : grid["undetermined"].items())
    std::printf("  %s is not determined at %d attitudes\n", name.c_str(), n.get<int>());
}

void print_equilibrium(const store::MotionModel& model, const Json& s)
{
  if (!model.equilibrium) return;
  print_filled(
      "equilibrium: worst gap {equilibrium.worst_gap_mm%.4g} mm, largest balance residual "
      "{equilibrium.largest_balance_residual_n%.4g} N, {fibres} fibres\n",
      s);
  if (model.has_compartments)
    print_filled(
        "  largest share of the contact force along Delta: medial {medial%.4g}, lateral {lateral%.4g}\n",
        s["equilibrium"]["largest_share"]);
  print_filled("  flexions with several optima: {equilibrium.flexions_with_several_optima}\n", s);
}

void print_doubtful(const store::MotionModel& model)
{
  if (run::doubtful_cells(model).empty()) return;
  std::printf("of the stable attitudes: %s\n", run::plausibility_line(model).c_str());
  for (const Plausibility plausibility : doubtful_plausibilities) {
    if (run::has_any(model, plausibility))
      std::printf("  %s: %s\n", name_of(plausibility), meaning_of(plausibility));
  }
}

void print(const store::MotionModel& model, const Json& s, const TwoSidedByMotion& motions,
           const std::optional<store::Verdict>& verdict)
{
  print_filled("{title}: {joint}, {side} side, {method}\n", s);
  if (model.prior) print_filled("{default_motion.statement}\n", s);
  for (const std::string& warning : model.job.warnings) std::printf("warning: %s\n", warning.c_str());
  run::print_scaling(s["scaling"]);
  if (!s["scaling"].is_null()) {
    std::printf("  steps solved %s\n",
                s["scaling"]["keeps_steps"].get<bool>() ? "at factor 1, then scaled" : "at this size");
  }
  if (model.frames) print_filled("  frames   {key.2} over {key_name}, {key.0%g} to {key.1%g}\n", s["frames"]);
  const JointKind& kind = joint_kind(model.joint);
  const bool has_stable = (model.status == status_stable).any();
  if (has_stable) print_angles(s, kind);
  const std::string lock = gimbal_lock_text(s["gimbal_lock_poses"].get<int>());
  if (!lock.empty()) std::printf("  %s\n", lock.c_str());
  std::printf("%s\n", run::status_line(model).c_str());
  if (model.uncertainty) std::printf("%s\n", run::samples_line(model).c_str());
  for (const StepStatus status : all_step_statuses) {
    const auto n = (model.status == static_cast<std::int8_t>(status)).count();
    if (status != StepStatus::stable && n > 0) {
      std::printf("  %s: %s\n", name_of(status), meaning_of(status));
    }
  }
  if (!has_stable) {
    std::printf("no attitude is stable: there are no ranges to print\n");
    return;
  }
  print_doubtful(model);
  print_filled("iterations: {mean%.4g} per step, at most {largest}; {queries_mean%.4g} queries per step\n",
               s["iterations"]);
  std::printf("surfaces (world, raw)\n");
  for (const auto& [name, range] : s["surfaces"].items()) {
    std::printf("  %-10s ", name.c_str());
    print_filled("{min%.4g} to {max%.4g}\n", range);
  }
  std::printf("%s\n", run::default_motion_line(model).c_str());
  const std::string rotation = run::screw_home_line(model);
  if (!rotation.empty()) std::printf("%s\n", rotation.c_str());
  if (verdict) {
    for (const std::string& line : store::lines_of(*verdict)) std::printf("%s\n", line.c_str());
  }
  for (const auto& [name, curve] : s["curves"].items()) {
    if (std::isfinite(curve["min"].get<double>()))
      print_filled("{title}, {label}: {min%.4g} to {max%.4g} {unit} along the spine\n", curve);
  }
  for (const std::string& jump : run::jump_lines(model)) std::printf("%s\n", jump.c_str());
  print_filled(
      "measured again at every stable attitude: largest penetration {largest_penetration_mm%.4g} mm "
      "({overlapping_attitudes} overlapping), largest gap {largest_gap_mm%.4g} mm, resolution "
      "{resolution_mm%.4g} mm\n",
      s["remeasured"]);
  print_two_sided(motions);
  const std::string cut_off = model.zero_varus ? analysis::cut_off_warning(*model.zero_varus) : "";
  if (!cut_off.empty()) std::printf("%s\n", cut_off.c_str());
  print_equilibrium(model, s);
  print_followers(s);
  for (const Json& set : s["smoothed"]) {
    print_filled("smoothed, degree {degree}\n", set);
    for (const auto& [name, surface] : set["surfaces"].items()) {
      std::printf("  %-10s ", name.c_str());
      print_filled("RMS {rms%.4g}, largest residual {largest_residual%.4g}, {cells} cells\n", surface);
    }
  }
}

core::ExitCode info_command(const InfoOptions& options)
{
  const store::MotionModel model = store::read_motion_model(options.file);
  const int n_threads = run::thread_count_or_all(0);
  // Each fills the other's serial parts.
  std::future<std::vector<analysis::CurveGroup>> curves =
      std::async(std::launch::async, [&] { return analysis::spine_curves(model, n_threads); });
  analysis::AuditScenes scenes(model, n_threads);
  const analysis::AuditFigures measured = analysis::figures_of(measured_again(model, "raw", scenes));
  const TwoSidedByMotion motions = two_sided_by_motion(model, measured, scenes);
  const auto verdict = store::verdict_of(model, store::default_motion(model).set);
  const Json summary = summary_of(model, measured, motions, curves.get(), verdict);
  if (options.as_json) return print_json(summary);
  print(model, summary, motions, verdict);
  return core::ExitCode::done;
}

core::ExitCode validate_command(const InfoOptions& options)
{
  const std::vector<store::Finding> findings = store::validate_hdf5(options.file);
  Json list = Json::array();
  for (const store::Finding& f : findings) {
    list.push_back({{"where", f.where}, {"found", f.found}, {"wanted", f.wanted}});
    // Formatted like an error: one printable line, whatever the file contains.
    if (!options.as_json) std::puts(InputError({options.file, f.where, f.found, f.wanted}).what());
  }
  if (options.as_json) print_json(list);
  if (findings.empty()) core::log_info(options.file + ": valid");
  return findings.empty() ? core::ExitCode::done : core::ExitCode::bad_input;
}

}  // namespace

void declare_info(Command& c)
{
  auto& o = c.options<InfoOptions>();
  c.model(o.file);
  c.json(o.as_json);
  c.runs([&o] { return info_command(o); });
}

void declare_validate(Command& c)
{
  auto& o = c.options<InfoOptions>();
  c.model(o.file, "Motion model or trace (HDF5)");
  c.json(o.as_json);
  c.runs([&o] { return validate_command(o); });
}

}  // namespace vrda::app

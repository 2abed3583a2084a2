#include "analysis/fit_files.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "analysis/result_journal.hpp"
#include "core/document.hpp"
#include "core/fields_json.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "job/component_loader.hpp"
#include "job/job.hpp"
#include "job/job_parts.hpp"
#include "solve/case_solver.hpp"

namespace vrda::analysis {
namespace {

using core::DocumentValue;
using FitsJson = nlohmann::ordered_json;

// The flexion of the joint is given, that of a follower is not.
FitsJson misfit_json(const Misfit& misfit, bool is_follower)
{
  FitsJson json = FitsJson::object();
  for (std::size_t c = is_follower ? 0 : 1; c < n_scored; ++c) {
    const char* name = is_follower ? follower_coordinate_names[c] : joint_coordinate_names[c];
    json[std::string(name) + unit_suffix(c)] = core::json_value(in_file(misfit[c], c));
  }
  return json;
}

FitsJson body_json(const BodyMisfit& misfit, bool is_follower)
{
  return {{"rms_before", misfit_json(misfit.before, is_follower)},
          {"rms_after", misfit_json(misfit.after, is_follower)},
          {"rms_left_out", misfit_json(misfit.without, is_follower)}};
}

FitsJson trial_json(const TrialMisfit& trial)
{
  FitsJson json{{"name", trial.name}, {"rows", trial.n_rows}};
  json.update(body_json(trial.joint, false));
  for (const auto& [name, misfit] : trial.followers) json["followers"][name] = body_json(misfit, true);
  return json;
}

FitsJson unknown_json(const FitDocument& document, std::size_t k)
{
  const Unknown& unknown = document.unknowns[k];
  const FittedUnknown& found = document.found.unknowns[k];
  return {{"name", unknown.name},
          {"unit", unknown.unit()},
          {"change", found.change},
          {"sd", found.sd},
          {"prior_sd", unknown.sd},
          {"from", unknown.from},
          {"to", unknown.to},
          {"explained", found.explained},
          {"decision", name_of(found.identifiability)},
          {"most_correlated_with",
           document.unknowns.size() > 1 ? FitsJson(document.unknowns[found.partner].name) : FitsJson()},
          {"correlation", found.correlation}};
}

// Where the value of a load at a flexion comes from.
struct LoadSetting {
  const char* key;
  const job::FlexionTable* table;
  std::vector<job::InputLoad> columns;  ///< [components]
};

// The degrees that a file gave for an angle: those of the conversion can be off by its last bit.
double written_deg(double angle_rad)
{
  constexpr double decimals = 1e9;
  const double angle_deg = deg_from_rad(angle_rad), rounded_deg = std::round(angle_deg * decimals) / decimals;
  return rad_from_deg(rounded_deg) == angle_rad ? rounded_deg : angle_deg;
}

// A constant, or a table over the flexions of the setting and of the unknowns.
DocumentValue changed_setting(const LoadSetting& setting, const std::vector<Unknown>& unknowns,
                              const Eigen::VectorXd& change)
{
  std::set<double> flexions_rad;
  if (setting.table->flexion_rad.size() > 1)
    flexions_rad.insert(setting.table->flexion_rad.begin(), setting.table->flexion_rad.end());
  for (const Unknown& unknown : unknowns) {
    if (unknown.quantity == job::InputQuantity::load &&
        std::find(setting.columns.begin(), setting.columns.end(), unknown.load) != setting.columns.end())
      flexions_rad.insert(unknown.all_flexions_rad.begin(), unknown.all_flexions_rad.end());
  }
  const auto value_at = [&](double flexion_rad) -> DocumentValue {
    const Eigen::VectorXd before = job::value_at_flexion(*setting.table, flexion_rad);
    LoadChange by = load_change_at(unknowns, change, flexion_rad);
    std::vector<double> values;
    for (std::size_t k = 0; k < setting.columns.size(); ++k)
      values.push_back(before(static_cast<Eigen::Index>(k)) + component(by, setting.columns[k]));
    return values.size() == 1 ? DocumentValue(values.front()) : DocumentValue(values);
  };
  if (flexions_rad.empty()) return value_at(0.0);
  std::vector<double> flexions_deg;
  DocumentValue rows = DocumentValue::array();
  for (const double flexion_rad : flexions_rad) {
    flexions_deg.push_back(written_deg(flexion_rad));
    rows.push_back(value_at(flexion_rad));
  }
  return {{"flexion_deg", flexions_deg}, {"value", rows}};
}

void set_loads(DocumentValue& push, const job::Job& job, const std::vector<Unknown>& unknowns,
               const Eigen::VectorXd& change)
{
  const LoadSetting settings[] = {
      {"force_n", &job.push.force_n, {job::InputLoad::force}},
      {"lateral_force_n",
       &job.push.lateral_force_n,
       {job::InputLoad::anterior_force, job::InputLoad::right_force}},
      {"moment_nmm", &job.push.moment_nmm, {job::InputLoad::moment}},
      {"varus_moment_nmm", &job.push.varus_moment_nmm, {job::InputLoad::varus_moment}}};
  for (const LoadSetting& setting : settings) {
    const bool is_fitted = std::any_of(unknowns.begin(), unknowns.end(), [&](const Unknown& unknown) {
      return unknown.quantity == job::InputQuantity::load &&
             std::find(setting.columns.begin(), setting.columns.end(), unknown.load) != setting.columns.end();
    });
    if (is_fitted) push[setting.key] = changed_setting(setting, unknowns, change);
  }
}

// The table in the place of the job's own fibres.
void set_fibres(DocumentValue& ligaments, const std::string& file)
{
  DocumentValue changed{{"fibres", file}};
  for (const auto& [key, value] : ligaments.items()) {
    if (key != "fibres" && key != "fibre" && key != "generate") changed[key] = value;
  }
  ligaments = changed;
}

}  // namespace

std::string fit_json(const FitDocument& document)
{
  const Identification& found = document.found;
  FitsJson inputs = FitsJson::array(), unknowns = FitsJson::array(), trials = FitsJson::array(),
           laxities = FitsJson::array(), covariance = FitsJson::array();
  for (const job::LoadedInput& input : document.inputs)
    inputs.push_back({{"name", input.name}, {"sha256", input.sha256}});
  for (std::size_t k = 0; k < document.unknowns.size(); ++k) unknowns.push_back(unknown_json(document, k));
  for (const TrialMisfit& trial : found.trials) trials.push_back(trial_json(trial));
  for (const LaxityMisfit& row : found.laxities)
    laxities.push_back({{"test", row.measured.test},
                        {"flexion_deg", row.measured.flexion_deg},
                        {"measured", row.measured.value},
                        {"before", core::json_value(row.before)},
                        {"after", core::json_value(row.after)}});
  for (Eigen::Index row = 0; row < found.covariance.rows(); ++row) {
    FitsJson numbers = FitsJson::array();
    for (Eigen::Index column = 0; column < found.covariance.cols(); ++column)
      numbers.push_back(found.covariance(row, column));
    covariance.push_back(numbers);
  }
  const FitsJson json = {{"format", "vrda fit"},
                         {"version", 1},
                         {"program", document.program},
                         {"solver", document.solver},
                         {"title", document.title},
                         {"job", document.job},
                         {"inputs", inputs},
                         {"status", name_of(found.status)},
                         {"iterations", found.n_iterations},
                         {"misfit_before", found.misfit_before},
                         {"misfit_after", found.misfit_after},
                         {"noise_scale", found.noise_scale},
                         {"directions_decided", found.n_directions},
                         {"unknowns", unknowns},
                         {"covariance", covariance},
                         {"trials", trials},
                         {"laxities", laxities}};
  return core::json_text(json, 1) + '\n';
}

std::string fitted_ligaments_csv(const job::Job& job, const job::Case& job_case,
                                 const std::vector<Unknown>& unknowns, const Identification& found,
                                 std::optional<std::size_t> follower)
{
  const model::Ligaments ligaments = changed_ligaments(job_case, unknowns, found.change(), follower);
  const std::vector<double> lengths_mm = reference_lengths_mm(job_case, ligaments, follower);
  std::vector<const job::BodyJob*> bodies{&job.reference, &job.moving};
  for (const job::FollowerJob& one : job.followers) bodies.push_back(&one.body);
  const auto native = [&](BodyIndex body, const Eigen::Vector3d& p_mm) {
    const Pose X_native = job::body_map(job, *bodies.at(model::row_of(body))).X_canonical_native.inverse();
    return ',' + core::numbers_text(X_native * p_mm, ",");
  };
  std::string csv = follower ? "name,bundle,from_body,from_x_mm,from_y_mm,from_z_mm,to_body,to_x_mm,to_y_mm,"
                               "to_z_mm,tension_share,"
                             : "name,bundle,reference_x_mm,reference_y_mm,reference_z_mm,moving_x_mm,"
                               "moving_y_mm,moving_z_mm,";
  csv += "stiffness_n_per_strain,slack_length_mm,slack_length_sd_mm,wrap\n";
  for (std::size_t row = 0; row < ligaments.fibres.size(); ++row) {
    const model::Fibre& fibre = ligaments.fibres[row];
    const auto name_of_end = [&](BodyIndex body) {
      return follower ? ',' + bodies.at(model::row_of(body))->name : "";
    };
    const bool is_line = fibre.tension_n > 0.0;
    // dl0 / de = -l0 / (1 + e); the attachments' part is in the length at the pose of the meshes.
    double variance = 0.0;
    for (std::size_t k = 0; k < unknowns.size(); ++k) {
      const bool changes =
          unknowns[k].quantity == job::InputQuantity::reference_strain && unknowns[k].follower == follower &&
          std::find(unknowns[k].fibres.begin(), unknowns[k].fibres.end(), row) != unknowns[k].fibres.end();
      if (changes) variance += found.unknowns[k].sd * found.unknowns[k].sd;
    }
    const double sd_mm =
        std::sqrt(variance) * fibre.slack_length_mm * fibre.slack_length_mm / lengths_mm[row];
    csv += fibre.name + ',' + fibre.bundle + name_of_end(fibre.from) +
           native(fibre.from, fibre.reference_mm) + name_of_end(fibre.to) +
           native(fibre.to, fibre.moving_mm) + ',';
    if (follower) csv += (is_line ? shortest_decimal(fibre.tension_n) : "") + ',';
    csv += is_line ? ",,,"
                   : shortest_decimal(fibre.stiffness_n) + ',' + shortest_decimal(fibre.slack_length_mm) +
                         ',' + shortest_decimal(sd_mm) + ',';
    csv += (fibre.wrap < 0 ? "" : ligaments.wraps[static_cast<std::size_t>(fibre.wrap)].name) + '\n';
  }
  return csv;
}

std::string fitted_job_text(const job::Job& job, const job::Case& job_case, const FibreFiles& files,
                            const std::vector<Unknown>& unknowns, const Eigen::VectorXd& change)
{
  DocumentValue root = job.document.root;
  for (const auto& [follower, file] : files) {
    if (follower)
      root["follower"].at(*follower)["fibres"] = file;
    else
      set_fibres(root["ligaments"], file);
  }
  set_loads(root["push"], job, unknowns, change);
  const job::Case changed = changed_case(job_case, unknowns, change);
  for (const Unknown& unknown : unknowns) {
    if (!unknown.follower || unknown.quantity != job::InputQuantity::load) continue;
    DocumentValue& follower = root["follower"].at(*unknown.follower);
    const job::Follower& found = changed.followers.at(*unknown.follower);
    (unknown.load == job::InputLoad::push ? follower["push"]["force_n"] : follower["tension_n"]) =
        job::load_n(found, unknown.load);
  }
  root.erase("fit");
  return core::toml_text(root);
}

namespace {

constexpr JournalFormat evaluations_format{{"VRDAFITJ", 1, std::uint32_t{1} << 28, "evaluation"},
                                           "another job or other measurements"};
// Must be changed when the same question may give other evaluations.
constexpr const char* fit_version = "identification 2";

}  // namespace

std::string identification_key(const FitData& data, const IdentifyPlan& plan,
                               const std::vector<std::string>& hashes_of_data)
{
  std::string text = fit_version;
  for (const job::Case* job_case : {data.motion, data.laxity}) {
    if (job_case == nullptr) continue;
    text += '\n' + solve::fingerprint_of(*job_case) + '\n';
    for (const double deg : job_case->grid.flexion_deg) text += shortest_decimal(deg) + ' ';
  }
  for (const Unknown& unknown : plan.unknowns) {
    text += '\n' + unknown.name;
    for (const double number : {unknown.sd, unknown.from, unknown.to}) text += ' ' + shortest_decimal(number);
  }
  for (const double load :
       {data.loads.anterior_force_n, data.loads.internal_moment_nmm, data.loads.varus_moment_nmm})
    text += '\n' + shortest_decimal(load);
  text += '\n' + std::to_string(data.loads.load_steps);
  for (const std::string& hash : hashes_of_data) text += '\n' + hash;
  return job::sha256_of(text);
}

core::FrameWriter open_evaluations(const std::string& path, const std::string& key, bool is_fresh,
                                   std::vector<Evaluation>& known)
{
  return open_journal<Evaluation>(path, key, is_fresh, evaluations_format,
                                  [&](Evaluation evaluation) { known.push_back(std::move(evaluation)); });
}

}  // namespace vrda::analysis

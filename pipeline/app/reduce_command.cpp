// `vrda reduce`: the motion over flexion alone, as CSV or JSON; writes /zero_varus.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "analysis/reduce.hpp"
#include "app/commands.hpp"
#include "app/printing.hpp"
#include "core/document.hpp"
#include "core/fields.hpp"
#include "core/text.hpp"
#include "run/run_output.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "tables/formats.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;

/// `vrda reduce`: adds the flexion-only motion to a motion model and prints it.
struct ReduceOptions {
  std::string file;
  std::string set = "raw";  ///< source of the poses: one of set_names except zero_varus
  bool as_json = false;
};

/// Columns of the table; their headings are `name` + each of `parts` + `unit`.
struct Column {
  std::string name;
  const std::vector<double>& values;
  std::vector<const char*> parts;  ///< e.g. _x, _y, _z; one empty text for a single number
  const char* unit;
};

const std::vector<const char*> single{""}, xyz{"_x", "_y", "_z"};

std::vector<Column> flexion_columns(const store::ZeroVarus& z)
{
  std::vector<Column> columns{{"varus", z.varus_deg, single, "_deg"},
                              {"varus_first", z.varus_first_deg, single, "_deg"},
                              {"varus_last", z.varus_last_deg, single, "_deg"},
                              {"tx", z.tx_mm, single, "_mm"},
                              {"ty", z.ty_mm, single, "_mm"},
                              {"tz", z.tz_mm, single, "_mm"},
                              {"theta", z.theta_deg, single, "_deg"}};
  for (std::size_t k = 0; k < n_joint_coordinates; ++k)
    columns.push_back({tables::clinical_columns[k], z.clinical[k], single, unit_suffix(k)});
  for (const auto& [side, name, meaning] : compartment_names) {
    columns.push_back({std::string(name) + "_reference", z.centres[side].reference_mm, xyz, "_mm"});
    columns.push_back({std::string(name) + "_moving", z.centres[side].moving_mm, xyz, "_mm"});
  }
  return columns;
}

/// Values of the step from the row's flexion to the next one.
std::vector<Column> step_columns(const store::ZeroVarus& z)
{
  std::vector<Column> columns{{"helical_rotation", z.helical_rotation_deg, single, "_deg"},
                              {"helical_translation", z.helical_translation_mm, single, "_mm"},
                              {"helical_direction", z.helical_direction, xyz, ""},
                              {"helical_point", z.helical_point_mm, xyz, "_mm"},
                              {"instant_centre", z.instant_centre_mm, {"_anterior", "_proximal"}, "_mm"}};
  for (const auto& [side, name, meaning] : compartment_names) {
    columns.push_back({std::string(name) + "_rolling", z.rolling[side].rolling_mm, single, "_mm"});
    columns.push_back({std::string(name) + "_sliding", z.rolling[side].sliding_mm, single, "_mm"});
  }
  return columns;
}

constexpr Named<store::ZeroVarusSource> source_names[] = {
    {store::ZeroVarusSource::none, "none"},
    {store::ZeroVarusSource::both_touch, "both_touch"},
    {store::ZeroVarusSource::interpolated, "interpolated"},
    {store::ZeroVarusSource::free, "free"}};

const char* source_name(const store::ZeroVarus& z, std::size_t i)
{
  return std::ranges::find(source_names, static_cast<store::ZeroVarusSource>(z.source[i]),
                           &Named<store::ZeroVarusSource>::value)
      ->name;
}

void add_json(Json& row, const std::vector<Column>& columns, std::size_t i)
{
  for (const Column& c : columns) {
    const std::size_t n = c.parts.size();
    if (c.values.empty()) continue;  // a joint without compartments
    Json numbers = Json::array();
    for (std::size_t k = 0; k < n; ++k) numbers.push_back(c.values[n * i + k]);
    row[c.name + c.unit] = n == 1 ? numbers[0] : numbers;
  }
}

Json json_of(const store::MotionModel& model, const store::ZeroVarus& z, const std::string& set)
{
  const std::vector<Column> of_flexions = flexion_columns(z), of_steps = step_columns(z);
  Json flexions = Json::array(), steps = Json::array();
  for (std::size_t i = 0; i < z.source.size(); ++i) {
    Json row = {{"flexion_deg", model.flexion_deg[i]},
                {"source", source_name(z, i)},
                {"is_cut_off", z.is_cut_off[i] == 1}};
    add_json(row, of_flexions, i);
    flexions.push_back(row);
    if (i == 0) continue;
    Json step = {{"from_deg", model.flexion_deg[i - 1]}, {"to_deg", model.flexion_deg[i]}};
    add_json(step, of_steps, i - 1);
    steps.push_back(step);
  }
  const Eigen::Vector3d& centre_mm = model.rotation_centre_mm;
  return {{"title", model.title},
          {"joint", model.joint},
          {"side", model.side},
          {"set", set},
          {"rotation_centre_mm", {centre_mm.x(), centre_mm.y(), centre_mm.z()}},
          {"flexions", flexions},
          {"steps", steps}};
}

void print_names(const std::vector<Column>& columns)
{
  for (const Column& c : columns) {
    for (const char* part : c.parts) std::printf(",%s%s%s", c.name.c_str(), part, c.unit);
  }
}

/// Prints an empty field for an unknown value and beyond the last step.
void print_numbers(const std::vector<Column>& columns, std::size_t i)
{
  for (const Column& c : columns) {
    for (std::size_t k = 0; k < c.parts.size(); ++k) {
      const std::size_t at = c.parts.size() * i + k;
      if (at < c.values.size() && std::isfinite(c.values[at])) {
        std::printf(",%.6f", c.values[at]);
      } else {
        std::printf(",");
      }
    }
  }
}

void print_csv(const store::MotionModel& model, const store::ZeroVarus& z)
{
  std::vector<Column> columns = flexion_columns(z);
  std::ranges::move(step_columns(z), std::back_inserter(columns));
  std::printf("flexion_deg,source");
  print_names(columns);
  std::printf(",centre_x_mm,centre_y_mm,centre_z_mm\n");
  for (std::size_t i = 0; i < z.source.size(); ++i) {
    std::printf("%g,%s", model.flexion_deg[i], source_name(z, i));
    print_numbers(columns, i);
    for (const double mm : model.rotation_centre_mm) std::printf(",%.6f", mm);
    std::printf("\n");
  }
}

void require_set(const store::MotionModel& model, const ReduceOptions& options)
{
  std::vector<std::string> known = store::set_names(model);
  std::erase(known, "zero_varus");
  if (std::ranges::find(known, options.set) != known.end()) return;
  throw InputError(
      {options.file, "--set", "\"" + options.set + "\"", "a set of this file: " + joined(known)});
}

void require_reducible(const store::MotionModel& model, const std::string& file)
{
  if (analysis::is_reducible(model)) return;
  throw InputError({file, "compartments", "no compartments with given varus",
                    "a medial and a lateral compartment in the job, or grid.varus = \"free\""});
}

void require_reduced(const store::ZeroVarus& z, const std::string& file)
{
  if (analysis::n_reduced_flexions(z) > 0) return;
  throw InputError(
      {file, "contact_medial, contact_lateral, gap_medial_mm, gap_lateral_mm",
       "no flexion with a pose where both compartments touch, or with two poses whose gap difference changes "
       "sign",
       "at least one"});
}

bool are_same(const std::vector<double>& a, const std::vector<double>& b)
{
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double x, double y) {
    return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
  });
}

/// An audit of replaced poses must not be read as an audit of the new ones.
void drop_stale_audit(store::MotionModel& model, const store::ZeroVarus& z)
{
  if (model.zero_varus && are_same(model.zero_varus->X_reference_moving, z.X_reference_moving)) return;
  std::erase_if(model.audits, [](const store::AuditSet& audit) { return audit.name == "zero_varus"; });
}

std::string counts_line(const store::ZeroVarus& z)
{
  std::vector<std::string> words;
  for (const auto& source : source_names) {
    const auto n = std::ranges::count(z.source, static_cast<std::int8_t>(source.value));
    if (n > 0) words.push_back(std::to_string(n) + " " + source.name);
  }
  return joined(words);
}

// Replaces an existing zero-varus motion, and drops its audit if the poses differ. Throws InputError, with
// the file unchanged, for a joint without compartments and with given varus, for a set that is missing from
// the file, and if no flexion can be reduced.
core::ExitCode reduce_command(const ReduceOptions& options)
{
  const bool is_stored = run::may_add_to(options.file);
  const std::optional<OutputLock> lock =
      is_stored ? run::lock_output(options.file, "vrda reduce") : std::nullopt;
  if (is_stored && !lock) return core::ExitCode::interrupted;
  store::MotionModel model = store::read_motion_model(options.file);
  store::require_grid(model, options.file, "vrda reduce");
  require_set(model, options);
  require_reducible(model, options.file);
  store::ZeroVarus z = analysis::reduce(model, options.set);
  require_reduced(z, options.file);
  drop_stale_audit(model, z);
  model.zero_varus = std::move(z);
  if (is_stored) store::write_motion_model(options.file, model);
  core::log_info(options.file + ": zero-varus motion from " + options.set + ", " +
                 std::to_string(model.zero_varus->source.size()) +
                 " flexions: " + counts_line(*model.zero_varus));
  const std::string cut_off = analysis::cut_off_warning(*model.zero_varus);
  if (!cut_off.empty()) core::log_warning(options.file + ": " + cut_off);
  if (options.as_json) return print_json(json_of(model, *model.zero_varus, options.set));
  print_csv(model, *model.zero_varus);
  return core::ExitCode::done;
}

}  // namespace

void declare_reduce(Command& c)
{
  auto& o = c.options<ReduceOptions>();
  c.model(o.file);
  c.option("--set", o.set, "Source of the poses: raw, two_sided, degree_N, ...").shows_default();
  c.json(o.as_json);
  c.runs([&o] { return reduce_command(o); });
}

}  // namespace vrda::app

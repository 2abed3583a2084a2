#include "app/model_commands.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "motion/poses.hpp"
#include "reduce/reduce.hpp"
#include "run/run_output.hpp"
#include "store/motion_model_file.hpp"

namespace vrda {
namespace {

using Json = nlohmann::ordered_json;

/// Columns of the table; their headings are `name` + each of `parts` + `unit`.
struct Column {
  const char* name;
  std::vector<double> ZeroVarus::*values;
  std::vector<const char*> parts;  ///< e.g. _x, _y, _z; one empty text for a single number
  const char* unit;
};

const std::vector<const char*> single{""}, xyz{"_x", "_y", "_z"};

const std::vector<Column> flexion_columns{
    {"varus", &ZeroVarus::varus_deg, single, "_deg"},
    {"varus_first", &ZeroVarus::varus_first_deg, single, "_deg"},
    {"varus_last", &ZeroVarus::varus_last_deg, single, "_deg"},
    {"tx", &ZeroVarus::tx_mm, single, "_mm"},
    {"ty", &ZeroVarus::ty_mm, single, "_mm"},
    {"tz", &ZeroVarus::tz_mm, single, "_mm"},
    {"theta", &ZeroVarus::theta_deg, single, "_deg"},
    {"clinical_flexion", &ZeroVarus::clinical_flexion_deg, single, "_deg"},
    {"clinical_varus", &ZeroVarus::clinical_varus_deg, single, "_deg"},
    {"internal_rotation", &ZeroVarus::internal_rotation_deg, single, "_deg"},
    {"anterior", &ZeroVarus::anterior_mm, single, "_mm"},
    {"proximal", &ZeroVarus::proximal_mm, single, "_mm"},
    {"lateral", &ZeroVarus::lateral_mm, single, "_mm"},
    {"medial_reference", &ZeroVarus::medial_reference_mm, xyz, "_mm"},
    {"medial_moving", &ZeroVarus::medial_moving_mm, xyz, "_mm"},
    {"lateral_reference", &ZeroVarus::lateral_reference_mm, xyz, "_mm"},
    {"lateral_moving", &ZeroVarus::lateral_moving_mm, xyz, "_mm"}};

/// Values of the step from the row's flexion to the next one.
const std::vector<Column> step_columns{
    {"helical_rotation", &ZeroVarus::helical_rotation_deg, single, "_deg"},
    {"helical_translation", &ZeroVarus::helical_translation_mm, single, "_mm"},
    {"helical_direction", &ZeroVarus::helical_direction, xyz, ""},
    {"helical_point", &ZeroVarus::helical_point_mm, xyz, "_mm"},
    {"instant_centre", &ZeroVarus::instant_centre_mm, {"_anterior", "_proximal"}, "_mm"},
    {"medial_rolling", &ZeroVarus::medial_rolling_mm, single, "_mm"},
    {"medial_sliding", &ZeroVarus::medial_sliding_mm, single, "_mm"},
    {"lateral_rolling", &ZeroVarus::lateral_rolling_mm, single, "_mm"},
    {"lateral_sliding", &ZeroVarus::lateral_sliding_mm, single, "_mm"}};

constexpr ZeroVarusSource all_sources[] = {ZeroVarusSource::none, ZeroVarusSource::both_touch,
                                           ZeroVarusSource::interpolated, ZeroVarusSource::free};

const char* name_of(ZeroVarusSource source)
{
  switch (source) {
    case ZeroVarusSource::none:
      return "none";
    case ZeroVarusSource::both_touch:
      return "both_touch";
    case ZeroVarusSource::interpolated:
      return "interpolated";
    case ZeroVarusSource::free:
      return "free";
  }
  throw InternalError("a source of varus has a name");
}

const char* source_name(const ZeroVarus& z, std::size_t i)
{
  return name_of(static_cast<ZeroVarusSource>(z.source[i]));
}

void add_json(Json& row, const ZeroVarus& z, const std::vector<Column>& columns, std::size_t i)
{
  for (const Column& c : columns) {
    const std::vector<double>& values = z.*c.values;
    const std::size_t n = c.parts.size();
    if (values.empty()) continue;  // a joint without compartments
    Json numbers = Json::array();
    for (std::size_t k = 0; k < n; ++k) numbers.push_back(values[n * i + k]);
    row[std::string(c.name) + c.unit] = n == 1 ? numbers[0] : numbers;
  }
}

void print_json(const MotionModel& model, const ZeroVarus& z, const std::string& set)
{
  Json flexions = Json::array(), steps = Json::array();
  for (std::size_t i = 0; i < z.source.size(); ++i) {
    Json row = {{"flexion_deg", model.flexion_deg[i]}, {"source", source_name(z, i)}};
    add_json(row, z, flexion_columns, i);
    flexions.push_back(row);
    if (i == 0) continue;
    Json step = {{"from_deg", model.flexion_deg[i - 1]}, {"to_deg", model.flexion_deg[i]}};
    add_json(step, z, step_columns, i - 1);
    steps.push_back(step);
  }
  const Json all = {{"title", model.title}, {"joint", model.joint}, {"side", model.side},
                    {"set", set},           {"flexions", flexions}, {"steps", steps}};
  std::printf("%s\n", all.dump(2).c_str());
}

void print_names(const std::vector<Column>& columns)
{
  for (const Column& c : columns) {
    for (const char* part : c.parts) std::printf(",%s%s%s", c.name, part, c.unit);
  }
}

/// Prints an empty field for an unknown value and beyond the last step.
void print_numbers(const ZeroVarus& z, const std::vector<Column>& columns, std::size_t i)
{
  for (const Column& c : columns) {
    const std::vector<double>& values = z.*c.values;
    for (std::size_t k = 0; k < c.parts.size(); ++k) {
      const std::size_t at = c.parts.size() * i + k;
      if (at < values.size() && std::isfinite(values[at])) {
        std::printf(",%.6f", values[at]);
      } else {
        std::printf(",");
      }
    }
  }
}

void print_csv(const MotionModel& model, const ZeroVarus& z)
{
  std::printf("flexion_deg,source");
  print_names(flexion_columns);
  print_names(step_columns);
  std::printf("\n");
  for (std::size_t i = 0; i < z.source.size(); ++i) {
    std::printf("%g,%s", model.flexion_deg[i], source_name(z, i));
    print_numbers(z, flexion_columns, i);
    print_numbers(z, step_columns, i);
    std::printf("\n");
  }
}

void require_set(const MotionModel& model, const ReduceOptions& options)
{
  std::string known;
  for (const std::string& name : set_names(model)) {
    if (name == "zero_varus") continue;
    if (name == options.set) return;
    known += (known.empty() ? "" : ", ") + name;
  }
  throw InputError({options.file, "--set", "\"" + options.set + "\"", "a set of this file: " + known});
}

void require_reducible(const MotionModel& model, const std::string& file)
{
  if (is_reducible(model)) return;
  throw InputError({file, "compartments", "no compartments with given varus",
                    "a medial and a lateral compartment in the job, or grid.varus = \"free\""});
}

void require_reduced(const ZeroVarus& z, const std::string& file)
{
  if (n_reduced(z) > 0) return;
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
void drop_stale_audit(MotionModel& model, const ZeroVarus& z)
{
  if (model.zero_varus && are_same(model.zero_varus->X_reference_moving, z.X_reference_moving)) return;
  std::erase_if(model.audits, [](const AuditSet& audit) { return audit.name == "zero_varus"; });
}

std::string counts_line(const ZeroVarus& z)
{
  std::string line;
  for (const ZeroVarusSource source : all_sources) {
    const auto n = std::count(z.source.begin(), z.source.end(), static_cast<std::int8_t>(source));
    if (n > 0) line += (line.empty() ? "" : ", ") + std::to_string(n) + " " + name_of(source);
  }
  return line;
}

}  // namespace

ExitCode reduce_command(const ReduceOptions& options)
{
  const std::optional<OutputLock> lock = locked_output(options.file, "vrda reduce");
  if (!lock) return ExitCode::interrupted;
  MotionModel model = read_motion_model(options.file);
  require_set(model, options);
  require_reducible(model, options.file);
  ZeroVarus z = reduce(model, options.set);
  require_reduced(z, options.file);
  drop_stale_audit(model, z);
  model.zero_varus = std::move(z);
  write_motion_model(options.file, model);
  say(options.file + ": zero-varus motion from " + options.set + ", " +
      std::to_string(model.zero_varus->source.size()) + " flexions: " + counts_line(*model.zero_varus));
  if (options.as_json) {
    print_json(model, *model.zero_varus, options.set);
  } else {
    print_csv(model, *model.zero_varus);
  }
  return ExitCode::done;
}

}  // namespace vrda

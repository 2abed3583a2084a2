#include "run/index.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <filesystem>
#include <memory>

#include "core/document.hpp"
#include "core/fields_json.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "job/job.hpp"
#include "model/coordinates.hpp"
#include "model/mesh.hpp"
#include "run/campaign.hpp"
#include "store/journal.hpp"
#include "store/motion.hpp"
#include "store/read_separately.hpp"
#include "store/solved_cells.hpp"

namespace vrda::run {
namespace {

namespace fs = std::filesystem;

bool file_exists(const std::string& path)
{
  std::error_code ignored;
  return fs::exists(path, ignored);
}

// Whether a run or a shard has left a start file or journal next to its output.
bool is_started(const std::string& output)
{
  if (file_exists(store::start_file_of(output)) || file_exists(store::journal_of(output))) return true;
  return file_exists(store::spine_journal_of(output)) ||
         !store::list_shard_journals_if_readable(output).empty();
}

CaseTimes times_beside(const std::string& output)
{
  try {
    return core::json_in(read_text_file(output + ".run.json").value_or("")).get<CaseTimes>();
  } catch (const nlohmann::json::exception&) {
    return {};  // not part of the results, so not an error
  }
}

void add_model(IndexRow& row, const store::MotionModel& model)
{
  const std::string bytes =
      job::file_bytes(row.file, {row.file, "", "", "a motion model"}, run::largest_model_bytes);
  row.title = model.title;
  row.joint = model.joint;
  row.side = model.side;
  row.solver = model.method;
  row.curve = index_curve_of(model);
  row.numbers = index_numbers_of(model, static_cast<double>(bytes.size()));
  row.sha256 = job::sha256_of(bytes);
  row.status = CaseStatus::done;
}

// One value per row.
template <typename Value, typename Of>
std::vector<Value> each(const std::vector<IndexRow>& rows, const Of& of)
{
  std::vector<Value> values;
  values.reserve(rows.size());
  for (const IndexRow& row : rows) values.push_back(of(row));
  return values;
}

template <typename Of>
store::IndexColumn text_column(const std::string& name, const std::string& what,
                               const std::vector<IndexRow>& rows, const Of& of)
{
  return {name, "", what, each<std::string>(rows, of), store::FlagSet::none};
}

struct TextColumn {
  const char* name;
  const char* what;
  std::string IndexRow::*value;
};

constexpr TextColumn texts[] = {
    {"remark", "reason of the failure", &IndexRow::remark},
    {"title", "title of the job", &IndexRow::title},
    {"joint", "knee, hip, ankle, subtalar or other", &IndexRow::joint},
    {"side", "right or left", &IndexRow::side},
    {"solver", "method that solved the case", &IndexRow::solver},
    {"curve", "motion over flexion used for the curve columns", &IndexRow::curve},
};

std::string relative_to(const fs::path& folder, const std::string& file)
{
  return fs::path(file).lexically_relative(folder).generic_string();
}

void add_numbers(std::vector<store::IndexColumn>& columns, const std::vector<IndexRow>& rows)
{
  for (std::size_t k = 0; k < index_numbers().size(); ++k) {
    const IndexNumber& number = index_numbers()[k];
    const auto value = [k](const IndexRow& row) { return row.numbers.empty() ? nan : row.numbers.at(k); };
    columns.push_back(
        {number.name, number.units, number.long_name, each<double>(rows, value), store::FlagSet::none});
  }
}

store::IndexTable table_of(const fs::path& folder, const std::string& title,
                           const std::vector<std::string>& axes, const std::vector<IndexRow>& rows)
{
  store::IndexTable table{title, {}};
  std::vector<store::IndexColumn>& columns = table.columns;
  columns.push_back(text_column("case", "name of the case", rows, [](const auto& r) { return r.name; }));
  for (std::size_t a = 0; a < axes.size(); ++a) {
    columns.push_back(text_column(axes[a], "level of this campaign axis", rows,
                                  [a](const auto& r) { return r.levels.at(a); }));
  }
  const auto code = [](const IndexRow& row) { return static_cast<std::int8_t>(row.status); };
  columns.push_back(
      {"status", "", "progress of the case", each<std::int8_t>(rows, code), store::FlagSet::case_status});
  for (const TextColumn& text : texts) {
    columns.push_back(text_column(text.name, text.what, rows, [&](const auto& r) { return r.*text.value; }));
  }
  add_numbers(columns, rows);
  columns.push_back(text_column("sha256", "SHA-256 of the motion model's file", rows,
                                [](const auto& r) { return r.sha256; }));
  columns.push_back(text_column("file", "path of the motion model, relative to this file's folder", rows,
                                [&](const auto& r) { return relative_to(folder, r.file); }));
  return table;
}

struct TimesRow {
  std::string name;
  CaseTimes times;
};
constexpr auto fields_of(const TimesRow*)
{
  return std::tuple{Field{"case", &TimesRow::name}, Field{"", &TimesRow::times}};
}

std::string times_csv(const std::vector<IndexRow>& rows)
{
  std::vector<TimesRow> times;
  for (const IndexRow& row : rows) times.push_back({row.name, row.times});
  return csv_text(times);
}

std::string absolute_path(const std::string& path)
{
  return fs::absolute(path).lexically_normal().string();
}

IndexRow row_of(const IndexedCase& one, store::SeparateModelRead* reading)
{
  IndexRow row;
  row.name = one.name;
  row.levels = one.levels;
  row.file = absolute_path(one.model_path);
  if (reading == nullptr) {
    row.status = is_started(row.file) ? CaseStatus::partial : CaseStatus::missing;
    return row;
  }
  row.times = times_beside(row.file);
  try {
    const store::MotionModel model = reading->model();
    store::require_grid(model, row.file, "an index");
    add_model(row, model);
  } catch (const InputError& error) {
    row.status = CaseStatus::failed;
    // Without the folder, so that the index does not depend on its location.
    const InputError::Facts& facts = error.facts();
    row.remark =
        (facts.field.empty() ? "" : facts.field + ": ") + "found " + facts.found + ", wanted " + facts.wanted;
  }
  return row;
}

}  // namespace

std::string index_file_of(const std::string& folder)
{
  return folder + "/index.h5";
}

std::vector<IndexRow> index_rows(const std::vector<IndexedCase>& cases, int n_processes)
{
  std::vector<IndexRow> rows;
  std::deque<std::unique_ptr<store::SeparateModelRead>> pending;  // null if there is no model
  const auto n_pending = static_cast<std::size_t>(std::max(1, n_processes));
  for (std::size_t k = 0; k < cases.size(); ++k) {
    for (std::size_t next = k + pending.size(); next < std::min(cases.size(), k + n_pending); ++next) {
      const std::string file = absolute_path(cases[next].model_path);
      pending.push_back(file_exists(file) ? std::make_unique<store::SeparateModelRead>(file) : nullptr);
    }
    rows.push_back(row_of(cases[k], pending.front().get()));
    pending.pop_front();
  }
  return rows;
}

void publish_index(Publication& publication, const std::string& folder, const std::string& title,
                   const std::vector<std::string>& axes, const std::vector<IndexRow>& rows)
{
  const fs::path root = fs::absolute(folder).lexically_normal();
  const store::IndexTable table = table_of(root, title, axes, rows);
  publication.add((root / "index.csv").string(), store::index_csv(table));
  publication.add((root / "index.times.csv").string(), times_csv(rows));
  publication.publish(store::index_bytes(index_file_of(root.string()), table));
}

// The numbers and the curve of a model in an index: one row of a table each, with name, unit and formula.

namespace {

/// Input of the columns.
struct Subject {
  const store::MotionModel& model;
  double model_bytes = 0.0;
  std::vector<Eigen::Index> spine;               ///< stable cell of each flexion, or -1
  const store::SmoothedSet* smoothed = nullptr;  ///< the default set
  std::string smoothed_name;                     ///< its name
  bool is_varus_free = false;
};

double count_of(std::int64_t n)
{
  return static_cast<double>(n);
}

double n_stable(const store::MotionModel& model)
{
  return count_of((model.status == status_stable).count());
}

// A quantity at each flexion of the curve, NaN where undefined: `of_zero` if the model has a zero-varus
// motion, otherwise `of_cell` at the spine's cells.
template <typename OfZero, typename OfCell>
std::vector<double> along_curve(const Subject& s, const OfZero& of_zero, const OfCell& of_cell)
{
  std::vector<double> values;
  for (std::size_t i = 0; i < s.spine.size(); ++i) {
    if (s.model.zero_varus) {
      values.push_back(of_zero(*s.model.zero_varus, i));
    } else {
      values.push_back(s.spine[i] < 0 ? nan : of_cell(s.spine[i]));
    }
  }
  return values;
}

std::vector<double> internal_rotation(const Subject& s)
{
  return unwrapped(along_curve(
                       s,
                       [](const store::ZeroVarus& zero, std::size_t i) {
                         return zero.clinical[JointCoordinate::internal][i];
                       },
                       [&](Eigen::Index c) { return s.model.clinical[JointCoordinate::internal].data()[c]; }),
                   360.0);
}

std::vector<double> balanced_varus(const Subject& s)
{
  return along_curve(
      s, [](const store::ZeroVarus& zero, std::size_t i) { return zero.clinical[JointCoordinate::varus][i]; },
      [&](Eigen::Index c) { return s.model.clinical[JointCoordinate::varus].data()[c]; });
}

// Anterior coordinate of a compartment's centre of contact on the moving object.
std::vector<double> contact_x_mm(const Subject& s, Compartment side)
{
  const auto at = [](const std::vector<double>& points, std::size_t k) {
    return points.empty() ? nan : points[3 * k];
  };
  return along_curve(
      s, [&](const store::ZeroVarus& zero, std::size_t i) { return at(zero.centres[side].moving_mm, i); },
      [&](Eigen::Index c) {
        if (!s.model.contact_paths) return nan;
        return at((*s.model.contact_paths)[side].moving_mm, static_cast<std::size_t>(c));
      });
}

double first_of(const std::vector<double>& values)
{
  const auto found = std::find_if(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
  return found == values.end() ? nan : *found;
}

double last_of(const std::vector<double>& values)
{
  const auto found = std::find_if(values.rbegin(), values.rend(), [](double v) { return std::isfinite(v); });
  return found == values.rend() ? nan : *found;
}

double range_of(const std::vector<double>& values)
{
  return store::largest_of(values) - store::smallest_of(values);
}

double mean_of(const std::vector<double>& values)
{
  double sum = 0.0;
  std::size_t n = 0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    sum += value;
    ++n;
  }
  return n == 0 ? nan : sum / count_of(static_cast<std::int64_t>(n));
}

double determined_fraction(const store::MotionModel& model)
{
  const double n = n_stable(model);
  return n > 0.0 ? count_of((model.theta_determined == 1).count()) / n : nan;
}

double width(const Points& vertices_mm)
{
  return vertices_mm.rows() == 0 ? nan : vertices_mm.col(2).maxCoeff() - vertices_mm.col(2).minCoeff();
}

double audit_value(const store::MotionModel& model, const std::string& name,
                   double store::AuditSummary::*figure)
{
  for (const store::AuditSet& audit : model.audits) {
    if (audit.name == name) return store::summary_of(audit).*figure;
  }
  return nan;
}

// The medial share of the contact forces along Delta, mean over the spine.
double medial_share(const Subject& s)
{
  if (!s.model.equilibrium || !s.model.has_compartments) return nan;
  std::vector<double> shares;
  for (const Eigen::Index cell : s.spine) {
    if (cell < 0) continue;
    const auto forces = store::forces_in(s.model.equilibrium->forces, static_cast<std::size_t>(cell));
    shares.push_back(forces.all_n > 0.0 ? forces.of_n[1] / forces.all_n : nan);
  }
  return mean_of(shares);
}

double several_optima(const store::MotionModel& model)
{
  if (!model.equilibrium) return nan;
  const std::vector<std::int32_t>& n = model.equilibrium->spine.n_optima;
  return count_of(std::count_if(n.begin(), n.end(), [](std::int32_t k) { return k > 1; }));
}

using Figure = double store::SmoothedSurface::*;

// Root of the sum of squares over the three translations.
double smoothed_translation(const Subject& s, Figure figure)
{
  if (s.smoothed == nullptr) return nan;
  double sum = 0.0;
  for (const store::SmoothedSurface& surface : s.smoothed->surfaces) {
    const bool is_translation = surface.name == "tx" || surface.name == "ty" || surface.name == "tz";
    if (is_translation) sum += surface.*figure * (surface.*figure);
  }
  return std::sqrt(sum);
}

double smoothed_theta(const Subject& s, Figure figure)
{
  if (s.smoothed == nullptr) return nan;
  for (const store::SmoothedSurface& surface : s.smoothed->surfaces) {
    if (surface.name == "theta") return surface.*figure;
  }
  return nan;
}

using Measure = double (*)(const Subject&);

struct Column {
  IndexNumber number;
  Measure measure;
};

std::vector<Column> grid_columns()
{
  return {
      {{"flexions", "1", "flexions of the grid"},
       [](const Subject& s) { return count_of(s.model.status.rows()); }},
      {{"varus_columns", "1", "varus angles of the grid; 1 where varus was free"},
       [](const Subject& s) { return count_of(s.model.status.cols()); }},
      {{"flexion_first_deg", "degree", "first flexion of the grid"},
       [](const Subject& s) { return s.model.flexion_deg.front(); }},
      {{"flexion_last_deg", "degree", "last flexion of the grid"},
       [](const Subject& s) { return s.model.flexion_deg.back(); }},
      {{"varus_first_deg", "degree", "first varus of the grid; empty where varus was free"},
       [](const Subject& s) { return s.is_varus_free ? nan : s.model.varus_deg.front(); }},
      {{"varus_last_deg", "degree", "last varus of the grid; empty where varus was free"},
       [](const Subject& s) { return s.is_varus_free ? nan : s.model.varus_deg.back(); }},
      {{"attitudes", "1", "attitudes of the grid"},
       [](const Subject& s) { return count_of(s.model.status.size()); }},
      {{"solved", "1", "attitudes with a stable pose"}, [](const Subject& s) { return n_stable(s.model); }},
      {{"unsolved_fraction", "1", "fraction of the attitudes without a stable pose"},
       [](const Subject& s) { return 1.0 - n_stable(s.model) / count_of(s.model.status.size()); }},
      {{"theta_determined_fraction", "1",
        "fraction of the solved attitudes whose rotation is determined by contacts or fibres"},
       [](const Subject& s) { return determined_fraction(s.model); }},
      {{"triangles_reference", "1", "triangles of the reference's contact mesh"},
       [](const Subject& s) { return count_of(s.model.reference.contact.mesh.triangles.rows()); }},
      {{"triangles_moving", "1", "triangles of the moving object's contact mesh"},
       [](const Subject& s) { return count_of(s.model.moving.contact.mesh.triangles.rows()); }},
      {{"fibres", "1", "ligament fibres"},
       [](const Subject& s) {
         return s.model.ligaments ? count_of(static_cast<std::int64_t>(s.model.ligaments->name.size())) : 0.0;
       }},
  };
}

// The factor is 1 for a joint that was not scaled.
double factor_along(const Subject& s, Eigen::Index axis)
{
  return s.model.job.scaling ? s.model.job.scaling->factor[axis] : 1.0;
}

std::vector<Column> scaling_columns()
{
  return {
      {{"scale_anterior", "1", "scale factor of the joint, posterior to anterior"},
       [](const Subject& s) { return factor_along(s, 0); }},
      {{"scale_proximal", "1", "scale factor of the joint, distal to proximal"},
       [](const Subject& s) { return factor_along(s, 1); }},
      {{"scale_right", "1", "scale factor of the joint, left to right"},
       [](const Subject& s) { return factor_along(s, 2); }},
      {{"scale_error", "1", "standard error of a factor fitted to landmarks"},
       [](const Subject& s) { return s.model.job.scaling ? s.model.job.scaling->standard_error : nan; }},
      {{"landmark_residual_mm", "mm",
        "root mean square residual of the landmark distances for such a factor"},
       [](const Subject& s) { return s.model.job.scaling ? s.model.job.scaling->residual_rms_mm : nan; }},
  };
}

std::vector<Column> quality_columns()
{
  return {
      {{"reference_width_mm", "mm", "left-to-right extent of the reference's contact mesh"},
       [](const Subject& s) { return width(s.model.reference.contact.mesh.vertices_mm); }},
      {{"raw_penetration_mm", "mm", "largest penetration of the raw motion, if audited"},
       [](const Subject& s) {
         return audit_value(s.model, "raw", &store::AuditSummary::largest_penetration_mm);
       }},
      {{"raw_gap_mm", "mm", "largest gap of the raw motion, if audited"},
       [](const Subject& s) { return audit_value(s.model, "raw", &store::AuditSummary::largest_gap_mm); }},
      {{"worst_gap_mm", "mm", "smallest signed gap of the equilibria; negative is overlap"},
       [](const Subject& s) {
         return s.model.equilibrium ? store::smallest_of(s.model.equilibrium->worst_gap_mm) : nan;
       }},
      {{"balance_residual_n", "N", "largest residual of the force balance of the equilibria"},
       [](const Subject& s) {
         return s.model.equilibrium ? store::largest_of(s.model.equilibrium->balance_residual_n) : nan;
       }},
      {{"several_optima", "1", "flexions with more than one equilibrium, varus free"},
       [](const Subject& s) { return several_optima(s.model); }},
  };
}

std::vector<Column> curve_columns()
{
  return {
      {{"internal_rotation_first_deg", "degree",
        "internal rotation at the first defined flexion of the curve"},
       [](const Subject& s) { return first_of(internal_rotation(s)); }},
      {{"internal_rotation_last_deg", "degree", "internal rotation at the last defined flexion of the curve"},
       [](const Subject& s) { return last_of(internal_rotation(s)); }},
      {{"internal_rotation_range_deg", "degree",
        "largest minus smallest internal rotation of the curve (screw-home)"},
       [](const Subject& s) { return range_of(internal_rotation(s)); }},
      {{"varus_mean_deg", "degree", "varus of the curve, mean over its flexions"},
       [](const Subject& s) { return mean_of(balanced_varus(s)); }},
      {{"rollback_medial_mm", "mm",
        "posterior travel of the medial centre of contact on the moving object, first to last flexion"},
       [](const Subject& s) {
         const auto x = contact_x_mm(s, Compartment::medial);
         return first_of(x) - last_of(x);
       }},
      {{"rollback_lateral_mm", "mm",
        "posterior travel of the lateral centre of contact on the moving object, first to last flexion"},
       [](const Subject& s) {
         const auto x = contact_x_mm(s, Compartment::lateral);
         return first_of(x) - last_of(x);
       }},
      {{"medial_share", "1", "medial share of the contact forces along Delta, mean over the spine"},
       medial_share},
      {{"largest_tension_n", "N", "largest tension of a fibre"},
       [](const Subject& s) {
         return s.model.ligaments ? store::largest_of(s.model.ligaments->tension_n) : nan;
       }},
  };
}

std::vector<Column> smooth_columns()
{
  return {
      {{"smooth_degree", "1", "degree of the default smoothed set"},
       [](const Subject& s) { return s.smoothed == nullptr ? nan : count_of(s.smoothed->degree); }},
      {{"smooth_rms_mm", "mm", "root mean square residual of that set's translations"},
       [](const Subject& s) { return smoothed_translation(s, &store::SmoothedSurface::rms); }},
      {{"smooth_rms_deg", "degree", "root mean square residual of that set's theta"},
       [](const Subject& s) { return smoothed_theta(s, &store::SmoothedSurface::rms); }},
      {{"smooth_leave_one_out_mm", "mm", "leave-one-out error of that set's translations"},
       [](const Subject& s) { return smoothed_translation(s, &store::SmoothedSurface::leave_one_out_rms); }},
      {{"smooth_leave_one_out_deg", "degree", "leave-one-out error of that set's theta"},
       [](const Subject& s) { return smoothed_theta(s, &store::SmoothedSurface::leave_one_out_rms); }},
      {{"smooth_penetration_mm", "mm",
        "largest penetration of that set (recontacted if available), if audited"},
       [](const Subject& s) {
         return audit_value(s.model, s.smoothed_name, &store::AuditSummary::largest_penetration_mm);
       }},
      {{"smooth_gap_mm", "mm", "largest gap of that set (recontacted if available), if audited"},
       [](const Subject& s) {
         return audit_value(s.model, s.smoothed_name, &store::AuditSummary::largest_gap_mm);
       }},
      {{"model_bytes", "byte", "size of the motion model's file"},
       [](const Subject& s) { return s.model_bytes; }},
  };
}

const std::vector<Column>& columns()
{
  static const std::vector<Column> all = [] {
    std::vector<Column> list;
    for (const auto& part :
         {grid_columns(), scaling_columns(), quality_columns(), curve_columns(), smooth_columns()})
      list.insert(list.end(), part.begin(), part.end());
    return list;
  }();
  return all;
}

}  // namespace

const std::vector<IndexNumber>& index_numbers()
{
  static const std::vector<IndexNumber> numbers = [] {
    std::vector<IndexNumber> list;
    for (const Column& column : columns()) list.push_back(column.number);
    return list;
  }();
  return numbers;
}

std::vector<double> index_numbers_of(const store::MotionModel& model, double model_bytes)
{
  Subject subject{model,   model_bytes, store::solved_spine(model),
                  nullptr, "",          store::Motion(model, "raw").is_varus_free()};
  if (!model.smoothed.empty()) {
    subject.smoothed = &model.smoothed.back();  // sorted by degree; the default is the highest
    subject.smoothed_name = store::group_name(*subject.smoothed);
    if (subject.smoothed->recontact_mm) subject.smoothed_name += "_recontacted";
  }
  std::vector<double> numbers;
  for (const Column& column : columns()) {
    const double number = column.measure(subject);
    numbers.push_back(std::isfinite(number) ? number : nan);
  }
  return numbers;
}

std::string index_curve_of(const store::MotionModel& model)
{
  if (model.zero_varus) return "zero_varus";
  const std::vector<Eigen::Index> spine = store::solved_spine(model);
  const bool is_any = std::any_of(spine.begin(), spine.end(), [](Eigen::Index cell) { return cell >= 0; });
  return is_any ? "spine" : "";
}

}  // namespace vrda::run

// [coordinates] of a job: roles of the six coordinates and their values over the path or the frames.
#include "job/job_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/axis.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::job {
namespace {

constexpr double largest_path_step_deg = 1.0;
constexpr std::size_t largest_rows = 100000;
constexpr std::size_t flexion_row = 0, varus_row = 1, proximal_row = 4;

std::string key_of(std::size_t coordinate)
{
  return std::string("coordinates.") + joint_coordinate_names[coordinate];
}

CoordinateJob coordinate_of(const Job& job, const core::DocumentValue& value, std::size_t k)
{
  CoordinateJob coordinate;
  if (value.is_string()) return coordinate;
  const std::string key = key_of(k);
  coordinate.role = CoordinateRole::given;
  if (!value.is_object() || value.contains("value")) {
    coordinate.given = over_flexion_at(job.document, key, 1);
  } else if (value.contains("column")) {
    coordinate.column = core::text_at(value, "column");
    coordinate.file = core::text_or_empty(value, "file");
    coordinate.over = core::text_or_empty(value, "over");
  } else {
    coordinate.role = CoordinateRole::driven;
    coordinate.driven = range_at(job.document, key);
  }
  return coordinate;
}

std::size_t n_driven(const CoordinatesJob& job)
{
  return static_cast<std::size_t>(
      std::count_if(job.coordinate.begin(), job.coordinate.end(),
                    [](const CoordinateJob& c) { return c.role == CoordinateRole::driven; }));
}

// Combinations that are refused before any table is read.
void check_roles(const Job& job, const CoordinatesJob& coordinates)
{
  const auto& all = coordinates.coordinate;
  const bool has_frames = !coordinates.frames_file.empty();
  const bool is_grid = all[flexion_row].role == CoordinateRole::driven && n_driven(coordinates) == 2 &&
                       all[varus_row].role == CoordinateRole::driven;
  for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
    const CoordinateJob& c = all[k];
    if (has_frames && c.role == CoordinateRole::driven)
      job.document.refuse(key_of(k), "a range next to [frames]", "a column, a number, or \"free\"");
    if (c.role == CoordinateRole::driven && n_driven(coordinates) > 1 && !is_grid)
      job.document.refuse(key_of(k), std::to_string(n_driven(coordinates)) + " driven coordinates",
                          "one driven coordinate, or flexion and varus");
    if (has_frames && !c.file.empty())
      job.document.refuse(key_of(k) + ".file", "a file next to [frames]",
                          "a column of \"" + coordinates.frames_file + "\"");
    if (!has_frames && !c.column.empty() && c.file.empty())
      job.document.refuse(key_of(k), "a column without file", "file = \"motion.csv\", or [frames]");
    if (!has_frames && !c.column.empty() && n_driven(coordinates) == 0)
      job.document.refuse(key_of(k), "a column without a driving coordinate",
                          "a range { from, to, step } for one coordinate, or [frames]");
    if (c.given && c.given->value.rows() > 1 && !c.given->is_over_driving &&
        all[flexion_row].role == CoordinateRole::free)
      job.document.refuse(key_of(k), "a table over flexion, which is free", "flexion driven or given");
  }
  const auto has_role = [&](CoordinateRole role) {
    return std::any_of(all.begin(), all.end(), [&](const CoordinateJob& c) { return c.role == role; });
  };
  if (has_frames && !has_role(CoordinateRole::given))
    job.document.refuse("coordinates", "no given coordinate", "at least one column of the frames");
  if (job.method == SolverMethod::equilibrium) return;
  for (const std::size_t k : {flexion_row, varus_row}) {
    if (all[k].role != CoordinateRole::free) continue;
    throw InputError({job.document.source_of_conflict({key_of(k), "solver.method"}), key_of(k), "\"free\"",
                      "a driven or given angle: \"stability-search\" cannot leave it free"});
  }
  if (all[proximal_row].role != CoordinateRole::free)
    throw InputError({job.document.source_of_conflict({key_of(proximal_row), "solver.method"}),
                      key_of(proximal_row), "a given height",
                      "\"free\": \"stability-search\" finds the height along Delta"});
}

// The key's name becomes a name of the motion model.
void check_key_name(const CsvTable& table, const std::string& name)
{
  if (!is_key_name(name))
    table.refuse(table.header(), name, "a key column of this name",
                 "at most 40 lower-case letters, digits and underscores, as time_s");
}

std::vector<double> column_of(const CsvTable& table, const std::string& name)
{
  return table.numbers(table.column_named(name));
}

std::vector<double> ascending_column(const CsvTable& table, const std::string& name)
{
  std::vector<double> values = column_of(table, name);
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] > values[i - 1]) continue;
    table.refuse(table.row(i), name, shortest_decimal(values[i]),
                 "more than " + shortest_decimal(values[i - 1]) + " of the previous row");
  }
  return values;
}

class Loader {
 public:
  Loader(const Job& job, const CoordinatesJob& coordinates, std::string data_directory)
      : job_(job), coordinates_(coordinates), data_directory_(std::move(data_directory))
  {
    out_.push = job.push;
    for (std::size_t k = 0; k < n_joint_coordinates; ++k) out_.rows.role[k] = coordinates.coordinate[k].role;
  }

  LoadedCoordinates load()
  {
    const bool is_proximal = is_push_proximal();
    if (!coordinates_.frames_file.empty()) {
      load_frames();
    } else if (out_.rows.role[flexion_row] == CoordinateRole::driven && is_proximal) {
      load_grid();
    } else {
      load_driven();
    }
    return std::move(out_);
  }

 private:
  // An attitude of the grid has its flexion and varus about the joint's own axes only if Delta is proximal.
  bool is_push_proximal() const
  {
    if (job_.push.is_fixed_in_reference) return false;
    for (Eigen::Index i = 0; i < job_.push.delta.value.rows(); ++i) {
      if (Eigen::Vector3d(job_.push.delta.value.row(i)) == Eigen::Vector3d::UnitY()) continue;
      if (job_.method == SolverMethod::stability_search)
        throw InputError({job_.document.source_of_conflict({"push.delta", "solver.method"}), "push.delta",
                          "a direction other than proximal with [coordinates] and \"stability-search\"",
                          "[0, 1, 0], \"equilibrium\", or [grid]"});
      if (out_.rows.role[varus_row] == CoordinateRole::driven)
        throw InputError({job_.document.source_of_conflict({"push.delta", key_of(varus_row)}), "push.delta",
                          "a direction other than proximal with driven varus",
                          "[0, 1, 0], one driven coordinate, or [grid]"});
      return false;
    }
    return true;
  }

  CsvTable table_of(const std::string& key, const std::string& name)
  {
    const InputFile file = input_file(job_, data_directory_, {key, name, "a table of motion"});
    const std::string sha256 = sha256_of(file.bytes);
    const auto is_same = [&](const LoadedInput& input) { return input.name == name; };
    if (std::none_of(out_.inputs.begin(), out_.inputs.end(), is_same)) out_.inputs.push_back({name, sha256});
    texts_.push_back(std::make_unique<std::string>(file.bytes));
    CsvTable table(name, *texts_.back(), {"row", "rows", "rows of a motion"});
    table.require_rows(largest_rows);
    return table;
  }

  void load_frames()
  {
    const CsvTable table = table_of("frames.file", coordinates_.frames_file);
    const std::string key =
        coordinates_.frames_key.empty() ? std::string(table.columns().front()) : coordinates_.frames_key;
    check_key_name(table, key);
    out_.rows.key_name = key;
    out_.rows.key = ascending_column(table, key);
    std::array<std::vector<double>, n_joint_coordinates> columns;
    for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
      const std::string& column = coordinates_.coordinate[k].column;
      if (!column.empty()) columns[k] = column_of(table, column);
    }
    read_loads(table);
    for (std::size_t i = 0; i < out_.rows.key.size(); ++i) {
      add_row([&](std::size_t k, double) { return columns[k][i]; }, nan);
    }
    finish_sequence();
  }

  void read_loads(const CsvTable& table)
  {
    for (const PushTable& setting : tables_of(out_.push)) {
      FlexionTable& loads = *setting.table;
      if (loads.columns.empty()) continue;
      loads.value.resize(static_cast<Eigen::Index>(out_.rows.key.size()),
                         static_cast<Eigen::Index>(loads.columns.size()));
      for (std::size_t c = 0; c < loads.columns.size(); ++c) {
        const std::vector<double> values = column_of(table, loads.columns[c]);
        for (std::size_t i = 0; i < values.size(); ++i) {
          if (values[i] < setting.least || (setting.excludes_least && values[i] == setting.least))
            table.refuse(table.row(i), loads.columns[c], shortest_decimal(values[i]),
                         (setting.excludes_least ? "above " : "at least ") + shortest_decimal(setting.least) +
                             " (" + loads.key + ")");
          loads.value(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) = values[i];
        }
      }
    }
  }

  void load_grid()
  {
    const std::vector<double>& flexion_deg = coordinates_.coordinate[flexion_row].driven;
    check_ascending(flexion_row);
    out_.grid.flexion_deg = flexion_deg;
    const CoordinateJob& varus = coordinates_.coordinate[varus_row];
    out_.grid.varus_deg = varus.role == CoordinateRole::driven ? varus.driven : std::vector<double>{0.0};
    out_.path_flexion_deg = job_.method == SolverMethod::equilibrium ? path_of(flexion_deg) : flexion_deg;
    add_rows_over(flexion_row, out_.path_flexion_deg);
  }

  // One driven coordinate, or none: a sequence of frames.
  void load_driven()
  {
    std::size_t driving = n_joint_coordinates;
    for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
      if (out_.rows.role[k] == CoordinateRole::driven) driving = k;
    }
    if (driving == n_joint_coordinates) {
      out_.rows.key_name = "frame";
      out_.rows.key = {0.0};
      add_row([](std::size_t, double) { return nan; }, nan);
      return finish_sequence();
    }
    check_ascending(driving);
    out_.rows.key_name = std::string(joint_coordinate_names[driving]) + unit_suffix(driving);
    out_.rows.key = coordinates_.coordinate[driving].driven;
    add_rows_over(driving, out_.rows.key);
    finish_sequence();
  }

  void check_ascending(std::size_t k) const
  {
    const std::vector<double>& driven = coordinates_.coordinate[k].driven;
    if (driven.size() > 1 && driven[1] < driven[0])
      job_.document.refuse(key_of(k) + ".step", shortest_decimal(driven[1] - driven[0]), "a step above 0");
  }

  void add_rows_over(std::size_t driving, const std::vector<double>& values)
  {
    struct Column {
      std::vector<double> at, value;
    };
    std::array<Column, n_joint_coordinates> columns;
    for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
      const CoordinateJob& c = coordinates_.coordinate[k];
      if (c.column.empty()) continue;
      const CsvTable table = table_of(key_of(k) + ".file", c.file);
      const std::string over =
          c.over.empty() ? std::string(joint_coordinate_names[driving]) + unit_suffix(driving) : c.over;
      columns[k] = {ascending_column(table, over), column_of(table, c.column)};
    }
    for (const PushTable& setting : tables_of(out_.push)) set_rows(*setting.table, values);
    for (const double value : values) {
      add_row([&](std::size_t k,
                  double drive) { return linear_at(columns[k].value, position_on(columns[k].at, drive)); },
              value);
    }
  }

  // A table over the driving coordinate as values of each row.
  static void set_rows(FlexionTable& table, const std::vector<double>& driving)
  {
    if (!table.is_over_driving) return;
    Eigen::MatrixXd value(static_cast<Eigen::Index>(driving.size()), table.value.cols());
    for (std::size_t i = 0; i < driving.size(); ++i)
      value.row(static_cast<Eigen::Index>(i)) = value_at_flexion(table, driving[i]).transpose();
    table = {{}, std::move(value), {"driving"}, table.key};
  }

  // `column(k, drive)` is the value of coordinate k's column.
  template <typename Column>
  void add_row(const Column& column, double drive)
  {
    const bool is_grid_varus = out_.rows.role[flexion_row] == CoordinateRole::driven;
    JointCoordinates row = JointCoordinates::Constant(nan);
    const auto set = [&](std::size_t k, double value) {
      row(static_cast<Eigen::Index>(k)) = from_file(value, k);
    };
    for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
      const CoordinateJob& c = coordinates_.coordinate[k];
      if (!c.column.empty()) set(k, column(k, drive));
      if (c.role == CoordinateRole::driven && !(k == varus_row && is_grid_varus)) set(k, drive);
    }
    const double flexion = constant_or(flexion_row, row(0));
    for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
      const CoordinateJob& c = coordinates_.coordinate[k];
      const double at = c.given && c.given->is_over_driving ? drive : std::isnan(flexion) ? 0.0 : flexion;
      if (c.given) set(k, value_at_flexion(*c.given, at)[0]);
    }
    out_.rows.rows.push_back(row);
  }

  // A constant flexion is needed before tables over flexion.
  double constant_or(std::size_t k, double value) const
  {
    const std::optional<FlexionTable>& given = coordinates_.coordinate[k].given;
    return given && given->value.rows() == 1 ? from_file(given->value(0, 0), k) : value;
  }

  void finish_sequence()
  {
    for (const JointCoordinates& row : out_.rows.rows)
      out_.grid.flexion_deg.push_back(std::isnan(row(0)) ? 0.0 : deg_from_rad(row(0)));
    out_.grid.varus_deg = {0.0};
    out_.path_flexion_deg = out_.grid.flexion_deg;
  }

  const Job& job_;
  const CoordinatesJob& coordinates_;
  std::string data_directory_;
  LoadedCoordinates out_;
  std::vector<std::unique_ptr<std::string>> texts_;  // of the tables
};

}  // namespace

std::optional<CoordinatesJob> coordinates_of(const Job& job)
{
  const core::DocumentValue& root = job.document.root;
  const core::DocumentValue *table = core::find_at(root, "coordinates"),
                            *frames = core::find_at(root, "frames");
  if (table == nullptr && frames == nullptr) return std::nullopt;
  CoordinatesJob coordinates;
  if (frames != nullptr) {
    coordinates.frames_file = core::text_at(*frames, "file");
    coordinates.frames_key = core::text_or_empty(*frames, "key");
  }
  for (std::size_t k = 0; table != nullptr && k < n_joint_coordinates; ++k)
    coordinates.coordinate[k] = coordinate_of(job, core::value_at(*table, joint_coordinate_names[k]), k);
  check_roles(job, coordinates);
  return coordinates;
}

void resolve_driving_tables(Job& job)
{
  std::size_t driving = job.coordinates ? n_joint_coordinates : flexion_row;
  for (std::size_t k = n_joint_coordinates; job.coordinates && k-- > 0;) {
    if (job.coordinates->coordinate[k].role == CoordinateRole::driven) driving = k;
  }
  const auto resolve = [&](FlexionTable& table) {
    if (!table.is_over_driving) return;
    if (driving == n_joint_coordinates)
      job.document.refuse(table.key, "a table over the driving coordinate",
                          "a range { from, to, step } for one coordinate, or flexion_deg");
    if (driving != flexion_row) return;
    table.is_over_driving = false;
    for (double& angle : table.flexion_rad) angle = rad_from_deg(angle);
  };
  const bool is_flexion_free =
      job.coordinates && job.coordinates->coordinate[flexion_row].role == CoordinateRole::free;
  const auto resolve_load = [&](FlexionTable& table) {
    if (is_flexion_free && table.flexion_rad.size() > 1 && !table.is_over_driving)
      job.document.refuse(table.key, "a table over flexion, which is free",
                          "a number, or flexion driven or given");
    resolve(table);
  };
  for (const PushTable& setting : tables_of(job.push)) resolve_load(*setting.table);
  resolve_load(job.push.delta);
  if (job.coordinates) {
    for (CoordinateJob& c : job.coordinates->coordinate)
      if (c.given) resolve(*c.given);
  }
  if (job.push.delta.is_over_driving)
    job.document.refuse("push.delta", "a table over another coordinate than flexion",
                        "flexion_deg, or a constant");
}

bool is_plain_grid(const CoordinatesJob& coordinates)
{
  const auto& all = coordinates.coordinate;
  return coordinates.frames_file.empty() && all[flexion_row].role == CoordinateRole::driven &&
         all[varus_row].role != CoordinateRole::given &&
         std::all_of(all.begin() + 2, all.end(),
                     [](const CoordinateJob& c) { return c.role == CoordinateRole::free; });
}

LoadedCoordinates load_coordinates(const Job& job, const CoordinatesJob& coordinates,
                                   const std::string& data_directory)
{
  return Loader(job, coordinates, data_directory).load();
}

std::vector<double> path_of(const std::vector<double>& flexion_deg)
{
  std::vector<double> path_deg;
  for (std::size_t i = 0; i + 1 < flexion_deg.size(); ++i) {
    const double step_deg = flexion_deg[i + 1] - flexion_deg[i];
    const double n = std::ceil(step_deg / largest_path_step_deg);
    for (double k = 0.0; k < n; k += 1.0) path_deg.push_back(flexion_deg[i] + step_deg * k / n);
  }
  path_deg.push_back(flexion_deg.back());
  return path_deg;
}

}  // namespace vrda::job

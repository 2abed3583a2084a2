#include "job/ligament_files.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "core/schema.hpp"
#include "core/text.hpp"
#include "geometry/shapes.hpp"
#include "job/mesh_file.hpp"

namespace vrda::job {
namespace {

constexpr std::size_t max_fibres = 10000;  // the limit of the job schema

enum Quantity : std::size_t {
  q_name,
  q_bundle,
  q_wrap,
  q_reference,  // x, y, z
  q_moving = q_reference + 3,
  q_stiffness = q_moving + 3,
  q_slack_length,
  q_strain,
  q_slack_length_sd,  // of vrda fit; not used
  q_tension_share,
  q_from_body,
  q_to_body,
  n_quantities
};

// A permitted column name, its quantity and the factor of its unit.
struct ColumnName {
  std::string name;
  std::size_t quantity;
  double scale = 1.0;
};

struct Unit {
  const char* suffix;
  double mm;
};
constexpr std::array<Unit, 3> units{{{"_mm", 1.0}, {"_cm", 10.0}, {"_m", 1000.0}}};

// Summary of known_columns() for messages.
constexpr const char* fibre_columns =
    "name, bundle, wrap, reference_x_mm, _y_mm, _z_mm (or femur_...), moving_x_mm, _y_mm, _z_mm (or "
    "tibia_...), "
    "stiffness_n_per_strain (or stiffness_n), slack_length_mm or reference_strain, lengths also in _cm or "
    "_m; "
    "of a follower also from_body, to_body, tension_share";

std::vector<ColumnName> known_columns()
{
  std::vector<ColumnName> known{{"name", q_name}, {"bundle", q_bundle}, {"wrap", q_wrap}};
  struct Object {
    const char* word;
    std::size_t quantity;
  };
  for (const Object object : {Object{"reference", q_reference},
                              {"femur", q_reference},
                              {"from", q_reference},
                              {"moving", q_moving},
                              {"tibia", q_moving},
                              {"to", q_moving}}) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string name = std::string(object.word) + "_" + "xyz"[axis];
      for (const Unit& unit : units) known.push_back({name + unit.suffix, object.quantity + axis, unit.mm});
    }
  }
  known.push_back({"stiffness_n_per_strain", q_stiffness});
  known.push_back({"stiffness_n", q_stiffness});
  for (const Unit& unit : units)
    known.push_back({std::string("slack_length") + unit.suffix, q_slack_length, unit.mm});
  known.push_back({"reference_strain", q_strain});
  known.push_back({"slack_length_sd_mm", q_slack_length_sd});
  known.push_back({"tension_share", q_tension_share});
  known.push_back({"from_body", q_from_body});
  known.push_back({"to_body", q_to_body});
  return known;
}

class Fibres {
 public:
  explicit Fibres(const CsvTable& table) : table_(table)
  {
    for (const std::string_view field : table.columns()) columns_.push_back(column_named(field));
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (columns_[i].quantity != columns_[j].quantity) continue;
        table_.refuse(table_.header(), columns_[i].name,
                      "a second column for the quantity of " + columns_[j].name, "one column for each");
      }
    }
    for (const char* needed : {"name", "reference_x_mm", "reference_y_mm", "reference_z_mm", "moving_x_mm",
                               "moving_y_mm", "moving_z_mm", "stiffness_n_per_strain"}) {
      if (has(column_named(needed).quantity)) continue;
      if (has(q_tension_share) && column_named(needed).quantity == q_stiffness) continue;
      table_.refuse(table_.header(), needed, "no such column",
                    "this column, in mm, cm or m (or femur for reference, tibia for moving)");
    }
    if (has(q_slack_length) || has(q_strain) || has(q_tension_share)) return;
    table_.refuse(table_.header(), "slack_length_mm", "no such column",
                  "slack_length_mm or reference_strain");
  }

  FibreJob fibre(const TableLine& line) const
  {
    const std::vector<std::string_view> fields = table_.fields(line);
    FibreJob fibre;
    fibre.source = table_.file();
    fibre.field = "line " + std::to_string(line.number);
    std::array<std::optional<double>, n_quantities> number;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const ColumnName& column = columns_[i];
      if (column.quantity == q_name) fibre.name = fields[i];
      if (column.quantity == q_bundle) fibre.bundle = fields[i];
      if (column.quantity == q_wrap) fibre.wrap = fields[i];
      if (column.quantity == q_from_body) fibre.from_body = fields[i];
      if (column.quantity == q_to_body) fibre.to_body = fields[i];
      const bool may_be_empty = column.quantity == q_slack_length || column.quantity == q_strain ||
                                column.quantity == q_slack_length_sd || column.quantity == q_tension_share ||
                                (column.quantity == q_stiffness && has(q_tension_share));
      const bool is_number = column.quantity >= q_reference && column.quantity < q_from_body;
      if (is_number && !(fields[i].empty() && may_be_empty))
        number[column.quantity] = number_in(line, column, fields[i]);
    }
    if (fibre.name.empty()) table_.refuse(line, "name", "nothing", "a unique name for each fibre");
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      fibre.reference_native_mm[axis] = *number[q_reference + static_cast<std::size_t>(axis)];
      fibre.moving_native_mm[axis] = *number[q_moving + static_cast<std::size_t>(axis)];
    }
    fibre.tension_share = number[q_tension_share];
    if (fibre.tension_share) {
      if (number[q_stiffness] || number[q_slack_length] || number[q_strain])
        table_.refuse(line, "", "a tension_share beside a stiffness or length", "one of both");
      return fibre;
    }
    if (!number[q_stiffness])
      table_.refuse(line, "stiffness_n_per_strain", "nothing", "a stiffness, or a tension_share");
    fibre.stiffness_n = *number[q_stiffness];
    fibre.slack_length_mm = number[q_slack_length];
    fibre.reference_strain = number[q_strain];
    if (fibre.slack_length_mm.has_value() == fibre.reference_strain.has_value()) {
      table_.refuse(line, "",
                    fibre.slack_length_mm ? "both a slack length and a reference strain" : "neither",
                    "one of slack_length_mm and reference_strain");
    }
    return fibre;
  }

 private:
  bool has(std::size_t quantity) const
  {
    return std::any_of(columns_.begin(), columns_.end(),
                       [&](const ColumnName& column) { return column.quantity == quantity; });
  }

  ColumnName column_named(std::string_view name) const
  {
    static const std::vector<ColumnName> known = known_columns();
    std::vector<std::string> names;
    for (const ColumnName& column : known) {
      if (column.name == name) return column;
      names.push_back(column.name);
    }
    table_.refuse_unknown_column(name, names, fibre_columns);
  }

  double number_in(const TableLine& line, const ColumnName& column, std::string_view field) const
  {
    const std::optional<double> value = parse_real(field);
    if (!value || !std::isfinite(column.scale * *value)) table_.refuse_number(line, column.name, field);
    const bool is_above_0 = column.quantity == q_stiffness || column.quantity == q_slack_length ||
                            column.quantity == q_tension_share;
    if (is_above_0 && !(*value > 0.0))
      table_.refuse(line, column.name, std::string(field), "a number above 0");
    if (column.quantity == q_strain && !(*value > -1.0 && *value <= 1.0))
      table_.refuse(line, column.name, std::string(field), "a strain above -1, at most 1 (3 % is 0.03)");
    return column.scale * *value;
  }

  const CsvTable& table_;
  std::vector<ColumnName> columns_;
};

}  // namespace

std::string default_bundle(const std::string& fibre_name)
{
  std::size_t end = fibre_name.find_last_not_of("0123456789");
  if (end == std::string::npos) return fibre_name;
  const bool has_separator = end + 1 < fibre_name.size() && end > 0 &&
                             std::string_view("_-. ").find(fibre_name[end]) != std::string_view::npos;
  return fibre_name.substr(0, has_separator ? end : end + 1);
}

std::vector<FibreJob> read_ligament_table(const std::string& file, std::string_view text)
{
  const CsvTable table(file, text, {"fibre", "fibres", "fibres"});
  const Fibres rows(table);
  table.require_rows(max_fibres);
  std::vector<FibreJob> fibres;
  for (std::size_t i = 0; i < table.n_rows(); ++i) fibres.push_back(rows.fibre(table.row(i)));
  return fibres;
}

namespace {

constexpr const char* generated_key = "ligaments.generate";

[[noreturn]] void refuse(const FibreJob& fibre, const std::string& key, const std::string& found,
                         const std::string& wanted)
{
  throw InputError({fibre.source, fibre_key(fibre, key), found, wanted});
}

// Both files are read before either is parsed, so a missing file is reported first.
struct Files {
  InputFile fibres, wraps;
};

Files files_of(const Job& job, const std::string& data_directory)
{
  Files files;
  const LigamentsJob& named = *job.ligaments;
  if (!named.fibres_file.empty())
    files.fibres = input_file(job, data_directory, {"ligaments.fibres", named.fibres_file, "a CSV file"});
  if (!named.wraps_file.empty())
    files.wraps = input_file(job, data_directory, {"ligaments.wraps", named.wraps_file, "a JSON file"});
  return files;
}

// Generated fibres are canonical already, like generated parts.
void add_generated(const Job& job, LoadedLigaments& loaded)
{
  const GenerateJob& generate = *job.ligaments->generate;
  const std::string key = generated_key;
  const std::string source = job.document.source_of(key);
  with_job_key(job, key, generate, [&] {
    const geometry::ShapeRequest request{generate.shape, generate.numbers, generate.words};
    for (const geometry::ShapeFibre& fibre : geometry::generate_fibres(request)) {
      loaded.jobs.push_back({fibre.name, fibre.bundle, fibre.reference_mm, fibre.moving_mm, fibre.stiffness_n,
                             fibre.slack_length_mm, std::nullopt, "", source, key});
      loaded.ligaments.fibres.push_back({fibre.name, fibre.bundle, fibre.reference_mm, fibre.moving_mm,
                                         fibre.stiffness_n, fibre.slack_length_mm, -1});
    }
    loaded.inputs.push_back(
        {shape_request_text(generate) + " ligaments", sha256_of(geometry::fibre_table(request))});
  });
}

void add_wraps(const Job& job, const InputFile& file, const BodyMaps& maps, LoadedLigaments& loaded)
{
  const std::string& name = job.ligaments->wraps_file;
  if (name.empty()) return;
  loaded.ligaments.wraps = read_wraps(file.path, file.bytes, {job.reference.name, job.moving.name});
  for (model::Wrap& wrap : loaded.ligaments.wraps)
    wrap.X_body_wrap = canonical(wrap.X_body_wrap, part_of(maps, wrap.body));
  loaded.inputs.push_back({name, sha256_of(file.bytes)});
}

void add_fibres(const Job& job, const InputFile& file, const BodyMaps& maps, LoadedLigaments& loaded)
{
  const LigamentsJob& named = *job.ligaments;
  loaded.jobs = named.fibres;
  if (!named.fibres_file.empty()) {
    loaded.jobs = read_ligament_table(file.path, file.bytes);
    loaded.inputs.push_back({named.fibres_file, sha256_of(file.bytes)});
  }
  check_names(loaded.jobs);
  for (const FibreJob& fibre : loaded.jobs) {
    if (fibre.tension_share || !fibre.from_body.empty() || !fibre.to_body.empty())
      refuse(fibre, fibre.tension_share ? "tension_share" : "from_body", "a column of a follower's fibres",
             "fibres of the joint; those of another object are in [[follower]]");
    loaded.ligaments.fibres.push_back(
        {fibre.name, fibre.bundle.empty() ? default_bundle(fibre.name) : fibre.bundle,
         maps.reference.X_canonical_native * fibre.reference_native_mm,
         maps.moving.X_canonical_native * fibre.moving_native_mm, fibre.stiffness_n,
         fibre.slack_length_mm.value_or(1.0),
         wrap_named(fibre, loaded.ligaments.wraps, named.wraps_file, "ligaments.wraps")});
  }
  set_slack_lengths(loaded, Pose::Identity());
}

std::string in_mm(const Eigen::Vector3d& p)
{
  return "(" + core::numbers_text(p) + ")";
}

void check_inside(const Eigen::Vector3d& p_mm, const FibreJob& fibre, const Body& body,
                  const std::string& key)
{
  const Box box = box_of(body);
  const double margin_mm = 0.5 * (box.max_mm - box.min_mm).maxCoeff();
  const bool is_inside = (p_mm.array() >= box.min_mm.array() - margin_mm).all() &&
                         (p_mm.array() <= box.max_mm.array() + margin_mm).all();
  if (is_inside) return;
  if (fibre.field == generated_key)
    throw InputError(
        {fibre.source, generated_key,
         "generated fibres, which fit the generated bones: \"" + fibre.name + "\" is attached at " +
             in_mm(p_mm) + " mm, away from " + body.name,
         "fibres = \"ligaments.csv\" of these bones (vrda prepare makes them), or no [ligaments]"});
  refuse(fibre, key, "fibre \"" + fibre.name + "\" attached at " + in_mm(p_mm) + " mm in canonical axes",
         "a point within " + shortest_decimal(margin_mm) + " mm of " + body.name + "'s bounding box, " +
             in_mm(box.min_mm) + " to " + in_mm(box.max_mm) + " mm");
}

// Attachments in cm or m give fibres that are 10 or 1000 times too short. Zero lengths are inconclusive.
void check_fibre_unit(const LoadedLigaments& loaded)
{
  constexpr double shortest_mm = 1.0;
  double longest_mm = 0.0;
  for (const model::Fibre& fibre : loaded.ligaments.fibres)
    longest_mm = std::max(longest_mm, (fibre.reference_mm - fibre.moving_mm).norm());
  if (longest_mm == 0.0 || longest_mm >= shortest_mm) return;
  refuse(
      loaded.jobs.front(), "reference_mm",
      "attachments whose longest fibre measures " + short_decimal(longest_mm, 4) + " mm",
      "attachments in mm, independent of frame.unit; a table in m has the columns reference_x_m and so on");
}

}  // namespace

void check_names(const std::vector<FibreJob>& fibres)
{
  std::vector<std::string> names;
  for (const FibreJob& fibre : fibres) names.push_back(fibre.name);
  std::sort(names.begin(), names.end());
  const auto twice = std::adjacent_find(names.begin(), names.end());
  if (twice == names.end()) return;
  const auto is_named = [&](const FibreJob& fibre) { return fibre.name == *twice; };
  const auto first = std::find_if(fibres.begin(), fibres.end(), is_named);
  refuse(*std::find_if(first + 1, fibres.end(), is_named), "name", "\"" + *twice + "\" a second time",
         "a unique name for each fibre");
}

int wrap_named(const FibreJob& fibre, const std::vector<model::Wrap>& wraps, const std::string& wraps_file,
               const std::string& key)
{
  if (fibre.wrap.empty()) return -1;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < wraps.size(); ++i) {
    if (wraps[i].name == fibre.wrap) return static_cast<int>(i);
    names.push_back(wraps[i].name);
  }
  refuse(fibre, "wrap", "\"" + fibre.wrap + "\"",
         wraps_file.empty() ? "no wrap, or " + key + " = \"wraps.json\" with this wrap"
                            : "a wrap of \"" + wraps_file + "\"; the nearest is \"" +
                                  nearest_word(fibre.wrap, names) + "\"");
}

void set_slack_lengths(LoadedLigaments& loaded, const Pose& X_reference_moving)
{
  const model::JointPlacement placement{Eigen::Matrix3d::Identity(), X_reference_moving.linear(),
                                        X_reference_moving.translation()};
  for (std::size_t i = 0; i < loaded.jobs.size(); ++i) {
    const FibreJob& job = loaded.jobs[i];
    if (!job.reference_strain) continue;
    model::Fibre& fibre = loaded.ligaments.fibres[i];
    const double length_mm = model::fibre_path(fibre, loaded.ligaments.wraps, placement).length_mm;
    if (!(length_mm > 0.0))
      refuse(job, "reference_strain", "a fibre without length", "two different attachments");
    fibre.slack_length_mm = length_mm / (1.0 + *job.reference_strain);
  }
}

Pose canonical(const Pose& X_native, const AxisMap& map)
{
  Pose X = Pose::Identity();
  X.linear() = map.X_canonical_native.linear() * X_native.linear();
  X.translation() = map.X_canonical_native * Eigen::Vector3d(X_native.translation());
  return X;
}

std::string fibre_key(const FibreJob& fibre, const std::string& key)
{
  return fibre.field.starts_with("line ") ? fibre.field + ", " + key : fibre.field + "." + key;
}

LoadedLigaments load_ligaments(const Job& job, const std::string& data_directory, const BodyMaps& maps)
{
  LoadedLigaments loaded;
  if (!job.ligaments) return loaded;
  const Files files = files_of(job, data_directory);
  loaded.ligaments.transition_strain = job.ligaments->transition_strain;
  add_wraps(job, files.wraps, maps, loaded);
  if (job.ligaments->generate) {
    add_generated(job, loaded);
  } else {
    add_fibres(job, files.fibres, maps, loaded);
  }
  return loaded;
}

void check_attachments(const LoadedLigaments& loaded, const std::vector<const Body*>& bodies)
{
  check_fibre_unit(loaded);
  for (std::size_t i = 0; i < loaded.jobs.size(); ++i) {
    const model::Fibre& fibre = loaded.ligaments.fibres[i];
    const bool is_line = fibre.tension_n > 0.0;
    if (!is_line || model::row_of(fibre.from) + 1 == bodies.size())
      check_inside(fibre.reference_mm, loaded.jobs[i], *bodies.at(model::row_of(fibre.from)), "reference_mm");
    if (!is_line || model::row_of(fibre.to) + 1 == bodies.size())
      check_inside(fibre.moving_mm, loaded.jobs[i], *bodies.at(model::row_of(fibre.to)), "moving_mm");
  }
}

std::optional<BodyIndex> body_named(const std::string& name, const BodyNames& bodies)
{
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    if (name == bodies[k] || (k > 1 && name.starts_with(bodies[k]))) return static_cast<BodyIndex>(k);
  }
  if (name == "reference" || name.starts_with("femur")) return BodyIndex::reference;
  if (name == "moving" || name.starts_with("tibia")) return BodyIndex::moving;
  return std::nullopt;
}

const core::DocumentSchema& wraps_schema();  // schemas/wraps.schema.json

namespace {

// Largest ratio of half-axes for which the shortest path was always found (pipeline/model/README.md).
constexpr double largest_ratio = 5.0;

// Converts a text such as "1 2 3" to a list of numbers; any other text stays unchanged.
void read_numbers(core::DocumentValue& value)
{
  if (!value.is_string()) return;
  std::vector<double> numbers;
  for (const std::string_view word : split_words(core::text_at(value, ""))) {
    const std::optional<double> number = parse_real(word);
    if (!number) return;
    numbers.push_back(*number);
  }
  value = numbers;
}

// Converts the numeric keys; a list of one number becomes that number for radius and length.
void read_all_numbers(core::DocumentValue& wrap)
{
  for (const char* key : {"xyz_body_rotation", "translation", "dimensions", "radius", "length"}) {
    if (core::DocumentValue* value = core::find_at(wrap, key)) read_numbers(*value);
  }
  for (const char* key : {"radius", "length"}) {
    core::DocumentValue* value = core::find_at(wrap, key);
    if (value != nullptr && value->is_array() && value->size() == 1)
      *value = core::DocumentValue(value->front());
  }
}

// A wrap of the validated document and its index, for messages.
struct Entry {
  const core::Document& document;
  const core::DocumentValue& value;
  std::string index;

  std::string key(const std::string& name) const { return index + "." + name; }

  Eigen::Vector3d vector(const std::string& name) const
  {
    return Eigen::Vector3d::Map(core::numbers_at(value, name).data());
  }
};

model::WrapShape shape_of(const Entry& entry)
{
  const std::string& type = core::text_at(entry.value, "type");
  const bool is_cylinder = type == "WrapCylinder";
  for (const char* name : {"radius", "length", "dimensions"}) {
    const bool is_wanted = is_cylinder == (name != std::string("dimensions"));
    const bool is_given = entry.value.contains(name);
    if (is_wanted == is_given) continue;
    entry.document.refuse(
        entry.key(name), is_given ? "a key of the other type" : "nothing",
        "for a " + type + (is_cylinder ? " radius and length" : " three dimensions") + ", lengths above 0");
  }
  return is_cylinder ? model::WrapShape::cylinder : model::WrapShape::ellipsoid;
}

BodyIndex body_of(const Entry& entry, const BodyNames& bodies)
{
  if (const std::optional<BodyIndex> body = body_named(core::text_at(entry.value, "body"), bodies))
    return *body;
  std::string names = "\"reference\", \"moving\", ";
  for (const std::string& name : bodies) names += '"' + name + "\", ";
  entry.document.refuse_value(entry.key("body"), names + "or a name that begins with femur or tibia");
}

Eigen::Vector3d radii_of(const Entry& entry, model::WrapShape shape)
{
  if (shape == model::WrapShape::cylinder) {
    const double radius = core::number_at(entry.value, "radius");
    return {radius, radius, 0.5 * core::number_at(entry.value, "length")};
  }
  const Eigen::Vector3d radii = entry.vector("dimensions");
  if (radii.maxCoeff() > largest_ratio * radii.minCoeff()) {
    entry.document.refuse_value(entry.key("dimensions"),
                                "three half-axes above 0, the largest at most five times the smallest");
  }
  return radii;
}

model::Wrap wrap_of(const Entry& entry, const BodyNames& bodies)
{
  model::Wrap wrap;
  wrap.name = core::text_at(entry.value, "name");
  wrap.shape = shape_of(entry);
  wrap.body = body_of(entry, bodies);
  const double unit_mm = mm_per_unit(core::text_at(entry.value, "unit"));
  wrap.radii_mm = unit_mm * radii_of(entry, wrap.shape);
  const Eigen::Vector3d angles_rad = entry.vector("xyz_body_rotation");
  wrap.X_body_wrap.linear() =
      rotation_x(angles_rad.x()) * rotation_y(angles_rad.y()) * rotation_z(angles_rad.z());
  wrap.X_body_wrap.translation() = unit_mm * entry.vector("translation");
  return wrap;
}

}  // namespace

std::vector<model::Wrap> read_wraps(const std::string& file, const std::string& text, const BodyNames& bodies)
{
  core::Document document{file, core::parse_json(text, file, "a list of wraps in JSON"), {}, "wrap."};
  if (document.root.is_array()) {
    for (core::DocumentValue& wrap : document.root) read_all_numbers(wrap);
  }
  document.root = wraps_schema().checked(document);
  std::vector<model::Wrap> wraps;
  std::set<std::string> names;
  for (const core::DocumentValue& value : document.root) {
    const Entry entry{document, value, std::to_string(wraps.size())};
    wraps.push_back(wrap_of(entry, bodies));
    if (!names.insert(wraps.back().name).second)
      document.refuse(entry.key("name"), core::shown(core::value_at(value, "name")) + " a second time",
                      "a unique name");
  }
  return wraps;
}

CsvTable::CsvTable(std::string file, std::string_view text, const RowLabels& words)
    : file_(std::move(file)), words_(words), lines_(table_lines(text))
{
  require_table(file_, text);
  if (lines_.empty()) {
    throw InputError(
        {file_, "", "no line except comments", std::string("column names, then ") + words_.full_plural});
  }
  separator_ = separator_of(header().text);
  columns_ = split_fields(header().text, separator_);
}

void CsvTable::require_rows(std::size_t max_rows) const
{
  if (n_rows() == 0) refuse(header(), "", std::string("column names but no ") + words_.one, "at least one");
  if (n_rows() > max_rows) {
    refuse(header(), "", std::to_string(n_rows()) + ' ' + words_.many, "at most " + std::to_string(max_rows));
  }
}

std::vector<std::string_view> CsvTable::fields(const TableLine& row) const
{
  if (has_control_characters(row.text, "\t\r")) refuse(row, "", "control characters", "plain text");
  std::vector<std::string_view> fields = split_fields(row.text, separator_);
  if (fields.size() == columns_.size()) return fields;
  refuse(row, "", std::to_string(fields.size()) + " fields",
         "as many as the columns of line " + std::to_string(header().number) + ", " +
             std::to_string(columns_.size()) + ", separated by " +
             (separator_ == ','   ? "commas"
              : separator_ == ';' ? "semicolons"
              : separator_ == '|' ? "vertical bars"
                                  : "tabs"));
}

void CsvTable::refuse(const TableLine& line, const std::string& column, const std::string& found,
                      const std::string& wanted) const
{
  const std::string place = "line " + std::to_string(line.number);
  throw InputError({file_, column.empty() ? place : place + ", " + column, found, wanted});
}

void CsvTable::refuse_unknown_column(std::string_view name, const std::vector<std::string>& known,
                                     const std::string& description) const
{
  constexpr std::size_t max_compared = 100;  // characters: bounds the cost of the edit distance
  refuse(header(), "", "the unknown column " + quoted(name),
         (columns_.size() == 1 ? "columns separated by commas, semicolons, tabs or |: " : "") + description +
             "; the nearest is " + quoted(nearest_word(std::string(name.substr(0, max_compared)), known)));
}

void CsvTable::refuse_number(const TableLine& line, const std::string& column, std::string_view field) const
{
  refuse(line, column, field.empty() ? "nothing" : quoted(field), wanted_number(field));
}

std::size_t CsvTable::column_named(const std::string& name, const std::string& wanted) const
{
  const auto found = std::find(columns_.begin(), columns_.end(), name);
  if (found != columns_.end()) return static_cast<std::size_t>(found - columns_.begin());
  refuse(header(), name.empty() ? "column" : name, "no column of this name",
         wanted + quoted(nearest_word(name, {columns_.begin(), columns_.end()})));
}

std::vector<double> CsvTable::numbers(std::size_t column, EmptyField empty) const
{
  std::vector<double> values;
  for (std::size_t i = 0; i < n_rows(); ++i) {
    const std::string_view field = fields(row(i))[column];
    if (field.empty() && empty == EmptyField::missing) {
      values.push_back(nan);
      continue;
    }
    const std::optional<double> value = parse_real(field);
    if (!value || !std::isfinite(*value)) refuse_number(row(i), std::string(columns_[column]), field);
    values.push_back(*value);
  }
  return values;
}

std::string CsvTable::quoted(std::string_view text)
{
  return '"' + std::string(text) + '"';
}

const core::DocumentSchema& landmarks_schema();  // schemas/landmarks.schema.json

namespace {

constexpr std::size_t max_pairs = 10000;  // more is probably another kind of file
constexpr double least_distance = 1e-9;   // as in the schema

// A row as a table by column. Empty fields are omitted; invalid numbers stay text, which the schema rejects.
core::Document row_of(const CsvTable& table, const std::vector<std::string_view>& columns,
                      const std::vector<std::string_view>& fields, const TableLine& line)
{
  core::Document row{table.file(), core::DocumentValue::object()};
  row.lines[""] = static_cast<int>(line.number);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::optional<double> number = columns[i] == "name" ? std::nullopt : parse_real(fields[i]);
    const std::string column(columns[i]);
    if (fields[i].empty()) continue;
    if (number && std::isfinite(*number)) {
      row.root[column] = *number;
    } else {
      row.root[column] = fields[i];
    }
  }
  return row;
}

std::vector<std::string_view> columns_of(const CsvTable& table)
{
  std::vector<std::string_view> columns = table.columns();
  const core::Document header = row_of(table, columns, columns, table.header());
  landmarks_schema().check_known_keys(header);
  landmarks_schema().check_required_keys(header);
  for (const std::string_view column : columns) {
    if (std::count(columns.begin(), columns.end(), column) > 1)
      header.refuse(std::string(column), "a second column of this name", "each column once");
  }
  return columns;
}

LandmarkPair pair_of(const core::Document& row)
{
  const core::DocumentValue pair = landmarks_schema().checked(row);
  const auto point = [&](const std::string& of) {
    return Eigen::Vector3d(core::number_at(pair, of + "x"), core::number_at(pair, of + "y"),
                           core::number_at(pair, of + "z"));
  };
  const LandmarkPair landmarks{core::text_at(pair, "name"), point("a"), point("b"),
                               core::number_at(pair, "subject_mm")};
  if (!((landmarks.a_native - landmarks.b_native).norm() > least_distance))
    row.refuse("", "two coincident points", "two landmarks at different positions");
  return landmarks;
}

}  // namespace

std::vector<LandmarkPair> read_landmarks(const std::string& file, std::string_view text)
{
  const CsvTable table(file, text, {"pair", "pairs", "pairs of landmarks"});
  const std::vector<std::string_view> columns = columns_of(table);
  table.require_rows(max_pairs);
  std::vector<LandmarkPair> pairs;
  std::set<std::string> names;
  for (std::size_t i = 0; i < table.n_rows(); ++i) {
    const core::Document row = row_of(table, columns, table.fields(table.row(i)), table.row(i));
    pairs.push_back(pair_of(row));
    if (!names.insert(pairs.back().name).second)
      row.refuse("name", CsvTable::quoted(pairs.back().name) + " a second time",
                 "a unique name for each pair");
  }
  return pairs;
}

Scaling fit_scaling(const std::vector<LandmarkPair>& pairs, double unit_mm)
{
  check(!pairs.empty(), "fitting a factor requires at least one pair");
  Scaling scaling;
  double model_subject = 0.0, model_sq = 0.0, residual_sq = 0.0;
  for (const LandmarkPair& pair : pairs) {
    const double model_mm = unit_mm * (pair.a_native - pair.b_native).norm();
    scaling.landmark.push_back(pair.name);
    scaling.model_mm.push_back(model_mm);
    scaling.subject_mm.push_back(pair.subject_mm);
    model_subject += model_mm * pair.subject_mm;
    model_sq += model_mm * model_mm;
  }
  const double factor = model_subject / model_sq;
  scaling.factor.setConstant(factor);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double residual_mm = scaling.subject_mm[i] - factor * scaling.model_mm[i];
    scaling.residual_mm.push_back(residual_mm);
    residual_sq += residual_mm * residual_mm;
  }
  const auto n = static_cast<double>(pairs.size());
  scaling.residual_rms_mm = std::sqrt(residual_sq / n);
  if (pairs.size() > 1) scaling.standard_error = std::sqrt(residual_sq / (n - 1.0) / model_sq);
  return scaling;
}

}  // namespace vrda::job

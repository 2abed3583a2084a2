#include "job/slicer_files.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/document.hpp"
#include "core/text.hpp"
#include "job/component_loader.hpp"
#include "job/thesis_files.hpp"

namespace vrda::job {
namespace {

constexpr const char* spaces_wanted = "LPS or RAS";

bool is_space(const std::string& word)
{
  return word == "LPS" || word == "RAS";
}

void require_space(const std::string& file, const std::string& field, const std::string& word)
{
  if (!is_space(word)) throw InputError({file, field, quoted_word(word), spaces_wanted});
}

}  // namespace

std::string scan_space(const std::string& file, std::string_view bytes)
{
  constexpr std::size_t header_bytes = 1024;
  constexpr std::string_view key = "SPACE=";
  const std::string_view header = bytes.substr(0, header_bytes);
  const std::size_t at = header.find(key);
  if (at == header.npos) return "";
  const std::string_view rest = header.substr(at + key.size());
  const std::string word(rest.substr(0, rest.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ")));
  require_space(file, "header, SPACE", word);
  return word;
}

std::string common_space(const std::vector<FileSpace>& files)
{
  const FileSpace* first = nullptr;
  for (const FileSpace& one : files) {
    if (one.second.empty()) continue;
    if (first == nullptr) first = &one;
    if (one.second != first->second)
      throw InputError({one.first, "header, SPACE", one.second,
                        first->second + ", as in " + first->first + ": save both in one space"});
  }
  return first == nullptr ? "" : first->second;
}

void require_one_space(const Job& job, const std::string& data_directory)
{
  std::vector<FileSpace> of_joint;
  const auto check_body = [&](const std::vector<ComponentJob>& components, bool has_frame) {
    std::vector<FileSpace> own;
    for (const ComponentJob& component : components) {
      if (component.generate) continue;
      const InputFile file =
          input_file(job, data_directory, {component.key + ".file", component.file, "a mesh file"});
      (has_frame ? own : of_joint).emplace_back(file.path, scan_space(file.path, file.bytes));
    }
    common_space(own);
  };
  for (const BodyJob* body : {&job.reference, &job.moving})
    check_body(body->components, body->frame.has_value());
  for (const FollowerJob& follower : job.followers)
    check_body(follower.body.components, follower.body.frame.has_value());
  common_space(of_joint);
}

bool is_slicer_points(const std::string& file)
{
  const std::string name = lower_case(file);
  return name.ends_with(".mrk.json") || name.ends_with(".fcsv");
}

namespace {

// Version 4.10 and earlier write a number: 0 is RAS, 1 LPS.
std::string space_of(const std::string& word)
{
  return word == "0" ? "RAS" : word == "1" ? "LPS" : word;
}

void add_point(SlicerPoints& points, const std::string& file, const std::string& field,
               const LabelledPoint& point)
{
  for (const LabelledPoint& other : points.points)
    if (other.label == point.label)
      throw InputError(
          {file, field, quoted_word(point.label) + " a second time", "a label of its own for each point"});
  points.points.push_back(point);
}

void read_markup(SlicerPoints& points, const std::string& file, const std::string& key,
                 const core::DocumentValue& markup)
{
  const auto word = [&](const char* name, const char* otherwise) {
    const core::DocumentValue* value = core::find_key(markup, name);
    return value != nullptr && value->is_string() ? value->get<std::string>() : std::string(otherwise);
  };
  const std::string space = space_of(word("coordinateSystem", "LPS")), unit = word("coordinateUnits", "mm");
  require_space(file, key + ".coordinateSystem", space);
  if (unit != "mm" && unit != "cm" && unit != "m")
    throw InputError({file, key + ".coordinateUnits", quoted_word(unit), "mm, cm or m"});
  if (points.space.empty()) points.space = space;
  const core::DocumentValue* list = core::find_key(markup, "controlPoints");
  for (std::size_t k = 0; list != nullptr && list->is_array() && k < list->size(); ++k) {
    const core::DocumentValue& point = (*list)[k];
    const std::string at = key + ".controlPoints." + std::to_string(k);
    const core::DocumentValue *status = core::find_key(point, "positionStatus"),
                              *label = core::find_key(point, "label");
    if (status != nullptr && *status == "undefined") continue;
    const core::DocumentValue* position = core::find_key(point, "position");
    bool is_good = position != nullptr && position->is_array() && position->size() == 3;
    for (std::size_t i = 0; is_good && i < 3; ++i) is_good = (*position)[i].is_number();
    if (!is_good)
      throw InputError({file, at + ".position", position == nullptr ? "nothing" : core::shown(*position),
                        "three numbers"});
    SlicerPoints one{space,
                     {{label != nullptr && label->is_string() ? label->get<std::string>() : "",
                       mm_per_unit(unit) * core::vector3_at(*position, "")}}};
    add_point(points, file, at + ".label", in_space(one, points.space).points.front());
  }
}

void read_json(SlicerPoints& points, const std::string& file, const std::string& text)
{
  const core::DocumentValue root = core::parse_json(text, file, "markups of 3D Slicer");
  const core::DocumentValue* markups = core::find_key(root, "markups");
  if (markups == nullptr || !markups->is_array())
    throw InputError({file, "markups", "nothing", "a list of markups of 3D Slicer"});
  for (std::size_t k = 0; k < markups->size(); ++k)
    read_markup(points, file, "markups." + std::to_string(k), (*markups)[k]);
}

std::vector<std::string> fields_of_line(const std::string& line)
{
  std::vector<std::string> fields{""};
  for (const char c : line) {
    if (c == ',') {
      fields.emplace_back();
    } else if (c != '\r') {
      fields.back() += c;
    }
  }
  return fields;
}

// id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,...
void read_fcsv(SlicerPoints& points, const std::string& file, const std::string& text)
{
  constexpr std::string_view key = "CoordinateSystem";
  constexpr std::size_t label_column = 11;
  points.space = "RAS";  // of files without the line
  std::size_t line_number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin), at = "line " + std::to_string(++line_number);
    begin = end + 1;
    if (line.starts_with('#')) {
      const std::size_t found = line.find(key);
      if (found == line.npos) continue;
      const std::size_t first = line.find_first_not_of(" =", found + key.size());
      points.space =
          space_of(first == line.npos ? "" : line.substr(first, line.find_first_of(" \r", first) - first));
      require_space(file, at + ", CoordinateSystem", points.space);
      continue;
    }
    const std::vector<std::string> fields = fields_of_line(line);
    if (fields.size() <= 1) continue;
    if (fields.size() <= label_column)
      throw InputError({file, at, std::to_string(fields.size()) + " columns",
                        "id, x, y, z, ow, ox, oy, oz, vis, sel, lock, label"});
    const NamedText numbers{file, fields[1] + " " + fields[2] + " " + fields[3]};
    TextLines words(numbers);
    if (!words.next() || words.words().size() != 3)
      throw InputError({file, at, quoted_word(numbers.text), "three coordinates"});
    LabelledPoint point{fields[label_column], {}};
    for (std::size_t i = 0; i < 3; ++i)
      point.p_mm[static_cast<Eigen::Index>(i)] = words.real(i, "a coordinate");
    add_point(points, file, at + ", label", point);
  }
}

}  // namespace

SlicerPoints read_slicer_points(const std::string& file, const std::string& text)
{
  SlicerPoints points;
  if (lower_case(file).ends_with(".fcsv")) {
    read_fcsv(points, file, text);
  } else {
    read_json(points, file, text);
  }
  if (points.points.empty()) throw InputError({file, "", "no points", "at least one point that is set"});
  return points;
}

SlicerPoints in_space(SlicerPoints points, const std::string& space)
{
  if (space.empty() || points.space.empty() || space == points.space) return points;
  for (LabelledPoint& point : points.points) point.p_mm.head<2>() *= -1.0;
  points.space = space;
  return points;
}

std::string markups_text(const std::vector<Markup>& markups, const std::string& space)
{
  using Json = nlohmann::ordered_json;
  Json list = Json::array();
  for (const Markup& markup : markups) {
    Json points = Json::array();
    for (const LabelledPoint& point : markup.points)
      points.push_back({{"id", std::to_string(points.size() + 1)},
                        {"label", point.label},
                        {"position", {point.p_mm.x(), point.p_mm.y(), point.p_mm.z()}},
                        {"positionStatus", "defined"}});
    list.push_back({{"type", markup.is_line ? "Line" : "Fiducial"},
                    {"name", markup.name},
                    {"coordinateSystem", space},
                    {"coordinateUnits", "mm"},
                    {"controlPoints", points}});
  }
  const Json root{{"@schema",
                   "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/"
                   "Resources/Schema/markups-schema-v1.0.3.json#"},
                  {"markups", list}};
  return core::json_text(root, 1) + "\n";
}

}  // namespace vrda::job

#include "show/view_state.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>

#include "core/document.hpp"
#include "core/text.hpp"
#include "store/motion.hpp"

namespace vrda::show {
namespace {

using Json = DocumentValue;

constexpr const char* state_format = "vrda view state";
constexpr double largest_mm = 1e5, largest_degrees = 360.0;
// As on the page.
constexpr std::array<const char*, 6> page_views{"oblique", "front", "back", "medial", "lateral", "top"};
constexpr std::array<std::pair<const char*, BodyIndex>, 3> fixed_names{
    {{"reference", BodyIndex::reference}, {"moving", BodyIndex::moving}, {"push", BodyIndex::world}}};

std::string names_of(std::initializer_list<const char*> names)
{
  return joined(std::vector<std::string>(names.begin(), names.end()));
}

/// An object of the state, with the name of the source for messages.
class Fields {
 public:
  Fields(std::string source, std::string path, const Json& value, std::initializer_list<const char*> keys)
      : source_(std::move(source)), path_(std::move(path)), value_(value)
  {
    if (!value.is_object()) refuse("", value, "an object");
    for (const auto& item : value.items()) {
      const std::string& key = item.key();
      const bool is_known = std::ranges::any_of(keys, [&](const char* known) { return key == known; });
      if (!is_known) throw InputError({source_, joined_key(path_, key), "this key", names_of(keys)});
    }
  }

  [[noreturn]] void refuse(const std::string& key, const Json& found, const std::string& wanted) const
  {
    throw InputError({source_, key.empty() ? path_ : joined_key(path_, key), shown(found), wanted});
  }
  /// Null if it is missing.
  const Json* find(const char* key) const { return find_key(value_, key); }
  const Json& at(const char* key) const
  {
    const Json* const found = find(key);
    if (found == nullptr) throw InputError({source_, joined_key(path_, key), "nothing", "this key"});
    return *found;
  }
  double number(const char* key, double most, const std::string& wanted) const
  {
    const Json& found = at(key);
    if (!found.is_number() || !(std::abs(found.get<double>()) <= most)) refuse(key, found, wanted);
    return found.get<double>();
  }
  std::string text(const char* key, const std::string& wanted) const
  {
    const Json& found = at(key);
    if (!found.is_string()) refuse(key, found, wanted);
    return found.get<std::string>();
  }
  bool flag(const char* key, bool if_missing) const
  {
    const Json* const found = find(key);
    if (found == nullptr) return if_missing;
    if (!found->is_boolean()) refuse(key, *found, "true or false");
    return found->get<bool>();
  }
  Eigen::Vector3d point(const char* key, const std::string& wanted) const
  {
    const Json& found = at(key);
    const bool is_list = found.is_array() && found.size() == 3;
    const bool is_point = is_list && std::ranges::all_of(found, [](const Json& x) {
                            return x.is_number() && std::abs(x.get<double>()) <= largest_mm;
                          });
    if (!is_point) refuse(key, found, wanted);
    return {found[0].get<double>(), found[1].get<double>(), found[2].get<double>()};
  }
  Fields object(const char* key, std::initializer_list<const char*> keys) const
  {
    return {source_, joined_key(path_, key), at(key), keys};
  }

 private:
  std::string source_, path_;
  const Json& value_;
};

Eigen::Vector3d rounded(const Eigen::Vector3d& p_mm)
{
  return p_mm.unaryExpr([](double x) { return std::round(1e3 * x) / 1e3 + 0.0; });
}

/// "%7B" is "{", "+" a space.
std::string url_decoded(std::string_view text)
{
  std::string decoded;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const auto digit = [&](std::size_t i) {
      const char c = i < text.size() ? text[i] : 'x';
      return c >= '0' && c <= '9' ? c - '0' : (c | 32) >= 'a' && (c | 32) <= 'f' ? (c | 32) - 'a' + 10 : -1;
    };
    const int high = digit(k + 1), low = digit(k + 2);
    if (text[k] == '%' && high >= 0 && low >= 0) {
      decoded += static_cast<char>(16 * high + low);
      k += 2;
    } else {
      decoded += text[k] == '+' ? ' ' : text[k];
    }
  }
  return decoded;
}

view::Section section_of(const Fields& fields)
{
  const std::string wanted = "sagittal, coronal, axial, or a unit vector";
  view::Section section;
  section.at_mm = fields.number("at_mm", largest_mm, "mm");
  const Json& plane = fields.at("plane");
  section.kind = view::SectionKind::free;
  if (plane.is_string()) {
    for (const view::SectionKind kind :
         {view::SectionKind::sagittal, view::SectionKind::coronal, view::SectionKind::axial})
      if (plane.get<std::string>() == name_of(kind)) section.kind = kind;
    if (section.kind == view::SectionKind::free) fields.refuse("plane", plane, wanted);
    return section;
  }
  section.normal = fields.point("plane", wanted);
  if (std::abs(section.normal.norm() - 1.0) > 1e-2) fields.refuse("plane", plane, wanted);
  section.normal.normalize();
  return section;
}

void read_view(const Fields& fields, ViewState& state)
{
  const std::string wanted =
      names_of({"oblique", "front", "back", "medial", "lateral", "top"}) + ", or eye_mm and target_mm";
  const Json& view = fields.at("view");
  if (view.is_object()) {
    const Fields own = fields.object("view", {"eye_mm", "target_mm", "roll"});
    state.place = CameraPlace{own.point("eye_mm", "three numbers"), own.point("target_mm", "three numbers")};
    if (own.find("roll") != nullptr) state.place->roll_deg = own.number("roll", largest_degrees, "degrees");
    if ((state.place->eye_mm - state.place->target_mm).norm() < 1e-6)
      own.refuse("target_mm", own.at("target_mm"), "another point than eye_mm");
    return;
  }
  const bool is_known =
      view.is_string() && std::ranges::any_of(page_views, [&](const char* name) { return view == name; });
  if (!is_known) fields.refuse("view", view, wanted);
  state.view = view.get<std::string>();
}

}  // namespace

ViewState read_view_state(const std::string& given)
{
  const std::string wanted = "the state of a view (schemas/view-state.md)";
  std::string text = given, source = "--view";
  const std::size_t at = given.find("view=");
  if (const std::size_t hash = given.find('#'); hash != std::string::npos && at > hash) {
    text = at == std::string::npos ? "" : given.substr(at + 5, given.find('&', at) - at - 5);
    text = url_decoded(text);
  } else if (!given.starts_with('{')) {
    text = read_document_text(given, wanted);
    source = given;
  }
  const Json root = parse_json(text, source, wanted);
  const Fields fields(source, "", root,
                      {"format", "version", "set", "flexion", "varus", "fixed", "view", "whole", "labels",
                       "band", "section", "structures", "highlighted"});
  if (fields.at("format") != state_format)
    fields.refuse("format", fields.at("format"), "\"" + std::string(state_format) + "\"");
  if (fields.at("version") != 1) fields.refuse("version", fields.at("version"), "1");
  ViewState state;
  state.set = fields.text("set", "the name of a set");
  state.flexion_deg = fields.number("flexion", largest_degrees, "degrees");
  if (fields.find("varus") != nullptr) state.varus_deg = fields.number("varus", largest_degrees, "degrees");
  const std::string fixed = fields.text("fixed", "reference, moving or push");
  const auto found = std::ranges::find_if(fixed_names, [&](const auto& row) { return fixed == row.first; });
  if (found == fixed_names.end()) fields.refuse("fixed", fields.at("fixed"), "reference, moving or push");
  state.fixed = found->second;
  read_view(fields, state);
  state.whole = fields.flag("whole", false);
  state.labels = fields.flag("labels", false);
  state.band = fields.flag("band", false);
  if (fields.find("section") != nullptr)
    state.section = section_of(fields.object("section", {"plane", "at_mm"}));
  if (const Json* const structures = fields.find("structures")) {
    if (!structures->is_object()) fields.refuse("structures", *structures, "an object");
    for (const auto& [id, look] : structures->items()) {
      const Fields own(source, "structures." + id, look, {"visible", "opacity"});
      // A layer of contact is named to be visible or translucent; without "visible" it is not.
      view::StructureLook wanted_look{own.flag("visible", !id.starts_with("layers/")), 1.0F};
      if (own.find("opacity") != nullptr) {
        const double opacity = own.number("opacity", 1.0, "a number above 0, at most 1");
        if (!(opacity > 0.0)) own.refuse("opacity", own.at("opacity"), "a number above 0, at most 1");
        wanted_look.opacity = static_cast<float>(opacity);
      }
      state.structures.emplace_back(id, wanted_look);
    }
  }
  if (fields.find("highlighted") != nullptr)
    state.highlighted = fields.text("highlighted", "the id of a structure");
  return state;
}

void require_of_model(const ViewState& state, const std::string& given, const store::MotionModel& model)
{
  const std::string source =
      given.starts_with('{') || given.find('#') != std::string::npos ? "--view" : given;
  const std::vector<std::string> sets = store::all_set_names(model);
  if (std::ranges::find(sets, state.set) == sets.end())
    throw InputError({source, "set", "\"" + state.set + "\"", joined(sets)});
  const std::vector<view::Structure> structures = view::structures_of(model);
  const auto require = [&](const char* field, const std::string& id) {
    if (std::ranges::find(structures, id, &view::Structure::id) != structures.end()) return;
    throw InputError({source, field, "\"" + id + "\"", "a structure of the model"});
  };
  for (const auto& [id, look] : state.structures) require("structures", id);
  if (!state.highlighted.empty()) require("highlighted", state.highlighted);
}

std::string view_state_text(const ViewState& state)
{
  const auto list = [](const Eigen::Vector3d& p) {
    const Eigen::Vector3d q = rounded(p);
    return Json{q.x(), q.y(), q.z()};
  };
  Json root;
  root["format"] = state_format;
  root["version"] = 1;
  root["set"] = state.set;
  const auto angle = [](double angle_deg) { return std::round(1e6 * angle_deg) / 1e6 + 0.0; };
  root["flexion"] = angle(state.flexion_deg);
  if (state.varus_deg) root["varus"] = angle(*state.varus_deg);
  root["fixed"] =
      std::ranges::find(fixed_names, state.fixed, [](const auto& row) { return row.second; })->first;
  if (state.place) {
    root["view"]["eye_mm"] = list(state.place->eye_mm);
    root["view"]["target_mm"] = list(state.place->target_mm);
    if (const double roll = angle(state.place->roll_deg); roll != 0.0) root["view"]["roll"] = roll;
  } else {
    root["view"] = state.view;
  }
  if (state.whole) root["whole"] = true;
  if (state.labels) root["labels"] = true;
  if (state.band) root["band"] = true;
  if (state.section.kind != view::SectionKind::none) {
    if (state.section.kind == view::SectionKind::free) {
      root["section"]["plane"] = list(state.section.normal);
    } else {
      root["section"]["plane"] = name_of(state.section.kind);
    }
    root["section"]["at_mm"] = state.section.at_mm;
  }
  for (const auto& [id, look] : state.structures) {
    const bool is_first_visible = !id.starts_with("layers/");
    if (look.is_visible != is_first_visible) root["structures"][id]["visible"] = look.is_visible;
    if (look.opacity != 1.0F)
      root["structures"][id]["opacity"] = std::round(1e3 * static_cast<double>(look.opacity)) / 1e3;
  }
  if (!state.highlighted.empty()) root["highlighted"] = state.highlighted;
  return json_text(root, 2) + "\n";
}

view::Camera placed(view::Camera camera, const CameraPlace& place)
{
  const Eigen::Vector3d back = (place.eye_mm - place.target_mm).normalized();
  const Eigen::Vector3d aside = Eigen::Vector3d::UnitY().cross(back);
  const Eigen::Vector3d right =
      aside.norm() > 1e-6 ? aside.normalized() : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
  camera.X_world_camera.linear() << right, back.cross(right), back;
  camera.X_world_camera.linear() *= rotation_z(rad_from_deg(place.roll_deg));
  camera.X_world_camera.translation() = place.eye_mm;
  return camera;
}

CameraPlace place_of(const view::OrbitCamera& gaze)
{
  const Pose& X = gaze.camera.X_world_camera;
  CameraPlace place{rounded(X.translation()), rounded(X * Eigen::Vector3d(0.0, 0.0, -view::depth_mm(gaze)))};
  const Eigen::Vector3d right =
      placed(gaze.camera, place).X_world_camera.linear().transpose() * X.linear().col(0);
  place.roll_deg = deg_from_rad(std::atan2(right.y(), right.x()));
  return place;
}

}  // namespace vrda::show

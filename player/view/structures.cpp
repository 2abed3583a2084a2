#include "view/structures.hpp"

#include <regex.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <span>

#include "core/text.hpp"

namespace vrda::view {
namespace {

struct KnownStructure {
  const char *pattern, *name, *does;  ///< the name is empty if it is that of the model
};

// Generated from the page's structures.js: known_bundles, known_parts.
#include "view/structure_table.hpp"

bool matches(const char* pattern, const std::string& name)
{
  regex_t compiled;
  check(regcomp(&compiled, pattern, REG_EXTENDED | REG_ICASE | REG_NOSUB) == 0, "a pattern is valid");
  const bool is_match = regexec(&compiled, name.c_str(), 0, nullptr, 0) == 0;
  regfree(&compiled);
  return is_match;
}

/// The first that matches; the last matches all.
const KnownStructure& known(std::span<const KnownStructure> table, const std::string& name)
{
  return *std::ranges::find_if(table, [&](const KnownStructure& row) { return matches(row.pattern, name); });
}

/// "meniscus_medial" is "Medial meniscus", "tibia_cartilage_1" is "Tibia cartilage 1".
std::string plain_name(std::string name)
{
  for (const std::string side : {"medial", "lateral"})
    if (name.ends_with("_" + side)) name = side + " " + name.substr(0, name.size() - side.size() - 1);
  std::ranges::replace(name, '_', ' ');
  if (!name.empty()) name[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
  return name;
}

void add(std::vector<Structure>& all, const Structure& structure)
{
  if (std::ranges::find(all, structure.id, &Structure::id) == all.end()) all.push_back(structure);
}

void add_parts(std::vector<Structure>& all, const Body& body, const std::string& path)
{
  for (std::size_t k = 0; k < body.components.size(); ++k) {
    const std::string name = structure_name(body.components, k), &material = body.components[k].material;
    const bool is_soft = material == "cartilage" || material == "meniscus";
    add(all, {path + "/" + name, plain_name(name),
              known(known_parts, material == "cartilage" ? material : name).does,
              is_soft ? StructureGroup::soft_tissue : StructureGroup::bones});
  }
}

void add_bundles(std::vector<Structure>& all, const model::Ligaments& ligaments, const std::string& path)
{
  for (const model::Fibre& fibre : ligaments.fibres) {
    const std::string bundle = fibre.bundle.empty() ? "Fibres" : fibre.bundle;
    const KnownStructure& found = known(known_bundles, bundle);
    add(all, {path + "/" + fibre.bundle, *found.name == 0 ? bundle : found.name, found.does,
              StructureGroup::ligaments});
  }
}

}  // namespace

const char* heading_of(StructureGroup group)
{
  return std::array{"bones", "cartilage and menisci", "ligaments", "contact"}.at(
      static_cast<std::size_t>(group));
}

std::string structure_name(const std::vector<Component>& components, std::size_t component)
{
  const Component& own = components[component];
  const std::string* shortest = &own.name;
  for (const Component& other : components) {
    const bool is_whole = other.material == own.material && own.name.starts_with(other.name + "_");
    if (is_whole && other.name.size() < shortest->size()) shortest = &other.name;
  }
  return *shortest;
}

std::string body_path(BodyIndex body, const std::string& follower)
{
  if (body == BodyIndex::reference) return "bodies/reference";
  return body == BodyIndex::moving ? "bodies/moving" : "followers/" + follower + "/body";
}

std::string ligaments_path(const std::string& follower)
{
  return follower.empty() ? "ligaments" : "followers/" + follower + "/ligaments";
}

std::vector<Structure> structures_of(const store::MotionModel& model)
{
  std::vector<Structure> all;
  add_parts(all, model.reference, body_path(BodyIndex::reference));
  add_parts(all, model.moving, body_path(BodyIndex::moving));
  for (const store::FollowerRows& follower : model.followers)
    add_parts(all, follower.body, body_path(static_cast<BodyIndex>(follower.body_index), follower.name));
  add_bundles(all, store::ligaments_of(model), ligaments_path(""));
  for (const store::FollowerRows& follower : model.followers)
    add_bundles(all, store::ligaments_of(follower), ligaments_path(follower.name));
  add(all, {gap_structure, "Gap map", "The distance from the tibia's side to the other bone along the push.",
            StructureGroup::contact});
  if (model.contact_paths)
    add(all, {paths_structure, "Contact paths",
              "Where the bones touch over flexion: medial blue, lateral orange.", StructureGroup::contact});
  std::ranges::stable_sort(all, {}, &Structure::group);
  return all;
}

Layer layer_of(const Structure& structure)
{
  if (structure.id == gap_structure) return Layer::gap_map;
  if (structure.id == paths_structure) return Layer::contact_paths;
  return structure.group == StructureGroup::ligaments ? Layer::ligaments : Layer::bodies;
}

void change(Looks& looks, const std::vector<Structure>& structures, LookChange change)
{
  if (change != LookChange::show_all && !looks.highlighted) return;
  for (std::size_t k = 0; k < looks.of.size(); ++k) {
    const bool is_own = change == LookChange::show_all || k == looks.highlighted;
    if (structures[k].group == StructureGroup::contact) {
      looks.of[k].opacity = is_own ? 1.0F : looks.of[k].opacity;
    } else if (is_own) {
      looks.of[k] = {};
    } else if (change == LookChange::isolate) {
      looks.of[k].is_visible = false;
    } else {
      looks.of[k] = {true, faded_opacity};
    }
  }
}

model::JointPlacement placement_of(const model::Fibre& fibre, const store::JointPose& pose)
{
  const Pose X_from_to = fibre.from == BodyIndex::reference
                             ? pose.X_reference(fibre.to)
                             : Pose(pose.X_reference(fibre.from).inverse() * pose.X_reference(fibre.to));
  return {Eigen::Matrix3d::Identity(), X_from_to.linear(), X_from_to.translation()};
}

BundleReader::BundleReader(const store::MotionModel& model)
{
  all_.push_back({ligaments_path("") + "/", store::ligaments_of(model)});
  for (const store::FollowerRows& follower : model.followers)
    all_.push_back({ligaments_path(follower.name) + "/", store::ligaments_of(follower)});
}

std::optional<BundleReading> BundleReader::at(const std::string& structure,
                                              const store::JointPose& pose) const
{
  if (pose.status != store::PoseStatus::solved) return std::nullopt;
  const auto is_placed = [&](BodyIndex body) {
    return model::row_of(body) < 2 || pose.has_follower.at(model::follower_row(body));
  };
  std::optional<BundleReading> found;
  for (const Bundles& bundles : all_) {
    for (const model::Fibre& fibre : bundles.ligaments.fibres) {
      const bool is_own = structure.size() == bundles.path.size() + fibre.bundle.size() &&
                          structure.starts_with(bundles.path) && structure.ends_with(fibre.bundle);
      if (!is_own || !is_placed(fibre.from) || !is_placed(fibre.to)) continue;
      if (!found) found = {-1.0, 0.0, true};
      if (fibre.tension_n > 0.0) {
        found->tension_n += fibre.tension_n;
        continue;
      }
      const double length_mm =
          model::fibre_path(fibre, bundles.ligaments.wraps, placement_of(fibre, pose)).length_mm;
      const double strain = length_mm / fibre.slack_length_mm - 1.0;
      found->strain = found->is_line ? strain : std::max(found->strain, strain);
      found->is_line = false;
      found->tension_n +=
          model::tension_of(strain, fibre.stiffness_n, bundles.ligaments.transition_strain).force_n;
    }
  }
  return found;
}

}  // namespace vrda::view

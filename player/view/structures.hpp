/// The structures of a joint: what a user shows, hides, fades and touches (schemas/view-state.md).
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/frames.hpp"
#include "model/mesh.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "view/scene.hpp"

namespace vrda::view {

enum class StructureGroup { bones, soft_tissue, ligaments, contact };
const char* heading_of(StructureGroup group);

struct Structure {
  std::string id, name;
  std::string does;  ///< one sentence
  StructureGroup group = StructureGroup::bones;
};

inline constexpr const char *gap_structure = "layers/gaps", *paths_structure = "layers/contact_paths";

/// The structure of a component: "femur_shaft" belongs to "femur" if both have one material.
std::string structure_name(const std::vector<Component>& components, std::size_t component);
/// The path of a body's group in the motion model; `follower`: its name.
std::string body_path(BodyIndex body, const std::string& follower = {});
/// That of the ligaments of a follower, or of the joint if the name is empty.
std::string ligaments_path(const std::string& follower);

/// In the order of the groups. Names and sentences are those of the page (web/page/structures.js).
std::vector<Structure> structures_of(const store::MotionModel& model);

/// The layer that shows a structure; Layer::bodies for a part of a body.
Layer layer_of(const Structure& structure);

struct StructureLook {
  bool is_visible = true;
  float opacity = 1.0F;
  bool operator==(const StructureLook&) const = default;
};
inline constexpr float faded_opacity = 0.2F, least_opacity = 0.1F;

/// What is shown of each structure. The visibility of layers of contact is that of their layers.
struct Looks {
  std::vector<StructureLook> of;  ///< [n_structures]
  std::optional<std::size_t> highlighted;
};

/// Of the highlighted structure or, to show all, of every one; layers of contact stay as they are.
enum class LookChange { isolate, fade_others, show_all };
void change(Looks& looks, const std::vector<Structure>& structures, LookChange change);

struct BundleReading {
  double strain = 0.0;     ///< the largest of its fibres
  double tension_n = 0.0;  ///< of all of them
  bool is_line = false;    ///< of constant tension, without a strain
};

/// The bodies of a fibre at a pose in the frame of its first body.
model::JointPlacement placement_of(const model::Fibre& fibre, const store::JointPose& pose);

/// Strain and tension of the bundles of a model at poses.
class BundleReader {
 public:
  explicit BundleReader(const store::MotionModel& model);
  /// Of a structure; empty for others than bundles and without a pose. Allocates nothing.
  std::optional<BundleReading> at(const std::string& structure, const store::JointPose& pose) const;

 private:
  struct Bundles {
    std::string path;
    model::Ligaments ligaments;
  };
  std::vector<Bundles> all_;
};

}  // namespace vrda::view

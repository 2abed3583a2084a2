/// Section planes: the planes on offer, and the filled cuts of the solids.
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "view/scene.hpp"

namespace vrda::view {

enum class SectionKind { none, sagittal, coronal, axial, free };
const char* name_of(SectionKind kind);

/// What a user has chosen (schemas/view-state.md).
struct Section {
  SectionKind kind = SectionKind::none;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit, of a free one
  double at_mm = 0.0;
  bool operator==(const Section&) const = default;
};
/// Empty for none.
std::optional<SectionPlane> plane_of(const Section& section);

/// Parses "sagittal=0", "axial=-12.5" or "1,0,0.5=3" (a normal of any length). Throws InputError naming
/// `option`.
Section parsed_section(const std::string& option, const std::string& text);

/// The cuts of all visible bodies by the scene's section, one drawable a structure: solids are filled, and
/// overlapping ones of one structure have one cut; an open sheet, which has no inside, is a line. A cut is
/// exact to `row_mm` across its rows.
class SectionCaps {
 public:
  /// Appends the drawables, hidden, to `scene`, whose order must not change afterwards.
  explicit SectionCaps(Scene& scene);
  /// At the present placement of the solids; hides the cuts without a section.
  void update(Scene& scene);

  static constexpr double row_mm = 0.05;  ///< a third of a pixel of a knee that fills a picture
  static constexpr double line_mm = 0.6;  ///< four such pixels

 private:
  struct Cut {
    struct Body {
      std::size_t drawable = 0;
      bool is_solid = false;
    };
    std::size_t drawable = 0;
    std::vector<Body> bodies;
    std::vector<Pose> X_world_mesh;  ///< of them at the last update
    std::vector<bool> is_cut;        ///< whether they were visible
  };
  std::vector<Cut> cuts_;
  std::optional<SectionPlane> last_;
};

}  // namespace vrda::view

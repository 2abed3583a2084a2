/// The state of a view as plain data (schemas/view-state.md), which the page reads and writes too.
#pragma once

#include <Eigen/Core>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "model/frames.hpp"
#include "store/motion_model.hpp"
#include "view/camera.hpp"
#include "view/section.hpp"
#include "view/structures.hpp"

namespace vrda::show {

/// Where a camera is and looks, in the axes of what is fixed on screen, and its roll about that line from the
/// camera whose right is horizontal (world Y is up) towards its up.
struct CameraPlace {
  Eigen::Vector3d eye_mm = Eigen::Vector3d::Zero(), target_mm = Eigen::Vector3d::Zero();
  double roll_deg = 0.0;
};

/// Angles in degrees, as in the file.
struct ViewState {
  std::string set;
  double flexion_deg = 0.0;
  std::optional<double> varus_deg;
  BodyIndex fixed = BodyIndex::moving;
  std::string view = "oblique";  ///< a name, unless `place` is given
  std::optional<CameraPlace> place;
  bool whole = false, labels = false, band = false;
  view::Section section;
  std::vector<std::pair<std::string, view::StructureLook>>
      structures;           ///< by id; of the others the first looks
  std::string highlighted;  ///< empty: none
};

/// Reads a state given by `--view`: the text itself, an address of the page, or the name of a file. Throws
/// InputError naming the field.
ViewState read_view_state(const std::string& given);
/// Throws InputError if the model does not have what the state names.
void require_of_model(const ViewState& state, const std::string& given, const store::MotionModel& model);

std::string view_state_text(const ViewState& state);

/// `camera` at that place.
view::Camera placed(view::Camera camera, const CameraPlace& place);
/// The place of a camera, rounded as in the file, with the target at the pivot's depth.
CameraPlace place_of(const view::OrbitCamera& gaze);

}  // namespace vrda::show

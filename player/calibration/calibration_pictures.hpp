/// Pictures of the calibration of a virtual bench (thesis, figures 22, 23 and 26).
#pragma once

#include <Eigen/Core>

#include "calibration/calibrate.hpp"
#include "calibration/virtual_bench.hpp"
#include "store/motion_model.hpp"
#include "view/eye.hpp"
#include "view/image.hpp"
#include "view/overlay_text.hpp"
#include "view/renderer.hpp"

namespace vrda::calibration {

/// Placement of a part of a frame buffer on a sheet.
struct SheetFrame {
  view::ShownBox source;
  Eigen::Vector2d at_px = Eigen::Vector2d::Zero();  ///< upper left corner on the sheet
  double scale = 1.0;                               ///< sheet px per frame buffer px
};

/// An off-screen picture with frames, lines and text.
class Sheet {
 public:
  Sheet(int width, int height);

  /// Line widths are not scaled; lines are clipped at the frame.
  void add_lines(const SheetFrame& frame, std::span<const DrawnLine> lines);
  void add_area(const SheetFrame& frame, const view::ShownBox& box, const view::VertexColour& colour);
  /// `at_px`: on the sheet.
  void add_words(const Eigen::Vector2d& at_px, const std::string& words, const view::VertexColour& colour);
  float width_px(const std::string& words) const { return text_.width_px(words); }

  /// Valid until the next call.
  const view::Image& image();

 private:
  view::OverlayBox clip_of(const SheetFrame& frame) const;

  std::unique_ptr<view::Renderer> renderer_;
  view::OverlayText text_;
  view::Overlay overlay_;
  view::Scene nothing_;
};

/// Outline of a box as a closed line.
DrawnLine outline_of(const view::ShownBox& box, const std::array<float, 3>& colour, double width_px = 1.5);

struct OverlayPictureOptions {
  std::string set;   ///< surface set of the model
  int height = 560;  ///< px, filled by the leg
};

/// Simulated view of the left eye through its true optics, with the stage in front of the leg (thesis, figure
/// 26): the real leg in grey (the model in the subject's true size) plus the picture that a bench with
/// `calibration` draws; black is transparent.
view::Image overlay_picture(const BenchFile& bench, const VirtualTruth& truth, const Calibration& calibration,
                            const store::MotionModel& model, const OverlayPictureOptions& options);

struct PictureRequest {
  const BenchFile& bench;
  const VirtualTruth& truth;
  const Calibration& found;
  const std::vector<Task>& tasks;  ///< finished tasks; their marks are in `found`
};

/// Writes viewport.png, distortion.png, rectangles.png, bullseye.png and, with a model, overlay.png to the
/// folder of the options. Returns the paths. Throws InputError.
std::vector<std::string> write_calibration_pictures(const PictureRequest& request,
                                                    const CalibrateOptions& options);

}  // namespace vrda::calibration

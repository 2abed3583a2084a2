/// Pictures of what a virtual bench found (thesis, figures 22, 23 and 26).
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "calibrate/calibrate.hpp"
#include "gui/overlay_text.hpp"
#include "guide/drawing.hpp"
#include "optics/eye.hpp"
#include "render/image.hpp"
#include "render/renderer.hpp"
#include "store/motion_model.hpp"
#include "virtual_bench/truth.hpp"

namespace vrda {

/// A part of a frame buffer, as large as it is shown within the sheet.
struct SheetFrame {
  ShownBox source;
  Eigen::Vector2d at_px = Eigen::Vector2d::Zero();  ///< of the sheet: its upper left corner
  double scale = 1.0;                               ///< px of the sheet by px of the frame buffer
};

class Sheet {
 public:
  Sheet(int width, int height);

  /// Lines keep their width; what lies beyond the frame is cut off.
  void add_lines(const SheetFrame& frame, std::span<const GuideLine> lines);
  void add_area(const SheetFrame& frame, const ShownBox& box, const VertexColour& colour);
  /// `at_px`: of the sheet.
  void add_words(const Eigen::Vector2d& at_px, const std::string& words, const VertexColour& colour);
  float width_px(const std::string& words) const { return text_.width_px(words); }

  /// Valid until the next.
  const Image& image();

 private:
  OverlayBox clip_of(const SheetFrame& frame) const;

  std::unique_ptr<Renderer> renderer_;
  OverlayText text_;
  Overlay overlay_;
  Scene nothing_;
};

/// The outline of a box, as a closed line.
GuideLine outline_of(const ShownBox& box, const std::array<float, 3>& colour, double width_px = 1.5);

/// What an eye sees of a leg and of the picture laid over it (thesis, figure 26).
struct OverlayPictureOptions {
  std::string set;   ///< of the model
  int height = 560;  ///< px; the leg fills it
};

/// Through the left eye's true optics, with the stage before the leg: the leg as it is, grey (the model
/// itself, in the subject's true size), and added to it, since black is transparent, what a bench calibrated
/// so draws.
Image overlay_picture(const BenchFile& bench, const VirtualTruth& truth, const Calibration& calibration,
                      const MotionModel& model, const OverlayPictureOptions& options);

struct PictureRequest {
  const BenchFile& bench;
  const VirtualTruth& truth;
  const Calibration& found;
  const std::vector<Task>& tasks;  ///< done; their marks stand in `found`
};

/// viewport.png, distortion.png, rectangles.png, bullseye.png and, with the options' model, overlay.png, into
/// their folder. Returns the paths. Throws InputError.
std::vector<std::string> write_calibration_pictures(const PictureRequest& request,
                                                    const CalibrateOptions& options);

}  // namespace vrda

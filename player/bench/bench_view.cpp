#include "bench/bench_view.hpp"

namespace vrda {
namespace {

/// Whether both have the same warp: where the eye is makes no difference to it.
bool has_same_warp(const Eye& a, const Eye& b)
{
  return a.visible == b.visible && a.distortion == b.distortion;
}

}  // namespace

BenchView::BenchView(const MotionModel& model, const BenchFile& bench, const Calibration& calibration,
                     const LookOptions& look)
    : file_(bench.path),
      display_(bench.display),
      scene_(scene_of(model.reference, model.moving, Eigen::Vector3d::Zero())),
      eyes_(calibration.eyes),
      plan_(stereo_plan(calibration.eyes, bench.display.width, bench.display.height, bench.path)),
      panel_(bench)
{
  scene_.background = background_of(Backdrop::black);  // black is transparent on the display
  dress(scene_, look);
}

void BenchView::load_into(Renderer& renderer) const
{
  renderer.load(scene_);
  renderer.load(panel_.font());
  renderer.load(plan_.warp);
}

void BenchView::place(const BenchFrame& frame, const Calibration& calibration)
{
  JointFrames frames;
  frames.X_world_reference = frame.X_tracker_reference;
  frames.X_world_delta = frame.X_tracker_moving;
  vrda::place(scene_, frames);
  shots_ = shots_of(plan_, calibration.eyes, frame.X_tracker_eyes, scene_);
}

bool BenchView::take(const EyePair& eyes)
{
  if (eyes_ == eyes) return false;
  const bool has_new_warp = !has_same_warp(eyes_.left, eyes.left) || !has_same_warp(eyes_.right, eyes.right);
  plan_ = stereo_plan(eyes, display_.width, display_.height, file_);
  eyes_ = eyes;
  return has_new_warp;
}

}  // namespace vrda

#include "bench/camera.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "core/schema.hpp"
#include "show/settings_text.hpp"

namespace vrda::bench {

const core::DocumentSchema& camera_schema();  // schemas/camera.schema.json

Camera read_camera(const std::string& path)
{
  const std::string text =
      core::read_document_text(path, "a camera calibration (vrda-webcam calibrate writes it)");
  const core::Document document = camera_schema().read(text, path);
  Camera camera;
  camera.width = static_cast<int>(core::integer_at(document.root, "width"));
  camera.height = static_cast<int>(core::integer_at(document.root, "height"));
  const std::vector<double> focal = core::numbers_at(document.root, "focal_px"),
                            centre = core::numbers_at(document.root, "centre_px"),
                            distortion = core::numbers_at(document.root, "distortion");
  camera.focal_px = {focal[0], focal[1]};
  camera.centre_px = {centre[0], centre[1]};
  std::ranges::copy(distortion, camera.distortion.begin());
  camera.rms_px = core::number_at(document.root, "rms_px");
  camera.n_views = static_cast<int>(core::integer_at(document.root, "views"));
  return camera;
}

std::string camera_text(const Camera& camera)
{
  const auto list = [](std::span<const double> values) { return show::list_text(values); };
  return "# Written by vrda-webcam calibrate; valid for this camera, picture size and focus.\nwidth = " +
         std::to_string(camera.width) + "\nheight = " + std::to_string(camera.height) +
         "\nfocal_px = " + list({camera.focal_px.data(), 2}) +
         "\ncentre_px = " + list({camera.centre_px.data(), 2}) + "\ndistortion = " + list(camera.distortion) +
         "  # k1, k2, p1, p2, k3\nrms_px = " + show::number_text(camera.rms_px) +
         "\nviews = " + std::to_string(camera.n_views) + "\n";
}

}  // namespace vrda::bench

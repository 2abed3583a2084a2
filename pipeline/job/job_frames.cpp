// The frames of a job: of the joint and of a body (schemas/frames.md).
#include "job/auto_frame.hpp"

#include <tuple>

#include "core/units.hpp"

namespace vrda::job {
namespace {

constexpr const char* automatic = "auto";

bool is_automatic(const core::DocumentValue& root, const std::string& key)
{
  const std::string* word = core::value_at(root, key).text();
  return word != nullptr && *word == automatic;
}

// A frame that is found has no axes to name.
void check_automatic(const core::Document& document, const FrameJob& frame)
{
  if (!frame.is_origin_auto && !frame.is_align_auto) return;
  if (core::text_at(document.root, "joint") != "knee")
    document.refuse(frame.key, "\"auto\" with joint = \"" + core::text_at(document.root, "joint") + "\"",
                    "numbers: only the frames of a knee are found");
  if (!frame.is_align_auto) return;
  for (const auto& [key, word, preset] :
       {std::tuple(".anterior", &frame.anterior, "+X"), std::tuple(".proximal", &frame.proximal, "+Y"),
        std::tuple(".right", &frame.right, "+Z")}) {
    if (*word != preset)
      document.refuse(frame.key + key, "\"" + *word + "\" with align = \"auto\"",
                      "no axes, or align with numbers");
  }
}

core::DocumentValue::List list_of(const Eigen::Vector3d& v)
{
  return {{v.x()}, {v.y()}, {v.z()}};
}

}  // namespace

FrameJob frame_at(const core::DocumentValue& root, const std::string& key)
{
  FrameJob frame;
  frame.key = key;
  frame.unit = core::text_at(root, key + ".unit");
  frame.anterior = core::text_at(root, key + ".anterior");
  frame.proximal = core::text_at(root, key + ".proximal");
  frame.right = core::text_at(root, key + ".right");
  frame.is_origin_auto = is_automatic(root, key + ".origin");
  frame.is_align_auto = is_automatic(root, key + ".align");
  if (!frame.is_origin_auto) frame.origin_native = core::vector3_at(root, key + ".origin");
  if (frame.is_align_auto) return frame;
  const Eigen::Vector3d rotation_deg = core::vector3_at(root, key + ".align.rotation_deg");
  for (int k = 0; k < 3; ++k) frame.align_rotation_rad[k] = rad_from_deg(rotation_deg[k]);
  frame.align_translation_mm = core::vector3_at(root, key + ".align.translation_mm");
  return frame;
}

std::optional<FrameJob> body_frame_at(const core::Document& document, const std::string& body)
{
  const std::string key = body + ".frame";
  if (core::find_at(document.root, key) == nullptr) return std::nullopt;
  FrameJob frame = frame_at(document.root, key);
  check_automatic(document, frame);
  return frame;
}

void set_found_frame(core::Document& document, BodyJob& body, const FoundFrame& found)
{
  if (!body.frame) return;
  const std::string key = body.frame->key;
  core::DocumentValue* frame = document.root.find(key.substr(0, key.find('.')))->find("frame");
  if (body.frame->is_origin_auto) frame->find("origin")->data = list_of(found.origin_native);
  if (body.frame->is_align_auto)
    frame->find("align")->data =
        core::DocumentValue::Table{{"rotation_deg", {list_of(found.rotation_deg)}},
                                        {"translation_mm", {list_of(Eigen::Vector3d::Zero())}}};
  body.frame = frame_at(document.root, key);
}

}  // namespace vrda::job

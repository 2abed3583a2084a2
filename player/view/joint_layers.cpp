#include "view/joint_layers.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "view/layers.hpp"

namespace vrda::view {
namespace {

VertexColour rgb(unsigned hex)
{
  const auto byte = [&](unsigned shift) { return static_cast<std::uint8_t>(hex >> shift & 0xFFU); };
  return {byte(16), byte(8), byte(0), 255};
}

std::uint8_t rounded(double value)
{
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

}  // namespace

VertexColour interpolated_colour(const VertexColour& a, const VertexColour& b, double part)
{
  VertexColour colour{};
  for (std::size_t k = 0; k < colour.size(); ++k) colour[k] = rounded(a[k] + part * (b[k] - a[k]));
  return colour;
}

VertexColour colour_of(const Legend& legend, double value)
{
  if (value < legend.lowest && !legend.below_label.empty()) return legend.below;
  constexpr std::size_t last = std::tuple_size_v<Palette> - 1;
  const double position =
      std::clamp((value - legend.lowest) / (legend.highest - legend.lowest), 0.0, 1.0) * last;
  const std::size_t before = std::min(static_cast<std::size_t>(position), last - 1);
  return interpolated_colour(legend.palette[before], legend.palette[before + 1],
                             position - static_cast<double>(before));
}

double srgb_of(double linear)
{
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

double linear_of(double srgb)
{
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

VertexColour srgb_from_linear(const Eigen::Vector3f& linear)
{
  const auto channel = [&](Eigen::Index k) {
    const double c = linear[k];
    return rounded(255.0 * srgb_of(c));
  };
  return {channel(0), channel(1), channel(2), 255};
}

Eigen::Vector3f linear_from_srgb(const VertexColour& colour)
{
  const auto channel = [&](std::size_t k) {
    const double c = colour[k] / 255.0;
    return static_cast<float>(linear_of(c));
  };
  return {channel(0), channel(1), channel(2)};
}

const Palette& gap_palette()
{
  static const Palette palette{rgb(0xF0F921), rgb(0xFCCE25), rgb(0xFCA636), rgb(0xF2844B),
                               rgb(0xE16462), rgb(0xCC4778), rgb(0xB12A90), rgb(0x8F0DA4),
                               rgb(0x6A00A8), rgb(0x41049D), rgb(0x0D0887)};
  return palette;
}

const Palette& strain_palette()
{
  static const Palette palette{rgb(0x3B4CC0), rgb(0x5977E3), rgb(0x7B9FF9), rgb(0x9EBEFF),
                               rgb(0xC0D4F5), rgb(0xDDDCDC), rgb(0xF2CBB7), rgb(0xF7AC8E),
                               rgb(0xEE8468), rgb(0xD65244), rgb(0xB40426)};
  return palette;
}

const std::vector<std::string>& layer_names()
{
  static const std::vector<std::string> names{"contacts",  "normals",       "axes",   "helical-axis", "gaps",
                                              "ligaments", "contact-paths", "labels", "band"};
  return names;
}

const std::string& name_of(Layer layer)
{
  check(layer != Layer::bodies, "only optional layers have names");
  return layer_names()[static_cast<std::size_t>(layer) - 1];
}

std::optional<Layer> layer_named(const std::string& name)
{
  const auto found = std::ranges::find(layer_names(), name);
  if (found == layer_names().end()) return std::nullopt;
  return static_cast<Layer>(found - layer_names().begin() + 1);
}

struct JointLayers::Parts {
  Parts(const store::MotionModel& model, Scene& scene)
      : contacts(model, scene),
        axes(model, scene),
        helical_axis(model, scene),
        gaps(model, scene),
        ligaments(model, scene),
        contact_paths(model, scene),
        band(model, scene)
  {
  }

  ContactLayer contacts;
  AxesLayer axes;
  HelicalAxisLayer helical_axis;
  GapLayer gaps;
  LigamentLayer ligaments;
  ContactPathLayer contact_paths;
  BandLayer band;
};

JointLayers::JointLayers(const store::MotionModel& model, Scene& scene)
    : parts_(std::make_unique<Parts>(model, scene))
{
  available_.set(Layer::contacts, !parts_->contacts.is_empty());
  available_.set(Layer::normals, !parts_->contacts.is_empty());
  available_.set(Layer::axes, true);
  available_.set(Layer::helical_axis, model.flexion_deg.size() > 1);
  available_.set(Layer::gap_map, !parts_->gaps.is_empty());
  available_.set(Layer::ligaments, !parts_->ligaments.is_empty());
  available_.set(Layer::contact_paths, !parts_->contact_paths.is_empty());
  available_.set(Layer::labels, true);
  available_.set(Layer::band, !parts_->band.is_empty());
}

JointLayers::~JointLayers() = default;
JointLayers::JointLayers(JointLayers&&) noexcept = default;
JointLayers& JointLayers::operator=(JointLayers&&) noexcept = default;

void JointLayers::update(Scene& scene, const store::Motion& motion, const DisplayedPose& shown)
{
  for (Drawable& drawable : scene.drawables) {
    if (drawable.layer != Layer::bodies) drawable.is_shown = false;
  }
  if (shown.pose.status != store::PoseStatus::solved) return;
  const LayerSet& wanted = shown.layers;
  parts_->contacts.update(scene, shown.pose, wanted);
  if (wanted.has(Layer::axes)) parts_->axes.update(scene, motion, shown);
  if (wanted.has(Layer::helical_axis)) parts_->helical_axis.update(scene, motion, shown);
  if (wanted.has(Layer::gap_map)) parts_->gaps.update(scene, motion, shown.pose);
  if (wanted.has(Layer::ligaments)) parts_->ligaments.update(scene, shown.pose);
  if (wanted.has(Layer::contact_paths)) parts_->contact_paths.show(scene);
  if (wanted.has(Layer::band)) parts_->band.update(scene, shown);
}

const Legend& JointLayers::gap_legend() const
{
  return parts_->gaps.legend();
}

const Legend& JointLayers::strain_legend() const
{
  return parts_->ligaments.legend();
}

}  // namespace vrda::view

#include "view/appearance.hpp"

#include <limits>

#include "core/error.hpp"
#include "view/arguments.hpp"
#include "view/image.hpp"
#include "view/joint_layers.hpp"

namespace vrda::view {
namespace {

/// Opacity of transparent bodies. At most four walls of a closed bone are in front of an object inside it:
/// about half of its light still passes, and the bone stays visible.
constexpr float transparent_opacity = 0.18F;

constexpr double least_scale_mm = 0.1, most_scale_mm = 1000.0;

void set_texture(view::Scene& scene, const AppearanceOptions& look)
{
  if (look.texture.empty()) return;
  if (!(look.texture_scale_mm >= least_scale_mm && look.texture_scale_mm <= most_scale_mm)) {
    throw InputError(
        {"--texture-scale", "", std::to_string(look.texture_scale_mm) + " mm", "0.1 to 1000 mm"});
  }
  scene.texture = view::read_png_texture(look.texture);
  scene.texture.scale_mm = look.texture_scale_mm;
}

/// Applies `change` to the bodies of "reference", "moving" or "both"; their layers stay as they are.
void change_bodies(view::Scene& scene, const std::string& object, void (*change)(view::Drawable&))
{
  for (view::Drawable& drawable : scene.drawables) {
    const bool is_other =
        object == (drawable.parent == view::ParentFrame::reference ? "moving" : "reference");
    if (drawable.layer == view::Layer::bodies && !is_other) change(drawable);
  }
}

/// "reference" or "moving" by this word or the displayed name; `more` is another accepted word. Throws
/// InputError naming `option`.
std::string object_named(const view::Scene& scene, const std::string& name, const char* option,
                         const std::string& more)
{
  if (name == "reference" || name == scene.reference_name) return "reference";
  if (name == "moving" || name == scene.moving_name) return "moving";
  if (!more.empty() && name == more) return name;
  throw InputError({option, "", "\"" + name + "\"",
                    scene.reference_name + " or " + scene.moving_name + " (or reference, moving" +
                        (more.empty() ? "" : ", " + more) + ")"});
}

void set_transparency(view::Scene& scene, const std::string& name)
{
  if (name.empty()) return;
  change_bodies(scene, object_named(scene, name, "--see-through", "both"),
                [](view::Drawable& body) { body.material.opacity *= transparent_opacity; });
}

void set_hidden(view::Scene& scene, const std::string& name)
{
  if (name.empty()) return;
  change_bodies(scene, object_named(scene, name, "--hide", ""),
                [](view::Drawable& body) { body.is_shown = false; });
}

}  // namespace

std::vector<Eigen::Vector3d> framed_points(const view::Scene& scene, Framing framed)
{
  constexpr double everywhere_mm = std::numeric_limits<double>::infinity();
  return view::points_within(scene, framed == Framing::all
                                         ? view::Sphere{Eigen::Vector3d::Zero(), everywhere_mm}
                                         : view::joint_sphere(scene));
}

view::LayerSet parsed_layers(const std::string& text)
{
  view::LayerSet layers;
  if (text.empty() || text == "none") return layers;
  if (text == AppearanceOptions{}.layers) {
    layers.set(view::Layer::ligaments, true);
    return layers;
  }
  std::string known;
  for (const std::string& name : view::layer_names()) known += (known.empty() ? "" : ", ") + name;
  for (const std::string& name : split(text, ',')) {
    const std::optional<view::Layer> layer = view::layer_named(name);
    if (!layer) throw InputError({"--layers", "", "\"" + name + "\"", "some of " + known});
    if (layers.has(*layer)) throw InputError({"--layers", "", name + " twice", "every layer once"});
    layers.set(*layer, true);
  }
  return layers;
}

void apply_appearance(view::Scene& scene, const AppearanceOptions& look)
{
  scene.mode = look.mode;
  set_texture(scene, look);
  if (!look.lights.empty()) {
    const view::Lights lights = view::read_lights(look.lights);
    scene.lighting = lights.lighting;
    if (lights.background) scene.background = *lights.background;
  }
  set_transparency(scene, look.see_through);
  set_hidden(scene, look.hidden);
}

}  // namespace vrda::view

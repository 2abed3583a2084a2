// The options that say how things look.
#include "app/options.hpp"

#include <CLI/CLI.hpp>
#include <map>

#include "app/named_choice.hpp"

namespace vrda {

void add_look(CLI::App& mode, LookOptions& look)
{
  mode.add_option("--layers", look.layers,
                  "What to show beside the bodies: contacts, normals (forces where they are known), axes, "
                  "helical-axis, gaps, ligaments")
      ->type_name("LAYER,...");
  const std::map<std::string, DrawMode> modes{{"wire", DrawMode::wire},
                                              {"hidden-line", DrawMode::hidden_line},
                                              {"flat", DrawMode::flat},
                                              {"smooth", DrawMode::smooth},
                                              {"textured", DrawMode::textured}};
  mode.add_option("--mode", look.mode, "wire, hidden-line, flat, smooth or textured (default textured)")
      ->transform(named_choice(numbers_of(modes)))
      ->type_name("MODE")
      ->option_text("MODE");
  mode.add_option("--texture", look.texture,
                  "Picture for bone, repeated: its edges should meet (default: mottled)")
      ->type_name("FILE.png");
  mode.add_option("--texture-scale", look.texture_scale_mm, "Width of one repeat")
      ->type_name("MM")
      ->capture_default_str();
  mode.add_option("--lights", look.lights, "Lights and background (default: those of the studio)")
      ->type_name("FILE.toml");
  mode.add_option("--see-through", look.see_through, "Objects to look through: reference, moving or both")
      ->type_name("NAME");
  mode.add_option("--hide", look.hidden, "Object to leave out, but for its layers: reference or moving")
      ->type_name("NAME");
}

}  // namespace vrda

#include "job/job_text.hpp"

#include "core/text.hpp"
#include "core/document.hpp"
#include "core/value.hpp"

namespace vrda::job {
namespace {

// anterior = "+Z", proximal = "+Y", right = "-X"
Eigen::Vector3d canonical(const Eigen::Vector3d& native)
{
  return {native.z(), native.y(), -native.x()};
}

std::string list_of(const Eigen::Vector3d& v)
{
  return "[" + shortest_decimal(v.x()) + ", " + shortest_decimal(v.y()) + ", " + shortest_decimal(v.z()) +
         "]";
}

// A line with an optional comment. Comments are aligned in one column.
std::string line(const std::string& text, const std::string& comment = "")
{
  constexpr std::size_t column = 38;
  if (comment.empty()) return text + '\n';
  return text + std::string(text.size() < column ? column - text.size() : 1, ' ') + "# " + comment + '\n';
}

std::string components_text(const std::string& body, const std::vector<std::string>& models,
                            const std::string& folder)
{
  const std::string prefix = folder.empty() ? "" : folder + "/";
  std::string text;
  for (const std::string& model : models) {
    const std::string file = prefix + model + ".obj";
    text += line("\n[[" + body + ".component]]");
    text += line("name = " + core::value_text({model}));
    text += line("file = " + core::value_text({file}));
  }
  return text;
}

std::string range_text(const AngleRange& range)
{
  return "{ from = " + shortest_decimal(range.from_deg) + ", to = " + shortest_decimal(range.to_deg) +
         ", step = " + shortest_decimal(range.step_deg) + " }";
}

std::string moving_text(const KeywordConfiguration& c, const std::string& folder)
{
  // theta has the right-knee sign, which is reversed on a left knee.
  const double theta_deg = -c.turn_deg;
  std::string text = line("\n[moving]");
  text += line("name = " + core::value_text({c.moving.front()}));
  text += line("# anterior, proximal, right");
  text += line("initial = { translation_mm = " + list_of(canonical(c.position_mm)) +
               ", theta_deg = " + shortest_decimal(theta_deg) + " }");
  return text + components_text("moving", c.moving, folder);
}

std::string solving_text(const KeywordConfiguration& c)
{
  const Eigen::Vector3d delta = canonical(c.motion_mm) / c.motion_mm.cwiseAbs().maxCoeff();
  std::string text = line("\n[push]");
  text += line("delta = " + list_of(delta), "the direction of the initial motion");
  text += line("\n[grid]");
  text += line("flexion = " + range_text(c.flexion));
  text += line("varus = " + range_text(c.varus));
  text += line("\n[solver]");
  text += line("method = \"stability-search\"");
  text += line("\n[solver.search]");
  text +=
      line("approach_step_mm = " + shortest_decimal(c.motion_mm.norm()), "the length of the initial motion");
  text += line("translation_step_mm = " + shortest_decimal(c.modelling_step_mm), "the modelling resolution");
  text += line("translation_resolution_mm = " + shortest_decimal(c.contact_resolution_mm),
               "the contact resolution");
  text += line("rotation_step_deg = " + shortest_decimal(c.orientation_step_deg));
  text += line("rotation_resolution_deg = " + shortest_decimal(c.orientation_resolution_deg));
  return text;
}

std::string player_text(const KeywordConfiguration& c)
{
  std::string text;
  if (c.display_px) {
    text += line("display_px = [" + std::to_string((*c.display_px)[0]) + ", " +
                 std::to_string((*c.display_px)[1]) + "]");
  }
  if (c.zoom) text += line("zoom = " + shortest_decimal(*c.zoom));
  if (!c.render.empty()) text += line("render = " + core::value_text({c.render}));
  for (const auto& [number, view] : c.views) {
    text += line("\n[[player.view]]");
    text += line("number = " + std::to_string(number));
    text += line("shift_mm = " + list_of(view.shift_mm));
    text += line("orientation_deg = " + list_of(view.orientation_deg));
  }
  return text.empty() ? text : line("\n[player]") + text;
}

}  // namespace

std::string job_text(const KeywordConfiguration& c, const JobTextOptions& places)
{
  std::string text = line("# From the keyword configuration " + core::value_text({places.source}) +
                          "; conversion: schemas/legacy-formats.md.");
  text += line("title = " + core::value_text({places.title}));
  text += line("joint = \"knee\"");
  text += line("side = \"left\"");
  text += line("\n# Thesis 5.2: X from medial to lateral of a left knee, Y up, Z forward (OpenGL view).");
  text += line("[frame]");
  text += line("unit = " + core::value_text({places.unit}));
  text += line("anterior = \"+Z\"");
  text += line("proximal = \"+Y\"");
  text += line("right = \"-X\"");
  text += line("\n[reference]");
  text += line("name = " + core::value_text({c.reference.front()}));
  text += components_text("reference", c.reference, places.models_folder);
  text += moving_text(c, places.models_folder);
  text += solving_text(c);
  text += player_text(c);
  return text;
}

}  // namespace vrda::job

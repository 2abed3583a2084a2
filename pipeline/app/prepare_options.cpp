// The options of `vrda prepare`.
#include <CLI/CLI.hpp>

#include "app/file_commands.hpp"
#include "app/usage.hpp"

namespace vrda::app {

void add_prepare_options(CLI::App& c, PrepareOptions& o)
{
  const auto add_files = [&](const char* name, std::vector<std::string>& files, const char* what) {
    c.add_option(name, files, what)->allow_extra_args(false)->take_all();
  };
  c.add_option("--femur", o.femur, "Mesh of the femur");
  c.add_option("--tibia", o.tibia, "Mesh of the tibia");
  add_files("--femur-cartilage", o.femur_cartilage, "Mesh of its cartilage; may be repeated");
  add_files("--tibia-cartilage", o.tibia_cartilage, "Mesh of its cartilage; may be repeated");
  add_files("--meniscus", o.menisci, "Mesh of a meniscus, drawn only; may be repeated");
  c.add_option("--fibula", o.fibula, "Mesh of the fibula, for the lateral ligaments");
  c.add_option("--landmarks", o.landmarks,
               "Known points of the knee (schemas/prepare.md); without meshes, they scale the template's "
               "bones");
  c.add_option("--side", o.side, "left or right; default: found")->check(one_of({"left", "right"}));
  c.add_option("--unit", o.unit, "mm, cm or m; default: found")->check(one_of({"mm", "cm", "m"}));
  c.add_option("--cartilage", o.cartilage, "auto, none, or mm: thickness added to a bone without cartilage")
      ->check(number(0.0, 10.0, {"auto", "none"}))
      ->capture_default_str();
  CLI::Option* job =
      c.add_option("--template", o.template_job, "Job of a knee with ligaments; default: the generic knee");
  c.add_option("--data", o.data_directory, "Base folder of the template's file names")->needs(job);
  c.add_flag_callback(
      "--no-ligaments", [&o] { o.has_ligaments = false; }, "Write no ligaments");
  c.add_flag("--keep-specks", o.keeps_specks,
             "Keep small separate pieces in the joint space; default: they are left out, with a warning");
  c.add_option("-o,--output", o.folder, "Output folder")->required();
  c.add_flag("--replace", o.may_replace, "Replace existing files, such as those of an earlier preparation");
  add_threads(c, o.n_threads);
  c.add_flag("--json", o.as_json, "Print prepare.json");
}

}  // namespace vrda::app

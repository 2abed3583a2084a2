// `vrda convert osim`: a job from a joint of an OpenSim model.
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/commands.hpp"
#include "app/printing.hpp"
#include "app/staged_folder.hpp"
#include "core/document.hpp"
#include "job/job.hpp"
#include "prepare/osim_job.hpp"
#include "run/run_output.hpp"

namespace vrda::app {
namespace {

struct ConvertOsimOptions {
  prepare::OsimJobOptions model;
  std::string folder;
  bool may_replace = false, as_json = false;
};

core::ExitCode convert_osim_command(const ConvertOsimOptions& options)
{
  const prepare::OsimJob made = prepare::osim_job(options.model);
  const std::string name = made.name + ".toml";
  job::checked_job({name, core::parse_toml(made.text, name), {}});
  StagedFolder folder(options.folder, name, "vrda convert");
  if (!folder.is_locked()) return core::ExitCode::interrupted;
  std::vector<std::string> names{name};
  for (const auto& [file, bytes] : made.files) names.push_back(file);
  folder.check_replaced(names, {options.model.file}, options.may_replace);
  for (const auto& [file, bytes] : made.files) write_atomically(folder.file(file), {bytes});
  write_atomically(folder.file(name), {made.text});
  folder.publish_all({});
  if (options.as_json) {
    print_json({{"job", options.folder + "/" + name}, {"taken", made.taken}, {"left_out", made.left_out}});
    return core::ExitCode::done;
  }
  for (const std::string& what : made.taken) core::log_info(what);
  for (const std::string& what : made.left_out) core::log_warning("not in the job: " + what);
  std::printf("%s/%s\n", options.folder.c_str(), name.c_str());
  return core::ExitCode::done;
}

}  // namespace

void declare_convert_osim(Command& c)
{
  Command osim =
      c.add("osim",
            "Write a job from a joint of an OpenSim model (4.x): meshes, frames, ligaments, wraps, kneecap.",
            "vrda convert osim model.osim --joint knee_r -o my-knee");
  auto& o = osim.options<ConvertOsimOptions>();
  osim.option("model", o.model.file, "OpenSim model").required();
  osim.option("--joint", o.model.joint, "Name of the joint").required();
  osim.option("-o,--output", o.folder, "Output folder").required();
  osim.option("--geometry", o.model.folders, "Folder of mesh files, after that of the model and its Geometry")
      .repeatable();
  osim.option_for(
          "--side", [&o](const std::string& side) { o.model.side = side_named(side); },
          "left or right; default: by the names and axes of the joint")
      .one_of({"left", "right"});
  osim.option("--drawn", o.model.drawn,
              "Names of meshes that are only drawn, or none; default: menisci and fibula")
      .takes_several();
  osim.option("--followers", o.model.followers,
              "Names of bodies that follow the joint; default: patella and fabella of a knee")
      .takes_several();
  osim.option("--muscles", o.model.muscle_share,
              "Muscles across the joint as lines with this share of their largest isometric force")
      .number(0.0, 1.0);
  osim.flag("--replace", o.may_replace, "Replace existing files");
  osim.json(o.as_json, "Print what is in the job and what is not as JSON");
  osim.runs([&o] { return convert_osim_command(o); });
}

}  // namespace vrda::app

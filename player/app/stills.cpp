#include "app/stills.hpp"

#include <filesystem>
#include <ostream>
#include <system_error>

#include "core/error.hpp"
#include "render/png_file.hpp"

namespace vrda {
namespace {

void make_folder(const std::string& folder)
{
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder)) {
    throw InputError(
        {folder, "--offscreen", error ? error.message() : "no folder", "a folder that can be written"});
  }
}

}  // namespace

void write_stills(const ShowOptions& options, PictureMaker& maker, const std::vector<Still>& stills,
                  std::ostream& data)
{
  make_folder(options.folder);
  const std::vector<std::string> views = parsed_views(options.views);
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (const Still& still : stills) {
      const std::string name = views[v] + "_" + still.label + ".png";
      const std::string path = (std::filesystem::path(options.folder) / name).string();
      write_png(maker.single(v, still.pose), path);
      data << path << std::endl;
    }
  }
}

}  // namespace vrda

#include "show/sink.hpp"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "core/error.hpp"
#include "core/open_file.hpp"
#include "view/image.hpp"

namespace vrda::show {

std::span<const view::InputEvent> Sink::events(double wait_s)
{
  if (!window_) return {};
  return window_->events(wait_s);
}

void Sink::record_images(const std::string& folder, const std::string& option)
{
  make_folder(folder, option);
  folder_ = folder;
}

void Sink::show(const Frame& frame)
{
  if (is_hidden()) return;
  if (window_) {
    window_->show(frame.scene, frame.shots, frame.overlay);
  } else if (memory_) {
    memory_->present(frame.scene, frame.shots, frame.overlay);
  }
}

bool Sink::show_again(const view::Overlay* overlay)
{
  if (!has_output()) return false;
  return is_hidden() || (window_ ? window_->show_again(overlay) : memory_->present_again(overlay));
}

std::string Sink::record(const Frame& frame, const std::string& name, std::int64_t n_video)
{
  const view::Image& image = renderer().draw(frame.scene, frame.shots, frame.overlay);
  for (std::int64_t k = 0; video_ && k < n_video; ++k) video_->add(image);
  if (folder_.empty() || name.empty()) return {};
  std::string path = (std::filesystem::path(folder_) / name).string();
  view::write_png(image, path);
  return path;
}

void Sink::finish()
{
  if (video_) video_->finish();
}

void make_folder(const std::string& folder, const std::string& option)
{
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder)) {
    throw InputError({folder, option, error ? error.message() : "not a folder", "a writable folder"});
  }
}

std::string padded_name(const std::string& stem, std::size_t number, std::size_t width)
{
  std::string digits = std::to_string(number);
  digits.insert(0, width - std::min(width, digits.size()), '0');
  return stem + digits;
}

std::string write_with_free_name(const std::function<std::string(std::size_t)>& name_of,
                                 const std::function<void(const std::string&)>& write)
{
  for (std::size_t number = 1;; ++number) {
    const std::string name = name_of(number);
    const OpenFile reserved(open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (!reserved.is_open() && errno == EEXIST) continue;
    if (!reserved.is_open())
      throw InputError({name, "", std::strerror(errno), "a folder that exists and can be written"});
    try {
      write(name);
    } catch (...) {
      std::remove(name.c_str());
      throw;
    }
    return name;
  }
}

std::string count_text(std::size_t n, const std::string& what)
{
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
}

}  // namespace vrda::show

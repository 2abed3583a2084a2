#include "support/small_disk.hpp"

#include <sched.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>

namespace vrda::test {
namespace {

std::string why(const char* what)
{
  return std::string(what) + ": " + std::strerror(errno);
}

// Without root: a user namespace with root rights, if the system permits one.
bool enter_user_namespace()
{
  const uid_t user = getuid();
  const gid_t group = getgid();
  if (unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return false;
  std::ofstream("/proc/self/setgroups") << "deny";
  std::ofstream("/proc/self/uid_map") << "0 " << user << " 1";
  std::ofstream("/proc/self/gid_map") << "0 " << group << " 1";
  return true;
}

std::string enter_own_mounts()
{
  if (unshare(CLONE_NEWNS) != 0 && !enter_user_namespace()) return why("no mount namespace");
  // Mounts are not visible outside and disappear with the process.
  if (mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return why("no private mounts");
  const std::filesystem::path probe = std::filesystem::temp_directory_path();
  if (mount("tmpfs", probe.c_str(), "tmpfs", 0, "size=64k") != 0) return why("no tmpfs");
  umount2(probe.c_str(), MNT_DETACH);
  return "";
}

}  // namespace

std::string mount_refusal()
{
  static const std::string refusal = enter_own_mounts();
  return refusal;
}

SmallDisk::SmallDisk(std::filesystem::path folder, std::uintmax_t n_bytes) : folder_(std::move(folder))
{
  const std::string size = "size=" + std::to_string(n_bytes);
  if (mount("tmpfs", folder_.c_str(), "tmpfs", 0, size.c_str()) != 0) throw std::runtime_error(why("mount"));
}

SmallDisk::~SmallDisk()
{
  umount2(folder_.c_str(), MNT_DETACH);
}

void SmallDisk::forbid_writing()
{
  if (mount("tmpfs", folder_.c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, nullptr) != 0)
    throw std::runtime_error(why("remount"));
}

void SmallDisk::permit_writing()
{
  if (mount("tmpfs", folder_.c_str(), "tmpfs", MS_REMOUNT, nullptr) != 0)
    throw std::runtime_error(why("remount"));
}

void SmallDisk::resize(std::uintmax_t n_bytes)
{
  const std::string size = "size=" + std::to_string(n_bytes);
  if (mount("tmpfs", folder_.c_str(), "tmpfs", MS_REMOUNT, size.c_str()) != 0)
    throw std::runtime_error(why("remount"));
}

}  // namespace vrda::test

// Motion models and traces as sealed HDF5 files, changed by a recipe.

#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <vector>

#include "fuzz/changed_content.hpp"
#include "fuzz/small_models.hpp"
#include "store/motion_model.hpp"
#include "store/read_separately.hpp"
#include "store/trace.hpp"

namespace vrda::test {
namespace {

struct Bases {
  std::vector<BaseContent> contents;
  std::vector<std::vector<std::string>> paths;  ///< of the objects of each
};

/// Offsets of the values of every contiguous dataset.
herr_t add_offset(hid_t group, const char* name, const H5O_info_t* info, void* offsets)
{
  if (info->type != H5O_TYPE_DATASET) return 0;
  const hid_t dataset = H5Dopen2(group, name, H5P_DEFAULT);
  const haddr_t offset = H5Dget_offset(dataset);
  if (offset != HADDR_UNDEF) static_cast<std::vector<std::size_t>*>(offsets)->push_back(offset);
  H5Dclose(dataset);
  return 0;
}

void add_base(Bases& bases, const std::string& path)
{
  constexpr std::size_t seal_bytes = 16;
  std::ifstream stream(path, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(stream), {});
  bytes.resize(bytes.size() - seal_bytes);
  std::vector<std::size_t> offsets;
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_INC, add_offset, &offsets, H5O_INFO_BASIC);
  H5Fclose(file);
  bases.contents.push_back(base_of_hdf5(bytes, offsets));
  bases.paths.push_back(object_paths(bytes));
}

/// The small models, and a trace at the end.
Bases made_bases()
{
  const std::string path = "/dev/shm/vrda-fuzz-base-" + std::to_string(getpid());
  Bases bases;
  for (const store::MotionModel& model : small_models()) {
    store::write_motion_model(path, model);
    add_base(bases, path);
  }
  store::write_trace(path, small_trace());
  add_base(bases, path);
  std::remove(path.c_str());
  return bases;
}

/// A batch uses all of them; the two large ones, which take four times as long, only occasionally.
constexpr std::array<std::size_t, 32> order{5, 0, 6, 5, 0, 4, 5, 2, 5, 0, 6, 5, 0, 4, 5, 3,
                                            5, 0, 6, 5, 0, 4, 5, 2, 5, 0, 6, 5, 0, 4, 5, 1};

}  // namespace

ChangedFile changed_file(const std::uint8_t* recipe, std::size_t size, std::size_t k)
{
  static const Bases bases = made_bases();
  constexpr std::size_t head_bytes = 2;
  std::vector<std::uint8_t> own(recipe, recipe + size);
  own.resize(std::max(size, head_bytes));
  for (std::size_t at = head_bytes; at < size; ++at) {
    if ((at * 7 + k) % 3 == 0) own[at] = static_cast<std::uint8_t>(own[at] + 37 * k);
  }
  const std::size_t base = order[(own[0] + k) % order.size()];
  const bool is_trace = base + 1 == bases.contents.size();
  own[0] = static_cast<std::uint8_t>(base + 16 * (own[0] / 16U % bases.contents.size()));
  // Every third file is changed through HDF5, which gives valid files with other content.
  if ((own[1] / 16U + k) % 3 != 0) return {changed(bases.contents, own.data(), own.size()), is_trace};
  const std::string bytes = with_changed_objects(bases.contents[base].bytes, bases.paths[base],
                                                 own.data() + head_bytes, own.size() - head_bytes);
  return {bytes + store::seal_of(bytes), is_trace};
}

}  // namespace vrda::test

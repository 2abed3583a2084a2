#include "support/oversized_models.hpp"

#include <hdf5.h>
#include <hdf5_hl.h>

#include <fstream>
#include <stdexcept>

#include "store/read_separately.hpp"
#include "support/scratch.hpp"

namespace vrda::test {
namespace {

void require(bool is_done, const char* what)
{
  if (!is_done) throw std::runtime_error(std::string("HDF5 failed: ") + what);
}

/// HDF5 removes the seal from a file that it changes.
void seal(const std::filesystem::path& file)
{
  const std::string bytes = read_bytes(file);
  std::ofstream(file, std::ios::binary | std::ios::app) << store::seal_of(bytes);
}

/// A dataset without stored data.
hid_t promised(hid_t file, const std::string& path, const std::vector<hsize_t>& shape, hid_t type)
{
  const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
  const hid_t dataset = H5Dcreate2(file, path.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  H5Sclose(space);
  require(dataset >= 0, "a dataset");
  return dataset;
}

/// Resizes the axis `name` in a copy of `whole`, and the arrays along it, to `n` entries.
std::string with_axis(const std::filesystem::path& whole, const std::filesystem::path& copy, hsize_t n,
                      const std::vector<std::string>& axis_and_arrays)
{
  std::filesystem::copy_file(whole, copy);
  const hid_t file = H5Fopen(copy.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  require(file >= 0, "to open a motion model");
  for (std::size_t k = 0; k < axis_and_arrays.size(); ++k) {
    const std::string& path = axis_and_arrays[k];
    require(H5Ldelete(file, path.c_str(), H5P_DEFAULT) >= 0, "to delete a dataset");
    const hid_t dataset =
        k == 0 ? promised(file, path, {n}, H5T_IEEE_F32BE) : promised(file, path, {n, 3}, H5T_IEEE_F64LE);
    if (k == 0) require(H5DSset_scale(dataset, path.c_str()) >= 0, "a scale");
    H5Dclose(dataset);
  }
  require(H5Fclose(file) >= 0, "to close a motion model");
  seal(copy);
  return copy;
}

}  // namespace

std::vector<std::string> models_that_promise_gigabytes(const std::filesystem::path& whole,
                                                       const std::filesystem::path& folder)
{
  const std::filesystem::path tiny = folder / "tiny.h5";
  const hid_t file = H5Fcreate(tiny.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  H5Dclose(promised(file, "/tx", {hsize_t{10} << 30}, H5T_IEEE_F64LE));
  require(H5Fclose(file) >= 0, "to close a file");
  seal(tiny);
  return {with_axis(whole, folder / "vertices.h5", 1'000'000'000,
                    {"/bodies/reference/vertex", "/bodies/reference/vertices", "/bodies/reference/normals"}),
          with_axis(whole, folder / "contacts.h5", hsize_t{1} << 40, {"/contacts/contact"}), tiny};
}

}  // namespace vrda::test

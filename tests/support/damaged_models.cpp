#include "support/damaged_models.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5_hl.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "core/units.hpp"
#include "store/read_separately.hpp"
#include "store/sample_model.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::test {

store::MotionModel model_of(Intact intact)
{
  if (intact == Intact::whole) return whole_model();
  if (intact == Intact::frames) return frames_model();
  store::MotionModel model = sample_model();
  if (intact == Intact::stretched) model.job.scaling.emplace().factor = {1.2, 1.0, 0.9};
  return model;
}

void change(const std::string& path, const FileDamage& act)
{
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  act(file);
  ASSERT_GE(H5Fclose(file), 0);
  // HDF5 has truncated the seal.
  const std::string bytes = read_bytes(path);
  std::ofstream(path, std::ios::binary | std::ios::app) << store::seal_of(bytes);
}

void remove(hid_t file, const char* path)
{
  ASSERT_GE(H5Ldelete(file, path, H5P_DEFAULT), 0);
}

void make_group(hid_t file, const std::string& path)
{
  const hid_t group = H5Gcreate2(file, path.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  ASSERT_GE(group, 0);
  H5Gclose(group);
}

namespace {

/// Replaces a one-element attribute by one of `type` with the value at `value`.
void set_attribute(hid_t file, const char* object, const char* name, hid_t type, const void* value)
{
  ASSERT_GE(H5Adelete_by_name(file, object, name, H5P_DEFAULT), 0);
  const hsize_t one = 1;
  const hid_t space = H5Screate_simple(1, &one, nullptr);
  const hid_t attribute =
      H5Acreate_by_name(file, object, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  ASSERT_GE(H5Awrite(attribute, type, value), 0);
  H5Aclose(attribute);
  H5Sclose(space);
}

}  // namespace

void set_text(hid_t file, const char* object, const char* name, const char* value)
{
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  set_attribute(file, object, name, type, &value);
  H5Tclose(type);
}

void replace(hid_t file, const NewDataset& wanted)
{
  remove(file, wanted.path);
  const hid_t space = H5Screate_simple(static_cast<int>(wanted.shape.size()), wanted.shape.data(), nullptr);
  const hid_t dataset =
      H5Dcreate2(file, wanted.path, wanted.type, space, H5P_DEFAULT, wanted.creation, H5P_DEFAULT);
  ASSERT_GE(dataset, 0);
  H5Dclose(dataset);
  H5Sclose(space);
}

void promise(hid_t file, const char* axis, hsize_t n, const std::vector<const char*>& arrays, hid_t creation)
{
  replace(file, {axis, {n}, H5T_IEEE_F32BE});
  const hid_t scale = H5Dopen2(file, axis, H5P_DEFAULT);
  ASSERT_GE(H5DSset_scale(scale, std::string(axis).substr(std::string(axis).rfind('/') + 1).c_str()), 0);
  for (const char* array : arrays) replace(file, {array, {n, 3}, H5T_IEEE_F64LE, creation});
  H5Dclose(scale);
}

void expect_first(const std::vector<store::Finding>& findings, const std::string& where,
                  const std::string& found, const std::string& wanted)
{
  ASSERT_FALSE(findings.empty());
  const InputError::Facts first{"", findings[0].where, findings[0].found, findings[0].wanted};
  EXPECT_THAT(first, refuses({"", where, found, wanted}));
}

std::vector<store::Finding> findings_after(const store::MotionModel& model, const FileDamage& act)
{
  const Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  store::write_motion_model(path, model);
  change(path, act);
  std::vector<store::Finding> findings = store::validate_hdf5(path);
  EXPECT_FALSE(findings.empty());
  EXPECT_THAT(input_error([&] { store::read_motion_model(path); }),
              refuses({path, findings.empty() ? "" : findings[0].where}));
  return findings;
}

// Kinds of damages to a file.

namespace {

using Model = store::MotionModel;

FileDamage without(const char* path)
{
  return [=](hid_t file) { remove(file, path); };
}

FileDamage without_attribute(const char* object, const char* name)
{
  return [=](hid_t file) { ASSERT_GE(H5Adelete_by_name(file, object, name, H5P_DEFAULT), 0); };
}

FileDamage text(const char* object, const char* name, const char* value)
{
  return [=](hid_t file) { set_text(file, object, name, value); };
}

FileDamage number(const char* object, const char* name, hid_t type, double value)
{
  return [=](hid_t file) {
    const auto flag = static_cast<std::int8_t>(value);
    const bool is_flag = H5Tget_size(type) == 1;
    set_attribute(file, object, name, type, is_flag ? static_cast<const void*>(&flag) : &value);
  };
}

FileDamage new_group(const char* path)
{
  return [=](hid_t file) { make_group(file, path); };
}

FileDamage replaced(const NewDataset& by)
{
  return [=](hid_t file) { replace(file, by); };
}

FileDamage promised(const char* axis, hsize_t n, const std::vector<const char*>& arrays = {})
{
  return [=](hid_t file) { promise(file, axis, n, arrays); };
}

/// /tx stored as `set` says.
FileDamage stored(const std::function<void(hid_t)>& set)
{
  return [=](hid_t file) {
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    set(creation);
    replace(file, {"/tx", {4, 3}, H5T_IEEE_F64LE, creation});
    H5Pclose(creation);
  };
}

void set_chunks(hid_t creation)
{
  const hsize_t chunk[] = {4, 3};
  H5Pset_chunk(creation, 2, chunk);
}

constexpr hsize_t thousand_million = 1'000'000'000, unaddressable = hsize_t{1} << 40;
constexpr const char* nothing_in_frames = "nothing in a sequence of frames";

/// The structure of the file: objects, types, shapes, scales, attributes, storage.
std::vector<Damage> structure_damages()
{
  using enum Intact;
  std::vector<Damage> list{
      {"no_format", small, "/@format", "nothing", "vrda motion model", without_attribute("/", "format")},
      {"other_format", small, "/@format", "\"other\"", "vrda motion model", text("/", "format", "other")},
      {"newer_format",
       small,
       "/@format_version",
       "\"2.0\", a newer format",
       "this program reads",
       text("/", "format_version", "2.0")},
      {"no_flexion", small, "/flexion", "nothing", "dimension scale", without("/flexion")},
      {"no_contacts", small, "/contacts", "nothing", "a group", without("/contacts")},
      {"no_clinical", small, "/clinical", "nothing", "a group", without("/clinical")},
      {"no_bodies", small, "/bodies", "nothing", "a group", without("/bodies")},
      {"no_job", small, "/job", "nothing", "a group", without("/job")},
      {"group_for_dataset", small, "/tx", "a group", "a dataset",
       [](hid_t file) {
         remove(file, "/tx");
         make_group(file, "/tx");
       }},
      {"integers", small, "/tx", "int32", "float64", replaced({"/tx", {4, 3}, H5T_STD_I32LE})},
      {"references", small, "/tx", "another type", "float64", replaced({"/tx", {4, 3}, H5T_STD_REF_OBJ})},
      {"transposed", small, "/tx", "[3, 4]", "[4, 3]", replaced({"/tx", {3, 4}})},
      {"flat", small, "/tx", "[12]", "[4, 3]", replaced({"/tx", {12}})},
      {"no_scale_attached", small, "/ty", "axis 0 without its scale", "/flexion attached",
       without_attribute("/ty", "DIMENSION_LIST")},
      {"no_scale", small, "/varus", "no dimension scale", "a dimension scale",
       without_attribute("/varus", "CLASS")},
      {"empty_axis", small, "/flexion", "no values", "at least one",
       [](hid_t file) {
         replace(file, {"/flexion", {0}});
         const hid_t scale = H5Dopen2(file, "/flexion", H5P_DEFAULT);
         H5DSset_scale(scale, "flexion");
         H5Dclose(scale);
       }},
      {"other_meanings", small, "/status@flag_meanings", "good bad", "pending stable",
       text("/status", "flag_meanings", "good bad")},
      {"no_flag_values", small, "/status@flag_values", "nothing", "int8",
       without_attribute("/status", "flag_values")},
      {"no_fill_value", small, "/tx@_FillValue", "nothing", "NaN", without_attribute("/tx", "_FillValue")},
      {"huge_attribute", small, "/@delta", "another type", "3 of float64",
       [](hid_t file) {
         H5Adelete(file, "delta");
         const hsize_t size = 1'000'000;
         const hid_t space = H5Screate_simple(1, &size, nullptr);
         H5Aclose(H5Acreate2(file, "delta", H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT));
         H5Sclose(space);
       }},
      {"flag_of_2", whole, "/smoothed/degree_1@is_robust", "another value", "0 or 1",
       number("/smoothed/degree_1", "is_robust", H5T_STD_I8LE, 2.0)},
      {"smoothed_name", small, "/smoothed/degree_six", "another name", "integer",
       new_group("/smoothed/degree_six")},
      {"smoothed_degree", small, "/smoothed/degree_2@degree", "1", "2, the value from",
       [](hid_t file) {
         H5Lmove(file, "/smoothed/degree_1", file, "/smoothed/degree_2", H5P_DEFAULT, H5P_DEFAULT);
       }},
      {"audit_axis", whole, "/audit/raw/state", "[4, 3]", "[7, 3]",
       replaced({"/audit/raw/state", {4, 3}, H5T_STD_I8LE})},
      {"audit_penetration", whole, "/audit/raw@largest_penetration", "0", "1, the value from",
       number("/audit/raw", "largest_penetration", H5T_IEEE_F64LE, 0.0)},
      {"audit_gap", whole, "/audit/raw@largest_gap", "nan", "0.5, the value from",
       number("/audit/raw", "largest_gap", H5T_IEEE_F64LE, nan)},
      {"external_link", small, "/tx", "another file", "itself",
       [](hid_t file) {
         remove(file, "/tx");
         H5Lcreate_external("/etc/passwd", "/tx", file, "/tx", H5P_DEFAULT, H5P_DEFAULT);
       }},
      {"symbolic_link", small, "/clinical/alias", "symbolic link", "itself",
       [](hid_t file) { H5Lcreate_soft("/ty", file, "/clinical/alias", H5P_DEFAULT, H5P_DEFAULT); }},
      {"external_values", small, "/tx", "another file", "gzip",
       stored([](hid_t creation) { H5Pset_external(creation, "/etc/passwd", 0, H5F_UNLIMITED); })},
      {"another_filter", small, "/tx", "filter number 5", "gzip", stored([](hid_t creation) {
         set_chunks(creation);
         H5Pset_nbit(creation);
       })},
      {"endless_nesting", small, "/loop/loop/loop/loop/loop/loop/loop/loop/loop", "8", "fewer",
       [](hid_t file) {
         make_group(file, "/loop");
         H5Lcreate_hard(file, "/loop", file, "/loop/loop", H5P_DEFAULT, H5P_DEFAULT);
       }},
      {"many_links", small, "/many", "3000 links", "at most 2000",
       [](hid_t file) {
         make_group(file, "/many");
         for (int k = 0; k < 3000; ++k) make_group(file, "/many/" + std::to_string(k));
       }},
      {"not_utf8", small, "/@title", "", "UTF-8", text("/", "title", "genou \xE9tal\xF3n")},
      {"steers_a_terminal", small, "/@title", "control characters", "without control characters",
       text("/", "title", "a \x1b[31mred knee")},
      // Sizes that are declared and not stored: refused before anything is allocated.
      {"gigabytes_of_vertices", small, "/bodies/reference/vertices", "too large for the 0 bytes stored",
       "can be read",
       promised("/bodies/reference/vertex", thousand_million,
                {"/bodies/reference/vertices", "/bodies/reference/normals"})},
      {"gigabytes_of_forces", whole, "/equilibrium/forces/point", "too large for the 0 bytes stored",
       "can be read", promised("/equilibrium/forces/force", thousand_million, {"/equilibrium/forces/point"})},
      {"contacts_beyond_an_index", small, "/contacts/contact", "[1099511627776]", "at most 2147483647",
       promised("/contacts/contact", unaddressable)},
      {"fibres_beyond_an_index", whole, "/ligaments/fibre", "[1099511627776]", "at most 2147483647",
       promised("/ligaments/fibre", unaddressable)}};
  for (const char* version : {"1.", "1.3", "1.x", "1.1x", "1.-1", "1.99999999999", "2", "10.3"})
    list.push_back(
        {"version", small, "/@format_version", version, "\"1.\"", text("/", "format_version", version)});
  for (const char* path : {"/audit/smooth", "/audit/degree_", "/audit/degree_06", "/audit/degree_21",
                           "/audit/degree_6_", "/audit/degree_-1"})
    list.push_back({"audit_name", whole, path, "another name", "degree_N_recontacted", new_group(path)});
  return list;
}

/// Values that break a rule beyond those of one dataset, which the tests of every dataset break.
std::vector<Damage> value_damages()
{
  using enum Intact;
  return {{"joint", small, "/@joint", "\"elbow\"", "\"knee\", \"hip\"", [](Model& m) { m.joint = "elbow"; }},
          {"side", small, "/@side", "\"\"", "\"right\", \"left\"", [](Model& m) { m.side = ""; }},
          {"method", small, "/@method", "\"magic\"", "\"stability-search\"",
           [](Model& m) { m.method = "magic"; }},
          {"centre", small, "/@rotation_centre_mm", "nan at entry 1", "finite numbers",
           [](Model& m) { m.rotation_centre_mm.y() = nan; }},
          // Finite, but derived values would overflow.
          {"far_centre", small, "/@rotation_centre_mm", "2e+300 at entry 0", "up to 1e9",
           [](Model& m) { m.rotation_centre_mm.x() = 2e300; }},
          {"long_delta", small, "/@delta", "length 2", "length 1", [](Model& m) { m.delta *= 2.0; }},
          {"other_delta", small, "/@delta", "a different direction", "first row of /push/delta",
           [](Model& m) { m.push.delta.row(0) << 1.0, 0.0, 0.0; }},
          {"resolution", small, "/@contact_resolution_mm", "0", "positive",
           [](Model& m) { m.contact_resolution_mm = 0.0; }},
          {"plausibility", small, "/plausibility", "1", "-1 where status is not stable",
           [](Model& m) { m.plausibility = (m.status == 0).select(m.plausibility, std::int8_t{1}); }},
          {"two_spine_cells", small, "/is_spine", "several", "at most one",
           [](Model& m) { m.is_spine(3, 2) = 1; }},
          {"varus_of_axis", small, "/varus_solved", "-1.5 at entry 0", "axis has several",
           [](Model& m) { m.varus_solved_deg(0, 0) = -1.5; }},
          {"close_flexions", small, "/flexion", "at entry 1", "at least 1e-6 apart",
           [](Model& m) {
             m.flexion_deg[1] = m.flexion_deg[0] + 1e-9;
             m.smoothed.clear();
           }},
          {"unordered_flexion", small, "/flexion", "1 at entry 3", "strictly increasing",
           [](Model& m) {
             m.flexion_deg[3] = 1.0;
             m.smoothed.clear();
           }},
          {"no_triangles", small, "/bodies/moving/triangles", "no triangles", "at least one",
           [](Model& m) {
             m.moving.contact.mesh.triangles.resize(0, 3);
             m.moving.contact.component.clear();
             m.compartment_of_triangle.clear();
             m = store::with_pending_cells(m);
           }},
          {"band_moment", whole, "/equilibrium@band_moment_nmm", "-1", "0 or a moment",
           [](Model& m) { m.equilibrium->band_moment_nmm = -1.0; }},
          {"transition_strain", whole, "/ligaments@transition_strain", "0", "above 0",
           [](Model& m) { m.ligaments->transition_strain = 0.0; }},
          {"pulling_force", whole, "/equilibrium/forces/normal", "at entry 2", "oppose Delta",
           [](Model& m) { m.equilibrium->forces.normal_world.row(3) *= -1.0; }},
          {"two_chosen", whole, "/equilibrium/spine/branches/is_chosen", "2 at entry 1", "one chosen",
           [](Model& m) { m.equilibrium->spine.branches.is_chosen[2] = 1; }},
          {"lost_branch", whole, "/equilibrium/spine/branches/row_start", "2 equilibria at entry 1",
           "n_optima", [](Model& m) { m.equilibrium->spine.n_optima[1] = 3; }},
          {"term_beyond_degree", small, "/smoothed/degree_1/exponents", "0, 2", "once",
           [](Model& m) { m.smoothed[0].exponents(2, 1) = 2; }},
          {"term_twice", small, "/smoothed/degree_1/exponents", "1, 0", "once",
           [](Model& m) { m.smoothed[0].exponents.row(2) << 1, 0; }},
          {"negative_term", small, "/smoothed/degree_1/exponents", "-1, 0", "once",
           [](Model& m) { m.smoothed[0].exponents(0, 0) = -1; }},
          {"missing_terms", small, "/smoothed/degree_2/exponents", "3 terms", "6 terms for degree 2",
           [](Model& m) { m.smoothed[0].degree = 2; }},
          {"degree_21", small, "/smoothed/degree_21", "degree 21", "from 0 to 20",
           [](Model& m) { m.smoothed[0].degree = 21; }},
          {"other_polynomial", small, "/smoothed/degree_1/tz", "at entry 1", "the value of the polynomial",
           [](Model& m) { m.smoothed[0].surfaces[2].values(0, 1) += 1e-6; }},
          {"varus_surface", small, "/smoothed/degree_1/varus_solved", "a surface", "where /varus has several",
           [](Model& m) {
             m.smoothed[0].surfaces.push_back(m.smoothed[0].surfaces[0]);
             m.smoothed[0].surfaces[4].name = "varus";
           }},
          {"zero_varus_set", whole, "/zero_varus@set", "raws", "degree_N",
           [](Model& m) { m.zero_varus->set = "raws"; }},
          {"default_motion", whole, "/default_motion@set", "\"smooth\"", "two_sided",
           [](Model& m) { m.default_motion->set = "smooth"; }},
          {"free_source", whole, "/zero_varus/source", "free at entry 1", "one value",
           [](Model& m) { m.zero_varus->source[1] = 2; }},
          {"no_mean_varus", whole, "/zero_varus/varus", "-0.9 at entry 2", "the mean of",
           [](Model& m) { m.zero_varus->varus_deg[2] += 0.1; }},
          {"last_before_first", whole, "/zero_varus/varus_last", "at entry 0", "at least varus_first",
           [](Model& m) { std::swap(m.zero_varus->varus_first_deg[0], m.zero_varus->varus_last_deg[0]); }},
          {"long_axis", whole, "/zero_varus/helical_direction", "length 2 at entry 1", "unit vectors",
           [](Model& m) {
             for (std::size_t k = 3; k < 6; ++k) m.zero_varus->helical_direction[k] *= 2.0;
           }},
          {"refine", whole, "/audit/raw@refine", "0", "at least 1", [](Model& m) { m.audits[2].refine = 0; }},
          {"free_penetration", whole, "/audit/raw/penetration", "0.25 at entry 1", "0 where state is free",
           [](Model& m) { m.audits[2].penetration_mm(0, 1) = 0.25; }},
          {"negative_factor", whole, "/job/scaling@factor", "-1.036", "above 0",
           [](Model& m) {
             Scaling& s = *m.job.scaling;
             s.factor *= -1.0;
             for (std::size_t i : {0U, 1U}) s.residual_mm[i] = s.subject_mm[i] + 1.036 * s.model_mm[i];
             s.residual_rms_mm = std::hypot(s.residual_mm[0], s.residual_mm[1]) / std::sqrt(2.0);
           }},
          {"unequal_factors", whole, "/job/scaling@factor", "unequal", "three equal",
           [](Model& m) { m.job.scaling->factor.z() = 1.1; }},
          {"other_residual", whole, "/job/scaling/residual", "0.2 at entry 0", "minus the factor",
           [](Model& m) {
             Scaling& s = *m.job.scaling;
             s.residual_mm[0] = 0.2;
             s.residual_rms_mm = std::hypot(0.2, s.residual_mm[1]) / std::sqrt(2.0);
           }},
          {"other_rms", whole, "/job/scaling@residual_rms_mm", "1", "from the residuals",
           [](Model& m) { m.job.scaling->residual_rms_mm = 1.0; }},
          {"no_error", whole, "/job/scaling@standard_error", "nan", "at least 0",
           [](Model& m) { m.job.scaling->standard_error = nan; }},
          {"error_without_pairs", stretched, "/job/scaling@standard_error", "0", "NaN with fewer than two",
           [](Model& m) { m.job.scaling->standard_error = 0.0; }},
          {"rms_without_pairs", stretched, "/job/scaling@residual_rms_mm", "0", "NaN without landmarks",
           [](Model& m) { m.job.scaling->residual_rms_mm = 0.0; }},
          {"stretched_steps", stretched, "/job/scaling@factor", "unequal", "three equal",
           [](Model& m) { m.job.scaling->keeps_steps = true; }},
          {"key_twice", frames, "/frame", "0.25 at entry 2", "strictly increasing",
           [](Model& m) { m.frames->key[2] = m.frames->key[1]; }},
          {"no_key", frames, "/frame", "nan at entry 3", "finite", [](Model& m) { m.frames->key[3] = nan; }},
          {"audit_key", frames, "/audit/raw/frame", "at entry 1", "strictly increasing",
           [](Model& m) { m.audits[0].frame_key[1] = -1.0; }},
          {"no_flexion_of_frame", frames, "/flexion", "nan at entry 1", "finite",
           [](Model& m) { m.flexion_deg[1] = nan; }},
          {"varus_of_frames", frames, "/varus", "other values", "value 0",
           [](Model& m) { m.varus_deg[0] = 1.0; }},
          {"key_name", frames, "/frame@key_name", "Time", "lower-case",
           [](Model& m) { m.frames->key_name = "Time"; }},
          {"zero_varus_of_frames", frames, "/zero_varus", "a zero-varus motion", nothing_in_frames,
           [](Model& m) {
             m.zero_varus = with_derived(sample_model({6, 1, true, true, false})).zero_varus;
           }},
          {"two_sided_of_frames", frames, "/two_sided", "a two-sided motion", nothing_in_frames,
           [](Model& m) {
             m.two_sided = with_derived(sample_model({6, 1, true, true, false})).two_sided;
           }},
          {"smoothed_frames", frames, "/smoothed", "a smoothed motion", nothing_in_frames,
           [](Model& m) {
             m.smoothed = sample_model({6, 1, true, true, false}).smoothed;
           }},
          {"audit_of_frames", frames, "/audit/zero_varus", "an audit", nothing_in_frames, [](Model& m) {
             m.audits.push_back(m.audits[0]);
             m.audits[1].name = "zero_varus";
           }}};
}

}  // namespace

const std::vector<Damage>& damages()
{
  static const std::vector<Damage> list = [] {
    std::vector<Damage> all = structure_damages();
    for (Damage& damage : value_damages()) all.push_back(std::move(damage));
    return all;
  }();
  return list;
}

std::string damaged_copy(const std::filesystem::path& whole, const std::filesystem::path& folder,
                         const std::string& name)
{
  const std::filesystem::path copy = folder / (name + ".h5");
  std::filesystem::copy_file(whole, copy);
  const auto damage =
      std::find_if(damages().begin(), damages().end(), [&](const Damage& one) { return one.name == name; });
  check(damage != damages().end(), "a damage to a file has this name");
  change(copy, std::get<FileDamage>(damage->act));
  return copy;
}

}  // namespace vrda::test

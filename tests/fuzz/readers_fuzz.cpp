// Readers of files: any bytes give a value or an InputError. One program, since it takes long to compile and
// link; called fuzz_stl it reads STL, and so on.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <vector>

#include "fuzz/outcome.hpp"
#include "job/clean_mesh.hpp"
#include "job/component_loader.hpp"
#include "job/ligament_files.hpp"
#include "job/thesis_files.hpp"
#include "tables/motion_table.hpp"

namespace vrda::test {

/// Reads, cleans and checks that every index is within its mesh and every number is finite.
void read_and_clean(const std::string& file, const std::string& bytes)
{
  read_or_refuse([&] {
    const job::RawMesh raw = job::read_mesh(file, bytes);
    std::size_t n_corners = 0;
    for (const std::int32_t size : raw.size) n_corners += static_cast<std::size_t>(size);
    require(n_corners == raw.corner.size(), "faces and corners do not match");
    for (const std::int32_t corner : raw.corner)
      require(corner >= 0 && corner < raw.vertices.rows(), "a corner outside the vertices");
    for (const Side side : {Side::right, Side::left}) {
      const job::CleanMesh clean = job::clean_mesh(raw, job::Winding::outward, side);
      const Mesh& mesh = clean.mesh;
      require(mesh.normals.rows() == mesh.vertices_mm.rows(), "not one normal per vertex");
      require(mesh.vertices_mm.allFinite() && mesh.normals.allFinite(), "a number that is not finite");
      require(mesh.triangles.size() == 0 ||
                  (mesh.triangles.minCoeff() >= 0 && mesh.triangles.maxCoeff() < mesh.vertices_mm.rows()),
              "a triangle outside the vertices");
      require(clean.n_welded >= 0 && clean.n_degenerate >= 0, "a negative count");
    }
  });
}

/// Binary and ASCII STL.
void stl(const std::string& bytes)
{
  read_and_clean("mesh.stl", bytes);
}

/// PLY, ASCII and binary of both byte orders.
void ply(const std::string& bytes)
{
  read_and_clean("mesh.ply", bytes);
}

/// Wavefront OBJ; bytes that begin with a number are Vertices-Faces.
void wavefront(const std::string& bytes)
{
  read_and_clean("mesh.obj", bytes);
}

/// VTK PolyData as XML, ASCII and base64 inline or appended.
void vtp(const std::string& bytes)
{
  read_and_clean("mesh.vtp", bytes);
}

/// VTK PolyData in the legacy format, ASCII and binary.
void vtk(const std::string& bytes)
{
  read_and_clean("mesh.vtk", bytes);
}

/// The thesis's Vertices-Faces format.
void vf(const std::string& bytes)
{
  read_or_refuse([&] { job::read_vertices_faces("mesh.vf", bytes); });
  if (job::is_vertices_faces(bytes)) read_and_clean("mesh.obj", bytes);
}

/// Values of the lines at the top that begin with "#--set ".
std::vector<std::string> overrides_of(const std::string& text)
{
  const std::string mark = "#--set ";
  std::vector<std::string> overrides;
  for (std::size_t at = 0; text.compare(at, mark.size(), mark) == 0;) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    overrides.push_back(text.substr(at + mark.size(), end - at - mark.size()));
    at = std::min(end + 1, text.size());
  }
  return overrides;
}

/// Jobs: TOML against the schema, with overrides.
void job(const std::string& text)
{
  read_or_refuse([&] {
    const job::Job read = job::parse_job("job.toml", text, overrides_of(text));
    // The resolved job must be a valid job that resolves to itself: motion models store it, journals use its
    // digest.
    require_no_throw([&] {
      const job::Job again = job::parse_job("resolved.toml", read.resolved_text);
      require(again.resolved_text == read.resolved_text, "a resolved job that resolves to another");
    });
    job::axis_map(read);
  });
}

/// Tables of ligament fibres.
void ligaments(const std::string& text)
{
  read_or_refuse([&] {
    for (const job::FibreJob& fibre : job::read_ligament_table("fibres.csv", text)) {
      require(fibre.stiffness_n > 0.0, "a fibre without stiffness");
      require(!job::default_bundle(fibre.name).empty(), "a fibre without a bundle");
    }
  });
}

/// Wrapping surfaces in JSON.
void wraps(const std::string& text)
{
  read_or_refuse([&] {
    for (const model::Wrap& wrap : job::read_wraps("wraps.json", text, {"femur", "tibmen"}))
      require(wrap.radii_mm.minCoeff() > 0.0, "a wrap without size");
  });
}

/// Tables of landmarks, and the factor fitted to them.
void landmarks(const std::string& text)
{
  read_or_refuse([&] {
    const std::vector<job::LandmarkPair> pairs = job::read_landmarks("marks.csv", text);
    require(!pairs.empty(), "no pair");
    const Scaling scaling = job::fit_scaling(pairs, 1000.0);
    require(std::isfinite(scaling.factor.x()) && scaling.factor.x() > 0.0, "an invalid factor");
    require(std::isfinite(scaling.residual_rms_mm), "an invalid residual");
  });
}

/// The keyword configuration. An accepted one gives an accepted job: errors must name a line of the
/// configuration.
void configuration(const std::string& text)
{
  read_or_refuse([&] {
    const job::KeywordConfiguration read = job::parse_configuration({"knee.cfg", text});
    const std::string toml = job::job_text(read, {"knee", "knee.cfg", "models", "m"});
    require_no_throw([&] { job::parse_job("knee.toml", toml); });
  });
}

/// The three files of an Object set, one after the other, "%%" between them.
void object(const std::string& text)
{
  std::string rest = text;
  // Removes and returns the text before the next mark.
  const auto next_part = [&] {
    const std::size_t mark = rest.find("%%");
    std::string part = rest.substr(0, mark);
    rest = mark == std::string::npos ? "" : rest.substr(mark + 2);
    return part;
  };
  const std::string coordinates = next_part(), normals = next_part();
  read_or_refuse([&] {
    for (const job::ObjectComponent& component :
         job::parse_object_set({{"a.coor", coordinates}, {"a.norm", normals}, {"a.elem", rest}})) {
      // The written file equals the content read, and load accepts it.
      require_no_throw([&] {
        const job::RawMesh again = job::read_mesh("a.vf", job::vertices_faces_bytes(component.mesh));
        require(again.vertices == component.mesh.vertices && again.corner == component.mesh.corner &&
                    again.size == component.mesh.size,
                "a component that is written otherwise");
      });
      require(component.mesh.normals.rows() == component.mesh.vertices.rows(), "not one normal a vertex");
    }
  });
}

/// Tables of measured poses. The first byte selects the kind of file.
void motion_table(const std::string& bytes)
{
  if (bytes.empty()) return;
  const char* const names[] = {"m.csv", "m.sto", "m.tra"};
  const std::string name = names[static_cast<unsigned char>(bytes[0]) % 3];
  read_or_refuse([&] {
    const tables::MotionTable table = tables::motion_table_from_text(name, bytes.substr(1), {});
    require(!table.key.empty(), "a table without frames");
    const tables::Convention convention = tables::completed({}, table.stated, Side::left);
    for (const Pose& X : tables::poses_of(table, convention, {}))
      require(X.matrix().allFinite(), "a pose that is no number");
  });
}

using Reader = void (*)(const std::string&);
const std::map<std::string, Reader> readers{{"stl", stl},
                                            {"ply", ply},
                                            {"wavefront", wavefront},
                                            {"vtp", vtp},
                                            {"vtk", vtk},
                                            {"vf", vf},
                                            {"job", job},
                                            {"wraps", wraps},
                                            {"ligaments", ligaments},
                                            {"object", object},
                                            {"landmarks", landmarks},
                                            {"configuration", configuration},
                                            {"motion_table", motion_table}};
Reader reader = nullptr;

}  // namespace vrda::test

extern "C" int LLVMFuzzerInitialize(int*, char*** arguments)
{
  const std::string program = std::filesystem::path((*arguments)[0]).filename();
  const auto found = vrda::test::readers.find(program.substr(program.find('_') + 1));
  if (found == vrda::test::readers.end()) std::abort();
  vrda::test::reader = found->second;
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  vrda::test::reader(vrda::test::text_of(data, size));
  return 0;
}

/// Reads a text line by line. Blanks, tabs and commas separate words; # starts a comment.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "job/mesh_file.hpp"

namespace vrda::job {

/// A text and its file name for messages.
struct NamedText {
  std::string file;
  std::string text;
};

class TextLines {
 public:
  /// `source` must outlive this object.
  explicit TextLines(const NamedText& source) : source_(source) {}

  /// Advances to the next line with words; false at the end of the text.
  bool next();

  const std::vector<std::string_view>& words() const { return words_; }
  /// Number of the current line, from 1; at the end that of the last line.
  std::size_t line() const { return line_; }

  /// Word `k` of the line as a finite or a whole number. Throws InputError with file and line.
  double real(std::size_t k, const std::string& wanted) const;
  std::int64_t whole(std::size_t k, const std::string& wanted) const;

  /// Throws InputError for the current line, or for line `line`.
  [[noreturn]] void refuse(const std::string& found, const std::string& wanted) const;
  [[noreturn]] void refuse_at(std::size_t line, const std::string& found, const std::string& wanted) const;

 private:
  std::string shown_word(std::size_t k) const;

  const NamedText& source_;
  std::vector<std::string_view> words_;
  std::size_t at_ = 0;
  std::size_t line_ = 0;
};

/// Whether the word is a portable file name, as in component_name_rule.
bool is_component_name(std::string_view word);
inline constexpr const char* component_name_rule =
    "a name of at most 100 letters, digits, \"_\", \"-\" and \".\", a letter first";

// The keyword configuration of thesis appendix B as plain settings. schemas/legacy-formats.md lists the
// keywords and which names are not from the thesis.

/// Angles in degrees, ends included; a single angle if the ends are equal.
struct AngleRange {
  double from_deg = 0.0;
  double to_deg = 0.0;
  double step_deg = 1.0;
};

/// An additional view of the scene, in the axes of the files.
struct ConfiguredView {
  Eigen::Vector3d shift_mm{0.0, 0.0, 0.0};
  Eigen::Vector3d orientation_deg{0.0, 0.0, 0.0};  ///< about fixed X, Y and Z, in that order
};

/// Vectors are in the axes of the files. Omitted settings have the defaults of the thesis. Angles are in
/// degrees, as in a job file.
struct KeywordConfiguration {
  std::vector<std::string> reference;          ///< models of body 0, at least one
  std::vector<std::string> moving;             ///< models of body 1, at least one
  Eigen::Vector3d position_mm{0.0, 0.0, 0.0};  ///< of the origin of the moving body
  Eigen::Vector3d motion_mm{0.0, 5.0, 0.0};    ///< one step of the approach
  double turn_deg = 0.0;                       ///< rotation of the moving body about the motion, right-handed
  double contact_resolution_mm = 0.1;
  double modelling_step_mm = 1.0;
  double orientation_resolution_deg = 0.1;
  double orientation_step_deg = 1.0;
  AngleRange flexion;
  AngleRange varus;
  std::map<int, ConfiguredView> views;  ///< by number
  std::optional<std::array<int, 2>> display_px;
  std::optional<double> zoom;
  std::string render;  ///< "fill", "wire" or empty
};

/// `unit_mm`: the length unit of the text in mm; the thesis uses metres.
/// Throws InputError with file and line for unknown and duplicate keywords, missing values, values out of
/// range, a missing model, and an orientation that a job cannot express.
KeywordConfiguration parse_configuration(const NamedText& source, double unit_mm = 1000.0);

/// Reads a configuration file. Throws InputError if it is missing or larger than 1 MiB.
NamedText read_configuration(const std::string& file);

// The three-file Object format of thesis 5.2: coordinates of all components, a normal for each vertex, and
// the polygons as component name and vertex numbers. Syntax: schemas/legacy-formats.md.

struct ObjectSetTexts {
  NamedText coordinates;
  NamedText normals;
  NamedText elements;
};

/// One component with its vertices, in the order of the set, and their normals.
struct ObjectComponent {
  std::string name;
  job::RawMesh mesh;
};

inline constexpr std::size_t max_object_components = 1000;

/// The components in the order of their first polygons. Throws InputError with file and line.
std::vector<ObjectComponent> parse_object_set(const ObjectSetTexts& texts);

/// Reads PREFIX.coor, PREFIX.norm and PREFIX.elem. Throws InputError if one of them is missing.
ObjectSetTexts read_object_set(const std::string& prefix);

// Serialises meshes to file formats. Text uses the fewest digits that restore the same double.

/// Vertices-Faces (thesis 4.1), indices from 0, without normals.
std::string vertices_faces_bytes(const job::RawMesh& mesh);

/// The normals file of a Vertices-Faces file: their number, then one normal for each vertex and line.
std::string vertex_normals_bytes(const job::RawMesh& mesh);

/// Wavefront OBJ and ASCII PLY, with normals if the mesh has them.
std::string wavefront_bytes(const job::RawMesh& mesh);
std::string ply_bytes(const job::RawMesh& mesh);

/// Binary STL, single precision. `header`: at most 80 bytes are written.
std::string stl_bytes(const Mesh& mesh, const std::string& header);

/// Selects the format by the extension of `file`: .vf, .obj (Wavefront), .ply, or .stl (polygons are
/// triangulated as in load). Throws InputError naming `file` for another extension and for a coordinate
/// outside the range of an STL.
std::string mesh_bytes(const std::string& file, const job::RawMesh& mesh);

/// Merges vertices with equal coordinates, since the readers of STL and Wavefront give each face its own
/// vertices. Normals are averaged and normalised; if one has no direction, all are removed.
job::RawMesh merge_equal_vertices(const job::RawMesh& mesh);

// Writes a job file from a configuration.

struct JobTextOptions {
  std::string title;
  std::string source;         ///< name of the configuration, for the first comment
  std::string models_folder;  ///< folder of the models' .obj files, relative to the job file
  std::string unit = "m";     ///< of the mesh files: m, cm or mm
};

/// TOML with comments. Frame: thesis 5.2 in the OpenGL view: X to the subject's left, Y up, Z
/// forward, left knee.
std::string job_text(const KeywordConfiguration& configuration, const JobTextOptions& places);

}  // namespace vrda::job

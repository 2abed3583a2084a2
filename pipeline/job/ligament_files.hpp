/// Ligament fibres in a CSV file: schemas/ligaments.md.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "job/component_loader.hpp"
#include "job/job.hpp"
#include "model/frames.hpp"
#include "model/ligaments.hpp"
#include "model/mesh.hpp"

namespace vrda::job {

/// The fibres of a table, in order, in the axes of the mesh files. `file` is its name in messages. Throws
/// InputError with file, line and column for unknown, missing and duplicate columns, invalid values, and no
/// fibres.
std::vector<FibreJob> read_ligament_table(const std::string& file, std::string_view text);

/// Default bundle of a fibre: its name without trailing digits and one preceding "_", "-", "." or blank
/// ("ACLam" for "ACLam3" and "ACLam_3"); the whole name if nothing remains.
std::string default_bundle(const std::string& fibre_name);

// Loads the ligaments of a job: fibres and wraps in canonical axes.

struct LoadedLigaments {
  model::Ligaments ligaments;       ///< canonical, own side; empty if the job has none
  std::vector<FibreJob> jobs;       ///< [fibres] origin of each fibre
  std::vector<LoadedInput> inputs;  ///< files read, or the generator's name
};

/// Reads the files named in the job (data folder first), maps attachments and wraps like meshes, resolves
/// wrap names and computes slack lengths from reference strains. Throws InputError with file and line or key.
LoadedLigaments load_ligaments(const Job& job, const std::string& data_directory, const BodyMaps& maps);

/// "ligaments.fibre.3.stiffness_n" for a fibre in the job, "line 7, stiffness_n" for one in a table.
std::string fibre_key(const FibreJob& fibre, const std::string& key);

/// Throws InputError if all fibres are shorter than 1 mm (attachments in m), or if an attachment is outside
/// its object, one of `bodies` by BodyIndex: outside the bounding box of all components (visual ones
/// included), enlarged on each side by half of its longest edge. Lines of constant tension may begin
/// anywhere.
void check_attachments(const LoadedLigaments& loaded, const std::vector<const Body*>& bodies);

/// Slack lengths of the fibres whose job gives a strain, with the moving object at `X_reference_moving`.
void set_slack_lengths(LoadedLigaments& loaded, const Pose& X_reference_moving);

/// The row of the fibre's wrap, -1 without one. Throws InputError naming the nearest of `wraps`; `key`
/// names their file.
int wrap_named(const FibreJob& fibre, const std::vector<model::Wrap>& wraps, const std::string& wraps_file,
               const std::string& key);

/// A fibre's name a second time is an InputError.
void check_names(const std::vector<FibreJob>& fibres);

/// A pose of the mesh files in canonical axes.
Pose canonical(const Pose& X_native, const AxisMap& map);

// Wrapping surfaces of ligaments in a JSON file: schemas/ligaments.md.

/// Names of the objects in the job, by BodyIndex. A wrap names the object it is fixed to.
using BodyNames = std::vector<std::string>;

/// The object of that name, or of "reference", "moving", "femur..." and "tibia..."; empty without one.
std::optional<BodyIndex> body_named(const std::string& name, const BodyNames& bodies);

/// The wraps of a file, in order, with poses in the axes of the mesh files and mm.
/// Throws InputError naming file, wrap and key.
std::vector<model::Wrap> read_wraps(const std::string& file, const std::string& text,
                                    const BodyNames& bodies);

// Tables of comma-separated text: a line of column names, then rows. Errors name line and column.

/// Names of the rows in messages: "pair", "pairs", "pairs of landmarks".
struct RowLabels {
  const char* one;
  const char* many;
  const char* full_plural;
};

/// What an empty field of a column of numbers is.
enum class EmptyField {
  refused,
  missing,  ///< NaN
};

/// The text must outlive the table.
class CsvTable {
 public:
  /// Throws InputError if the text has no line other than comments.
  CsvTable(std::string file, std::string_view text, const RowLabels& words);

  const std::string& file() const { return file_; }
  const TableLine& header() const { return lines_.front(); }
  /// Names of the columns, by separator_of().
  const std::vector<std::string_view>& columns() const { return columns_; }
  std::size_t n_rows() const { return lines_.size() - 1; }
  const TableLine& row(std::size_t i) const { return lines_.at(i + 1); }

  /// Throws InputError if there are no rows or more than `max_rows`.
  void require_rows(std::size_t max_rows) const;
  /// The fields of a row. Throws InputError if their number differs from the number of columns.
  std::vector<std::string_view> fields(const TableLine& row) const;

  /// Throws InputError naming file, line and, unless empty, column.
  [[noreturn]] void refuse(const TableLine& line, const std::string& column, const std::string& found,
                           const std::string& wanted) const;
  /// The message contains `description` (the list of known columns) and the nearest name of `known`.
  [[noreturn]] void refuse_unknown_column(std::string_view name, const std::vector<std::string>& known,
                                          const std::string& description) const;
  [[noreturn]] void refuse_number(const TableLine& line, const std::string& column,
                                  std::string_view field) const;

  /// Index of a column. Throws InputError with the nearest name, written after `wanted`.
  std::size_t column_named(const std::string& name,
                           const std::string& wanted = "one of its columns; the nearest is ") const;
  /// The finite numbers of a column, a row each. Throws InputError for another field.
  std::vector<double> numbers(std::size_t column, EmptyField empty = EmptyField::refused) const;

  /// The text in quotation marks, not shortened.
  static std::string quoted(std::string_view text);

 private:
  std::string file_;
  RowLabels words_;
  std::vector<TableLine> lines_;
  char separator_ = ',';
  std::vector<std::string_view> columns_;
};

// Distances between landmarks of the model and of a subject: schemas/scaling.md.

struct LandmarkPair {
  std::string name;
  Eigen::Vector3d a_native{0.0, 0.0, 0.0};  ///< in the mesh files' coordinates and unit
  Eigen::Vector3d b_native{0.0, 0.0, 0.0};
  double subject_mm = 0.0;  ///< distance in the subject, above 0
};

/// The pairs of a table, in order. `file` is its name in messages. Throws InputError with file, line and
/// column for rows that violate schemas/landmarks.schema.json, duplicate columns or names, coincident points,
/// and no pairs.
std::vector<LandmarkPair> read_landmarks(const std::string& file, std::string_view text);

/// Least-squares fit of one factor s: minimises sum((subject - s model)^2). `unit_mm` is the length unit of
/// the files. The standard error assumes equal uncertainty of all distances: sqrt(sum(residual^2) / (n - 1) /
/// sum(model^2)). Requires at least one pair.
Scaling fit_scaling(const std::vector<LandmarkPair>& pairs, double unit_mm);

}  // namespace vrda::job

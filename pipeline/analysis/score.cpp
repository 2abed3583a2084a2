#include "analysis/score.hpp"

#include <algorithm>
#include <utility>

#include "model/clinical.hpp"
#include "core/error.hpp"

namespace vrda::analysis {
namespace {

bool have_pose(const Row& found, const Row& measured)
{
  return found.missing.empty() && measured.missing.empty();
}

/// Rows of the range in which both motions have a pose.
std::vector<std::size_t> common_rows(const std::vector<Row>& found, const Sequence& measured,
                                     const RowRange& range)
{
  std::vector<std::size_t> rows;
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (range.contains(k) && have_pose(found[k], measured.rows[k])) rows.push_back(k);
  }
  return rows;
}

void require_rows(const std::vector<std::size_t>& rows, const std::vector<Row>& found,
                  const Sequence& measured, const std::string& field)
{
  if (!rows.empty()) return;
  std::map<std::string, int> reasons;
  for (std::size_t k = 0; k < found.size(); ++k)
    ++reasons[measured.rows[k].missing.empty() ? found[k].missing
                                               : "measurement " + measured.rows[k].missing];
  std::string text = "no row with a pose in both motions";
  for (const auto& [reason, n] : reasons) {
    if (!reason.empty()) text += ", " + std::to_string(n) + " " + reason;
  }
  throw InputError(
      {measured.file, field, text, "at least one of the " + std::to_string(found.size()) + " rows"});
}

/// The coordinate's series in some rows: all have a pose that determines it.
struct Series {
  std::vector<std::size_t> rows;
  std::vector<double> found, measured, x;
};

/// The row's numbers nearest to those of another; `anterior` is along the floating axis or not.
Row nearest_row(Row row, const Row& to, Translations translations)
{
  const auto numbers = [](const Row& r) {
    ClinicalCoordinates c;
    c.flexion_rad = r.value[at_flexion];
    c.varus_rad = r.value[at_varus];
    c.internal_rotation_rad = r.value[at_internal];
    c.anterior_mm = r.value[n_angles];
    return c;
  };
  const ClinicalCoordinates c = nearest_numbers(numbers(row), numbers(to));
  row.value[at_flexion] = c.flexion_rad;
  row.value[at_varus] = c.varus_rad;
  row.value[at_internal] = c.internal_rotation_rad;
  if (translations == Translations::rotation_centre) row.value[n_angles] = c.anterior_mm;
  return row;
}

/// Both motions as curves: the measured one is continuous over its rows with a pose, so that a baseline has
/// no jumps, and each found row is nearest to the measured one.
void make_continuous(std::vector<Row>& found, std::vector<Row>& measured, Translations translations)
{
  const Row* before = nullptr;
  for (std::size_t k = 0; k < measured.size(); ++k) {
    if (!measured[k].missing.empty()) continue;
    if (before) measured[k] = nearest_row(measured[k], *before, translations);
    before = &measured[k];
    if (found[k].missing.empty()) found[k] = nearest_row(found[k], measured[k], translations);
  }
}

Series series_of(const std::vector<Row>& found, const Sequence& measured, std::size_t c,
                 const std::vector<std::size_t>& rows, LineOver over)
{
  Series series;
  for (const std::size_t k : rows) {
    if (!found[k].is_determined[c] || !measured.rows[k].is_determined[c]) continue;
    series.rows.push_back(k);
    series.measured.push_back(measured.rows[k].value[c]);
    series.found.push_back(found[k].value[c]);
    series.x.push_back(over == LineOver::flexion ? measured.rows[k].value[at_flexion] : measured.key[k]);
  }
  return series;
}

CoordinateScore coordinate_score(const Series& fit, Series scored, Alignment align)
{
  CoordinateScore result;
  if (fit.rows.empty() || scored.rows.empty()) return result;
  if (align == Alignment::constant) result.offset = statistics(fit.found, fit.measured).bias;
  for (double& value : scored.found) value -= result.offset;
  result.statistics = statistics(scored.found, scored.measured);
  result.largest_row = scored.rows[result.statistics.largest_at];
  result.constant_rms = rms_of(constant(fit.measured), scored.x, scored.measured);
  result.line_rms = rms_of(straight_line(fit.x, fit.measured), scored.x, scored.measured);
  return result;
}

std::vector<Pose> poses_of(const std::vector<Row>& rows, const std::vector<std::size_t>& chosen,
                           const Convention& convention)
{
  std::vector<Pose> poses;
  for (const std::size_t k : chosen) poses.push_back(right_sided_pose(rows[k].value, convention));
  return poses;
}

/// Fits both transforms in the rows `fit` and applies them to all. The fit is that of the joint reflected to
/// a right one, so that mirrored joints have equal scores.
RigidAlignment align_rigidly(std::vector<Row>& found, const Sequence& measured,
                             const std::vector<std::size_t>& fit, const Convention& convention)
{
  const Convention right = right_sided(convention);
  const RigidAlignment aligned = rigid_alignment(
      poses_of(found, fit, convention), poses_of(measured.rows, fit, convention), right.rotation_centre_mm);
  for (Row& row : found) {
    if (!row.missing.empty()) continue;
    const Pose X = right_sided_pose(row.value, convention);
    row.value = coordinates_of(aligned.X_reference * X * aligned.X_moving, right);
  }
  if (convention.side == Side::right) return aligned;
  RigidAlignment own = aligned;
  own.X_reference = reflected(aligned.X_reference);
  own.X_moving = reflected(aligned.X_moving);
  return own;
}

}  // namespace

Score score(const std::vector<Row>& found, const Sequence& measured, const ScoreOptions& options)
{
  check(found.size() == measured.rows.size() && measured.key.size() == found.size(),
        "each measured row has a found one");
  const std::vector<std::size_t> scored = common_rows(found, measured, options.scored);
  require_rows(scored, found, measured, "rows to score");
  const std::vector<std::size_t> fit = options.fit ? common_rows(found, measured, *options.fit) : scored;
  require_rows(fit, found, measured, "rows to fit");

  Score result;
  result.n_scored_rows = scored.size();
  result.n_fit_rows = fit.size();
  std::vector<Row> aligned = found;
  if (options.align == Alignment::rigid)
    result.rigid = align_rigidly(aligned, measured, fit, options.convention);
  Sequence curve = measured;
  make_continuous(aligned, curve.rows, options.convention.translations);
  for (std::size_t c = 0; c < n_scored; ++c) {
    const Series of_fit = series_of(aligned, curve, c, fit, options.line_over);
    const Series of_scored = series_of(aligned, curve, c, scored, options.line_over);
    result.coordinates[c] = coordinate_score(of_fit, of_scored, options.align);
    std::set_difference(scored.begin(), scored.end(), of_scored.rows.begin(), of_scored.rows.end(),
                        std::back_inserter(result.coordinates[c].undetermined));
  }
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (!options.scored.contains(k) || have_pose(found[k], measured.rows[k])) continue;
    const bool is_measured = measured.rows[k].missing.empty();
    result.missing[is_measured ? found[k].missing : "measurement_" + measured.rows[k].missing].push_back(k);
  }
  return result;
}

}  // namespace vrda::analysis

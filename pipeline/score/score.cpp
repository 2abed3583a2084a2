#include "score/score.hpp"

#include <algorithm>
#include <utility>

#include "core/clinical.hpp"
#include "core/error.hpp"

namespace vrda::score {
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

/// The measured series is continuous over all rows, so that a baseline has no jumps by whole turns.
std::vector<double> measured_series(const Sequence& measured, std::size_t c)
{
  std::vector<double> values, known;
  for (const Row& row : measured.rows) {
    if (row.missing.empty()) known.push_back(row.value[c]);
  }
  if (c < n_angles) known = unwrapped(std::move(known));
  auto next = known.begin();
  for (const Row& row : measured.rows) values.push_back(row.missing.empty() ? *next++ : nan);
  return values;
}

Series series_of(const std::vector<Row>& found, const Sequence& measured, std::size_t c,
                 const std::vector<std::size_t>& rows, LineOver over)
{
  const std::vector<double> all = measured_series(measured, c);
  const std::vector<double> flexions = measured_series(measured, at_flexion);
  Series series;
  for (const std::size_t k : rows) {
    if (!found[k].is_determined[c] || !measured.rows[k].is_determined[c]) continue;
    const double value = found[k].value[c];
    series.rows.push_back(k);
    series.measured.push_back(all[k]);
    series.found.push_back(c < n_angles ? nearest_turn(value, all[k]) : value);
    series.x.push_back(over == LineOver::flexion ? flexions[k] : measured.key[k]);
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
  for (std::size_t c = 0; c < n_scored; ++c) {
    const Series of_fit = series_of(aligned, measured, c, fit, options.line_over);
    const Series of_scored = series_of(aligned, measured, c, scored, options.line_over);
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

}  // namespace vrda::score

#include "virtual_bench/statistics.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <thread>

#include "core/units.hpp"

namespace vrda {
namespace {

struct NumberResult {
  std::string part, name, unit;
  double error = 0.0, half_width = 0.0;
};

struct BenchResult {
  bool was_refused = false;
  std::vector<NumberResult> numbers;
  std::vector<TargetError> before, after;
  std::exception_ptr failure;
};

/// To 10 mm and whole degrees.
SixNumbers by_tape(const SixNumbers& six)
{
  constexpr double step_mm = 10.0, step_rad = rad_from_deg(1.0);
  return {(six.shift_mm / step_mm).array().round() * step_mm,
          (six.turn_rad / step_rad).array().round() * step_rad};
}

void add_numbers(const Calibration& found, const BenchFile& bench, const VirtualTruth& truth,
                 BenchResult& result)
{
  for (const auto& [part, record] : found.records) {
    if (!record.estimate) continue;
    const Estimate& estimate = *record.estimate;
    const Eigen::VectorXd errors = errors_of(estimate, part, bench, truth);
    for (Eigen::Index k = 0; k < errors.size(); ++k) {
      const auto i = static_cast<std::size_t>(k);
      result.numbers.push_back(
          {name_of(part), estimate.names[i], estimate.units[i], errors[k], half_width_95(estimate, k)});
    }
  }
}

BenchResult result_of(const BenchFile& bench, const VirtualNoise& noise, std::uint64_t seed)
{
  const VirtualTruth truth = virtual_truth(bench, seed);
  GuideOptions options;
  options.parts = parts_of_step("all", bench);
  options.date = "2000-01-01";
  options.path = "virtual bench " + std::to_string(seed);
  GuideSession session(bench, nominal_calibration(bench), options);
  VirtualOperator hand(bench, truth, noise);
  while (session.task() != nullptr) hand.do_task(session);
  BenchResult result;
  result.was_refused = hand.n_refusals() > 0;
  add_numbers(session.calibration(), bench, truth, result);
  result.before = target_errors(uncalibrated(bench, truth), bench, truth, noise);
  result.after = target_errors(session.calibration(), bench, truth, noise);
  return result;
}

void add_bench(const BenchResult& result, VirtualStatistics& statistics)
{
  ++statistics.n_benches;
  if (result.was_refused) ++statistics.n_refused;
  for (const NumberResult& number : result.numbers) {
    const auto is_same = [&](const NumberStatistics& s) {
      return s.part == number.part && s.name == number.name;
    };
    auto at = std::find_if(statistics.numbers.begin(), statistics.numbers.end(), is_same);
    if (at == statistics.numbers.end())
      at = statistics.numbers.insert(at, NumberStatistics{number.part, number.name, number.unit});
    ++at->n;
    if (std::abs(number.error) <= number.half_width) ++at->n_within;
    // Sums, for now.
    at->rms_error += number.error * number.error;
    at->mean_half_width += number.half_width;
  }
  statistics.before.insert(statistics.before.end(), result.before.begin(), result.before.end());
  statistics.after.insert(statistics.after.end(), result.after.begin(), result.after.end());
}

}  // namespace

Calibration uncalibrated(const BenchFile& bench, const VirtualTruth& truth)
{
  Calibration calibration = truth.calibration;
  const Calibration nominal = nominal_calibration(bench);
  calibration.eyes = nominal.eyes;
  calibration.X_table_eyes = by_tape(truth.calibration.X_table_eyes);
  calibration.X_headbody_eyes = by_tape(truth.calibration.X_headbody_eyes);
  return calibration;
}

VirtualStatistics virtual_statistics(const BenchFile& bench, const VirtualNoise& noise,
                                     std::uint64_t first_seed, int n_benches, int n_threads)
{
  std::vector<BenchResult> results(static_cast<std::size_t>(std::max(0, n_benches)));
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t k = next++; k < results.size(); k = next++) {
      try {
        results[k] = result_of(bench, noise, first_seed + k);
      } catch (...) {
        results[k].failure = std::current_exception();
      }
    }
  };
  std::vector<std::thread> threads;
  for (int k = 1; k < n_threads; ++k) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  VirtualStatistics statistics;
  for (const BenchResult& result : results) {
    if (result.failure) std::rethrow_exception(result.failure);
    add_bench(result, statistics);
  }
  for (NumberStatistics& number : statistics.numbers) {
    number.rms_error = std::sqrt(number.rms_error / number.n);
    number.mean_half_width /= number.n;
  }
  return statistics;
}

}  // namespace vrda

/// Generated recordings.
#pragma once

#include "bench/recording.hpp"

namespace vrda::test {

bench::RecordingFacts sample_facts();

/// Samples of every kind and various keys; some frames have none.
std::vector<bench::RecordedFrame> sample_pictures(int n);

/// File contents of such a recording.
std::string recording_bytes(const bench::RecordingFacts& facts,
                            const std::vector<bench::RecordedFrame>& pictures);

/// Whether both are bitwise equal.
bool is_same(const bench::RecordedFrame& a, const bench::RecordedFrame& b);

}  // namespace vrda::test

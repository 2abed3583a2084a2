/// Generated recordings.
#pragma once

#include "recording/recording.hpp"

namespace vrda::test {

recording::RecordingFacts sample_facts();

/// Samples of every kind and various keys; some frames have none.
std::vector<recording::RecordedFrame> sample_pictures(int n);

/// File contents of such a recording.
std::string recording_bytes(const recording::RecordingFacts& facts,
                            const std::vector<recording::RecordedFrame>& pictures);

/// Whether both are bitwise equal.
bool is_same(const recording::RecordedFrame& a, const recording::RecordedFrame& b);

}  // namespace vrda::test

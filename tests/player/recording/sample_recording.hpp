/// Generated recordings.
#pragma once

#include "recording/recording.hpp"

namespace vrda::test {

RecordingFacts sample_facts();

/// Samples of every kind and various keys; some frames have none.
std::vector<RecordedPicture> sample_pictures(int n);

/// File contents of such a recording.
std::string recording_bytes(const RecordingFacts& facts, const std::vector<RecordedPicture>& pictures);

/// Whether both are bitwise equal.
bool is_same(const RecordedPicture& a, const RecordedPicture& b);

}  // namespace vrda::test

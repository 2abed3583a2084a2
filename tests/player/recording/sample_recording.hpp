/// Recordings made by code.
#pragma once

#include "recording/recording.hpp"

namespace vrda::test {

RecordingFacts sample_facts();

/// Samples of every kind, keys of every sort; pictures without either among them.
std::vector<RecordedPicture> sample_pictures(int n);

/// What the file of such a recording holds.
std::string recording_bytes(const RecordingFacts& facts, const std::vector<RecordedPicture>& pictures);

/// Whether the same bits stand in both.
bool is_same(const RecordedPicture& a, const RecordedPicture& b);

}  // namespace vrda::test

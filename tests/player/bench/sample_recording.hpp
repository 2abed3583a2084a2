/// Generated recordings, and whole recordings in memory.
#pragma once

#include "bench/recording.hpp"

namespace vrda::test {

bench::RecordingFacts sample_facts();

/// Samples of every kind and various keys; some frames have none.
std::vector<bench::RecordedFrame> sample_pictures(int n);

/// File contents of a recording.
std::string recording_bytes(const bench::RecordingFacts& facts,
                            const std::vector<bench::RecordedFrame>& pictures);

/// A reader of such contents, which must outlive it; `n_read` counts the bytes it asks for.
bench::RecordingReader reader_of(const std::string& bytes, std::size_t* n_read = nullptr);

/// All frames of a recording.
std::vector<bench::RecordedFrame> frames_of(bench::RecordingReader reader);

/// Whether both are bitwise equal.
bool is_same(const bench::RecordedFrame& a, const bench::RecordedFrame& b);

}  // namespace vrda::test

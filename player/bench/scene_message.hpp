/// OpenIGTLink messages for programs that show the joint, such as 3D Slicer: texts and meshes. Header version
/// 1, which every version of the protocol reads. Poses are sent as TRANSFORM (igtl/message.hpp). Times in ns
/// since the epoch, lengths in mm.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/mesh.hpp"

namespace vrda::bench {

/// A STRING message with a text of ASCII characters, at most 65535. `device`: at most 20 bytes are sent.
std::vector<std::uint8_t> string_bytes(const std::string& device, std::int64_t device_ns,
                                       const std::string& text);

/// A POLYDATA message with the triangles of `mesh`; the vertices are sent as float32.
std::vector<std::uint8_t> polydata_bytes(const std::string& device, std::int64_t device_ns, const Mesh& mesh);

}  // namespace vrda::bench

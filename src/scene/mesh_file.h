#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace mass_spring {

struct MeshFile {
  std::vector<Eigen::Vector3d> vertices;                ///< in the units of the file
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< three different vertices each
};

/// what() says what was expected of the file, and where in it something else was found.
class MeshError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Reads a Wavefront OBJ file; polygons are cut into triangles. Strict: a number or face that
/// cannot be read is an error, not left out.
/// @throws MeshError
MeshFile readMeshFile(const std::filesystem::path& path, std::size_t most_vertices);

}  // namespace mass_spring

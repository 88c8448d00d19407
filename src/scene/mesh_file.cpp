#include "scene/mesh_file.h"

#include <tiny_obj_loader.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>
#include <system_error>

#include "scene/problems.h"
#include "scene/scalar.h"

namespace mass_spring {
namespace {

constexpr std::size_t kMostMeshBytes = 64 << 20;
// Cutting a polygon into triangles takes time with the square of its corners, and worse.
constexpr std::size_t kMostCorners = 255;

[[noreturn]] void fail(const std::string& expected, const std::string& where,
                       const std::string& got) {
  throw MeshError(expected + "; " + where + ": " + got);
}

std::string readText(const std::filesystem::path& path) {
  const std::string expected = "an OBJ file that can be read";
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) fail(expected, path.string(), "a directory");
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(expected, path.string(), std::generic_category().message(errno));
  std::ostringstream text;
  std::vector<char> block(1 << 20);
  for (std::size_t bytes = 0; file.read(block.data(), block.size()), file.gcount() > 0;) {
    bytes += static_cast<std::size_t>(file.gcount());
    if (bytes > kMostMeshBytes) {
      fail("an OBJ file of at most " + std::to_string(kMostMeshBytes >> 20) + " MiB", path.string(),
           "more");
    }
    text.write(block.data(), file.gcount());
  }
  return text.str();
}

/// The vertices and faces of a file, line by line. tinyobj reads a broken number as 0, leaves
/// broken faces out, and holds coordinates as floats; so it is only asked to cut polygons, once all
/// is known to be right.
class ObjLines {
 public:
  ObjLines(std::string path, std::size_t most_vertices)
      : path_(std::move(path)), most_vertices_(most_vertices) {}

  void read(const std::string& text) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      ++line_;
      std::istringstream words(line);
      std::string keyword;
      words >> keyword;
      if (keyword == "v") readVertex(words);
      if (keyword == "f") readFace(words);
    }
    if (vertices_.empty()) fail("a mesh with vertices", path_, "none");
    if (triangle_count_ == 0) fail("a mesh with faces", path_, "none");
    if (highest_ > vertices_.size()) {
      line_ = highest_line_;
      failHere("faces on vertices 1 to " + std::to_string(vertices_.size()),
               "vertex " + std::to_string(highest_));
    }
  }

  std::vector<Eigen::Vector3d>& vertices() { return vertices_; }
  /// That the faces make, once polygons have been cut.
  std::size_t triangleCount() const { return triangle_count_; }

 private:
  [[noreturn]] void failHere(const std::string& expected, const std::string& got) const {
    fail(expected, path_ + ":" + std::to_string(line_), got);
  }

  void readVertex(std::istringstream& words) {
    Eigen::Vector3d vertex;
    for (double& coordinate : vertex) {
      std::string word;
      words >> word;
      const auto number = parseNumber(word);
      if (!number || !std::isfinite(*number)) failHere("3 finite numbers", quote(word));
      coordinate = *number;
    }
    vertices_.push_back(vertex);
    if (vertices_.size() > most_vertices_) {
      failHere("at most " + std::to_string(most_vertices_) + " vertices", "more");
    }
  }

  void readFace(std::istringstream& words) {
    std::vector<std::size_t> corners;
    for (std::string word; words >> word;) corners.push_back(readCorner(word));
    if (corners.size() < 3 || corners.size() > kMostCorners) {
      failHere("faces of 3 to " + std::to_string(kMostCorners) + " corners",
               std::to_string(corners.size()) + " corners");
    }
    triangle_count_ += corners.size() - 2;
    std::sort(corners.begin(), corners.end());
    const auto twice = std::adjacent_find(corners.begin(), corners.end());
    if (twice != corners.end()) {
      failHere("faces of different vertices", "vertex " + std::to_string(*twice) + " twice");
    }
    if (corners.back() <= highest_) return;
    highest_ = corners.back();  // its vertex may come later in the file
    highest_line_ = line_;
  }

  /// The vertex, counted from 1, of a corner such as 7, 7/1, 7//3 or -1 (the last vertex so far).
  std::size_t readCorner(const std::string& word) const {
    const std::string digits = word.substr(0, word.find('/'));
    const char* end = digits.data() + digits.size();
    std::int64_t index = 0;
    const auto [rest, error] = std::from_chars(digits.data(), end, index);
    const auto count = static_cast<std::int64_t>(vertices_.size());
    if (error != std::errc() || rest != end || index == 0 || index < -count ||
        index > static_cast<std::int64_t>(most_vertices_)) {
      failHere("faces of vertex numbers, the first 1", quote(word));
    }
    return static_cast<std::size_t>(index > 0 ? index : count + index + 1);
  }

  std::string path_;
  std::size_t most_vertices_;
  std::size_t line_ = 0, highest_ = 0, highest_line_ = 0, triangle_count_ = 0;
  std::vector<Eigen::Vector3d> vertices_;
};

}  // namespace

MeshFile readMeshFile(const std::filesystem::path& path, std::size_t most_vertices) {
  const std::string text = readText(path);
  ObjLines lines(path.string(), most_vertices);
  lines.read(text);

  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
  std::string warning, error;
  std::istringstream stream(text);
  if (!tinyobj::LoadObj(&attributes, &shapes, &materials, &warning, &error, &stream)) {
    fail("an OBJ file", path.string(), error);
  }
  MeshFile mesh;
  for (const tinyobj::shape_t& shape : shapes) {
    const auto& indices = shape.mesh.indices;
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
      mesh.triangles.push_back({static_cast<std::uint32_t>(indices[i].vertex_index),
                                static_cast<std::uint32_t>(indices[i + 1].vertex_index),
                                static_cast<std::uint32_t>(indices[i + 2].vertex_index)});
    }
  }
  if (mesh.triangles.size() != lines.triangleCount()) {
    fail("polygons that can be cut into triangles", path.string(), "others");
  }
  mesh.vertices = std::move(lines.vertices());
  return mesh;
}

}  // namespace mass_spring

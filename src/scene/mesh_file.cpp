#include "scene/mesh_file.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>
#include <system_error>

#include "scene/polygon.h"
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

/// The vertices and faces of a file, line by line.
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
    if (faces_.empty()) fail("a mesh with faces", path_, "none");
    if (highest_ >= vertices_.size()) {
      line_ = highest_line_;
      failHere("faces on vertices 1 to " + std::to_string(vertices_.size()),
               "vertex " + std::to_string(highest_ + 1));
    }
  }

  /// The vertices, and the faces cut into triangles. Leaves the vertices to the result.
  MeshFile cut() {
    MeshFile mesh;
    for (Face& face : faces_) {
      line_ = face.line;
      const std::size_t corners = face.corners.size();
      const auto triangles = cutPolygon(vertices_, std::move(face.corners));
      if (triangles.size() + 2 != corners) {
        failHere("polygons that can be cut into triangles", "another one");
      }
      mesh.triangles.insert(mesh.triangles.end(), triangles.begin(), triangles.end());
    }
    mesh.vertices = std::move(vertices_);
    return mesh;
  }

 private:
  [[noreturn]] void failHere(const std::string& expected, const std::string& got) const {
    fail(expected, path_ + ":" + std::to_string(line_), got);
  }

  void readVertex(std::istringstream& words) {
    Eigen::Vector3d vertex;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      std::string word;
      words >> word;
      const auto number = parseNumber(word);
      if (!number || !std::isfinite(*number)) failHere("3 finite numbers", quote(word));
      vertex[axis] = *number;
    }
    vertices_.push_back(vertex);
    if (vertices_.size() > most_vertices_) {
      failHere("at most " + std::to_string(most_vertices_) + " vertices", "more");
    }
  }

  void readFace(std::istringstream& words) {
    Face face{line_, {}};
    for (std::string word; words >> word;) face.corners.push_back(readCorner(word));
    if (face.corners.size() < 3 || face.corners.size() > kMostCorners) {
      failHere("faces of 3 to " + std::to_string(kMostCorners) + " corners",
               std::to_string(face.corners.size()) + " corners");
    }
    std::vector<std::uint32_t> sorted = face.corners;
    std::sort(sorted.begin(), sorted.end());
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (twice != sorted.end()) {
      failHere("faces of different vertices", "vertex " + std::to_string(*twice + 1) + " twice");
    }
    if (sorted.back() > highest_) {
      highest_ = sorted.back();  // its vertex may come later in the file
      highest_line_ = line_;
    }
    faces_.push_back(std::move(face));
  }

  /// The vertex of a corner such as 7, 7/1, 7//3 or -1 (the last vertex so far).
  std::uint32_t readCorner(const std::string& word) const {
    const std::string digits = word.substr(0, word.find('/'));
    const char* end = digits.data() + digits.size();
    std::int64_t index = 0;
    const auto [rest, error] = std::from_chars(digits.data(), end, index);
    const auto count = static_cast<std::int64_t>(vertices_.size());
    if (error != std::errc() || rest != end || index == 0 || index < -count ||
        index > static_cast<std::int64_t>(most_vertices_)) {
      failHere("faces of vertex numbers, the first 1", quote(word));
    }
    return static_cast<std::uint32_t>(index > 0 ? index - 1 : count + index);
  }

  struct Face {
    std::size_t line;
    std::vector<std::uint32_t> corners;  ///< counted from 0
  };

  std::string path_;
  std::size_t most_vertices_;
  std::size_t line_ = 0, highest_ = 0, highest_line_ = 0;
  std::vector<Eigen::Vector3d> vertices_;
  std::vector<Face> faces_;
};

}  // namespace

MeshFile readMeshFile(const std::filesystem::path& path, std::size_t most_vertices) {
  const std::string text = readText(path);
  ObjLines lines(path.string(), most_vertices);
  lines.read(text);
  return lines.cut();
}

}  // namespace mass_spring

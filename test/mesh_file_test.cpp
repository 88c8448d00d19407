#include "scene/mesh_file.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "scene/file_path.h"
#include "scene_text.h"

namespace mass_spring {
namespace {

const char* const kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

MeshFile read(const std::string& content, std::size_t most_vertices = 100) {
  const TemporaryFolder folder;
  return readMeshFile(folder.write("mesh.obj", content), most_vertices);
}

/// What the error says, without the folder of the file.
std::string problem(const std::string& content, std::size_t most_vertices = 100) {
  const TemporaryFolder folder;
  const std::string path = folder.write("mesh.obj", content);
  try {
    readMeshFile(path, most_vertices);
  } catch (const MeshError& error) {
    std::string text = error.what();
    const std::size_t at = text.find(path);
    return at == std::string::npos ? text : text.replace(at, path.size(), "mesh.obj");
  }
  return "";
}

/// Sets an environment variable for the length of a test.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    setenv(name, value.c_str(), 1);
  }
  ~Variable() {
    if (old_) {
      setenv(name_, old_->c_str(), 1);
    } else {
      unsetenv(name_);
    }
  }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> old_;
};

TEST(MeshFile, ReadsVerticesToTheLastBit) {
  const MeshFile mesh = read(
      "# comment\r\nmtllib none.mtl\no thing\nv 0.1 -2e-3 3\r\n  v 1 0 0 0.5\nvn 0 0 1\nvt 0 0\n"
      "v 0 1 0\nf 1/1/1 2//1 3/1\n");
  ASSERT_EQ(mesh.vertices.size(), 3u);
  EXPECT_EQ(mesh.vertices[0], Eigen::Vector3d(0.1, -2e-3, 3.0));  // doubles, not floats
  ASSERT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(mesh.triangles[0], (std::array<std::uint32_t, 3>{0, 1, 2}));
}

TEST(MeshFile, CutsPolygonsIntoTriangles) {
  EXPECT_EQ(read("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").triangles.size(), 2u);
  // An L: six corners, one of them concave. Its area must come out, 3 squares.
  const MeshFile corner =
      read("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n");
  EXPECT_EQ(corner.triangles.size(), 4u);
  double area = 0.0;
  for (const auto& [a, b, c] : corner.triangles) {
    const auto& v = corner.vertices;
    area += 0.5 * (v[b] - v[a]).cross(v[c] - v[a]).norm();
  }
  EXPECT_EQ(area, 3.0);  // sums of small integers, so exact
}

TEST(MeshFile, CountsNegativeIndicesFromTheEnd) {
  const MeshFile mesh = read("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n");
  EXPECT_EQ(mesh.triangles[0], (std::array<std::uint32_t, 3>{1, 2, 3}));
}

TEST(MeshFile, TakesFacesBeforeTheirVertices) {
  EXPECT_EQ(read("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").triangles.size(), 1u);
}

TEST(MeshFile, RefusesEachBrokenFile) {
  const std::string v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const std::vector<std::pair<std::string, std::string>> rows = {
      {"", "a mesh with vertices; mesh.obj: none"},
      {"hello", "a mesh with vertices; mesh.obj: none"},
      {v, "a mesh with faces; mesh.obj: none"},
      {v + "f 1 2 4", "faces on vertices 1 to 3; mesh.obj:4: vertex 4"},
      {v + "f 0 1 2", "faces of vertex numbers, the first 1; mesh.obj:4: '0'"},
      {v + "f -4 1 2", "faces of vertex numbers, the first 1; mesh.obj:4: '-4'"},
      {v + "f 1 2 x", "faces of vertex numbers, the first 1; mesh.obj:4: 'x'"},
      {v + "f 1 2 99999999999999999999",
       "faces of vertex numbers, the first 1; mesh.obj:4: '99999999999999999999'"},
      {v + "f 1 2", "faces of 3 to 255 corners; mesh.obj:4: 2 corners"},
      {v + "f 1 2 2", "faces of different vertices; mesh.obj:4: vertex 2 twice"},
      {"v 0 0\n", "3 finite numbers; mesh.obj:1: ''"},
      {"v 0 nan 0\n", "3 finite numbers; mesh.obj:1: 'nan'"},
      {"v 0 0 1e999\n", "3 finite numbers; mesh.obj:1: '1e999'"},
      {"v 0 0 1.5m\n", "3 finite numbers; mesh.obj:1: '1.5m'"},
      // A polygon that crosses itself.
      {"v 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 2 0\nv 0 1 0\nf 1 2 3 4 5\n",
       "polygons that can be cut into triangles; mesh.obj: others"},
  };
  for (const auto& [content, expected] : rows) EXPECT_EQ(problem(content), expected) << content;
  EXPECT_EQ(problem(v + "v 0 0 0\nf 1 2 3", 3), "at most 3 vertices; mesh.obj:4: more");
}

TEST(MeshFile, RefusesFilesThatCannotBeRead) {
  const TemporaryFolder folder;
  EXPECT_THROW(readMeshFile(folder.path(), 100), MeshError);
  EXPECT_THROW(readMeshFile(folder.path() + "/missing.obj", 100), MeshError);
  const std::string large = folder.write("large.obj", "");
  std::filesystem::resize_file(large, 100'000'000);
  EXPECT_THROW(readMeshFile(large, 100), MeshError);
}

TEST(MeshFile, FindsFilesByPath) {
  EXPECT_EQ(findFile("/a/b.obj", ""), "/a/b.obj");
  EXPECT_EQ(findFile("b.obj", "/a"), "/a/b.obj");
  EXPECT_THROW(findFile("b.obj", ""), PathError);
}

TEST(MeshFile, FindsFilesInPackages) {
  const TemporaryFolder folder;
  const std::string manifest = "<package><name>\n a_package </name></package>";
  const std::string uri = "package://a_package/meshes/b.obj";
  folder.write("src/thing/package.xml", manifest);
  const std::string root = folder.path() + "/src/thing";
  // Above the scene, whatever the folder is called.
  EXPECT_EQ(findFile(uri, root + "/config/scenes"), root + "/meshes/b.obj");
  EXPECT_THROW(findFile(uri, ""), PathError);
  {
    const Variable variable("ROS_PACKAGE_PATH", "/nowhere:" + root);
    EXPECT_EQ(findFile(uri, ""), root + "/meshes/b.obj");
  }
  folder.write("ros/a_package/package.xml", manifest);
  {
    const Variable variable("ROS_PACKAGE_PATH", folder.path() + "/ros");
    EXPECT_EQ(findFile(uri, ""), folder.path() + "/ros/a_package/meshes/b.obj");
  }
  folder.write("install/share/a_package/package.xml", manifest);
  const Variable variable("CMAKE_PREFIX_PATH", folder.path() + "/install");
  EXPECT_EQ(findFile(uri, ""), folder.path() + "/install/share/a_package/meshes/b.obj");
  EXPECT_THROW(findFile("package://b_package/b.obj", root), PathError);
  EXPECT_THROW(findFile("package://a_package", root), PathError);
}

TEST(MeshFile, IsReadWithTheScene) {
  const TemporaryFolder folder;
  folder.write("meshes/t.obj", kTriangle);
  const std::string text =
      "objects: {skin: {type: mesh, file: meshes/t.obj, mass: 1, stiffness: 10,"
      " position: [1, 2, 3], orientation: [0, 0, 1], bend_stiffness: 2}}\n"
      "pins: {p: {object: skin, particles: [2]}}";
  const Scene scene = readSceneFile(folder.write("scene.yaml", text));
  const Mesh& mesh = std::get<Mesh>(scene.objects[0].shape);
  EXPECT_EQ(mesh.file, "meshes/t.obj");
  EXPECT_EQ(mesh.scale, 1.0);
  EXPECT_EQ(mesh.position, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(mesh.bend_stiffness, 2.0);
  EXPECT_EQ(mesh.vertices.size(), 3u);
  EXPECT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(problemsOf(text),
            std::vector<std::string>{"objects.skin.file: got 'meshes/t.obj', expected package:// "
                                     "or an absolute path; a relative one needs scene_file, "
                                     "the path of the scene"});
}

}  // namespace
}  // namespace mass_spring

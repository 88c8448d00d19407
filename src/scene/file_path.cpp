#include "scene/file_path.h"

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <vector>

namespace mass_spring {
namespace {

namespace fs = std::filesystem;

const std::string kScheme = "package://";

bool holdsPackage(const fs::path& folder, const std::string& package) {
  std::ifstream file(folder / "package.xml");
  if (!file) return false;
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const std::size_t begin = text.find("<name>");
  const std::size_t end = text.find("</name>");
  if (begin == std::string::npos || end == std::string::npos || end < begin) return false;
  std::istringstream name(text.substr(begin + 6, end - begin - 6));
  std::string word;
  return name >> word && word == package;
}

std::vector<fs::path> folders(const char* variable) {
  const char* value = std::getenv(variable);
  std::istringstream stream(value == nullptr ? "" : value);
  std::vector<fs::path> result;
  for (std::string folder; std::getline(stream, folder, ':');) {
    if (!folder.empty()) result.emplace_back(folder);
  }
  return result;
}

/// The folders where a package may lie, in order of search.
std::vector<fs::path> candidates(const std::string& package, const std::string& directory) {
  std::vector<fs::path> result;
  std::error_code error;
  std::vector<fs::path> starts = {fs::current_path(error)};
  if (!directory.empty()) starts.insert(starts.begin(), fs::absolute(directory, error));
  for (fs::path folder : starts) {
    for (; folder.has_relative_path(); folder = folder.parent_path()) result.push_back(folder);
  }
  for (const fs::path& folder : folders("ROS_PACKAGE_PATH")) {
    result.push_back(folder);
    result.push_back(folder / package);
  }
  for (const fs::path& prefix : folders("CMAKE_PREFIX_PATH")) {
    result.push_back(prefix / "share" / package);
  }
  result.push_back(fs::path("/usr/share") / package);
  return result;
}

}  // namespace

fs::path findFile(const std::string& file, const std::string& directory) {
  if (file.compare(0, kScheme.size(), kScheme) == 0) {
    const std::size_t slash = file.find('/', kScheme.size());
    if (slash == std::string::npos) throw PathError("package://PACKAGE/PATH");
    const std::string package = file.substr(kScheme.size(), slash - kScheme.size());
    for (const fs::path& folder : candidates(package, directory)) {
      if (holdsPackage(folder, package)) return folder / file.substr(slash + 1);
    }
    throw PathError("a package in ROS_PACKAGE_PATH or above the scene; there is no '" + package +
                    "'");
  }
  const fs::path path(file);
  if (path.is_absolute()) return path;
  if (directory.empty()) {
    throw PathError(
        "package:// or an absolute path; a relative one needs scene_file, the path of the scene");
  }
  return fs::path(directory) / path;
}

}  // namespace mass_spring

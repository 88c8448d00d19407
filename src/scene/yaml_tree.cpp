#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>

#include "mass_spring_sim/scene.h"
#include "mass_spring_sim/tree.h"
#include "scene/problems.h"
#include "scene/scalar.h"

namespace mass_spring {
namespace {

// The parser takes about a second for each MiB; this is a hundred thousand springs by hand.
constexpr std::size_t kMostYamlBytes = 4 << 20;
// Aliases repeat what they stand for, so a small file can stand for any number of values.
constexpr std::size_t kMostValues = 1'000'000;
// A scene needs 7. The parser calls itself for each level, so that this also bounds its stack.
constexpr std::size_t kDeepest = 64;

[[noreturn]] void refuse(const std::string& name, const std::string& got,
                         const std::string& expected) {
  throw SceneError({name + ": got " + got + ", expected " + expected});
}

/// A value that has been read, and what copying it costs.
struct Part {
  Tree tree;
  std::size_t values = 1;
  std::size_t levels = 0;  ///< of lists and maps
};

/// Turns the events of the parser into a tree. Aliases become copies; merge keys (<<) are resolved;
/// limits are checked while the parser reads, before anything large exists.
class TreeBuilder : public YAML::EventHandler {
 public:
  explicit TreeBuilder(std::string name) : name_(std::move(name)) {}

  const Tree& tree() const { return root_; }
  const Problems& problems() const { return problems_; }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (documents_++ > 0) fail(mark, "a second document", "one scene in each file");
  }
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    OnScalar(mark, "?", anchor, "");
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& text) override {
    const bool plain = tag.empty() || tag == "?";
    if (!plain && tag != "!" && tag != "tag:yaml.org,2002:str") failTag(mark, tag);
    Tree value = plain ? resolvePlainScalar(text) : Tree{text};
    if (expectsKey()) {
      open_.back().merges = plain && text == "<<";
      open_.back().key = text;
      open_.back().has_key = true;
      if (!std::holds_alternative<std::string>(value.value)) {
        problems_.add(path(), text + " as a key in line " + std::to_string(mark.line + 1),
                      "a string, so in quotes");
      }
    } else {
      close(mark, {std::move(value)}, anchor);
    }
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto part = anchored_.find(anchor);
    if (part == anchored_.end()) fail(mark, "an alias inside what it stands for", "a finite scene");
    if (open_.size() + part->second.levels > kDeepest) failDepth(mark);
    count(mark, part->second.values);
    close(mark, part->second, YAML::NullAnchor);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(mark, tag, "tag:yaml.org,2002:seq", anchor, {Tree::List()});
  }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(mark, tag, "tag:yaml.org,2002:map", anchor, {Tree::Map()});
  }
  void OnSequenceEnd() override { closeInnermost(); }
  void OnMapEnd() override {
    Open& innermost = open_.back();
    auto& map = std::get<Tree::Map>(innermost.part.tree.value);
    // The map's own keys come before those merged into it, and earlier maps before later ones;
    // insert() leaves a key alone that is there.
    for (Tree::Map& merged : innermost.merged) map.insert(merged.begin(), merged.end());
    closeInnermost();
  }

 private:
  /// A list or map whose end has not come yet.
  struct Open {
    Part part;
    YAML::anchor_t anchor;
    YAML::Mark mark;
    std::string key;  ///< whose value comes next
    bool has_key = false;
    bool merges = false;  ///< the key is <<
    std::vector<Tree::Map> merged;
  };

  [[noreturn]] void fail(const YAML::Mark& mark, const std::string& got,
                         const std::string& expected) const {
    refuse(name_, got + " in line " + std::to_string(mark.line + 1), expected);
  }
  [[noreturn]] void failTag(const YAML::Mark& mark, const std::string& tag) const {
    fail(mark, "the tag " + quote(tag), "values without tags");
  }
  [[noreturn]] void failDepth(const YAML::Mark& mark) const {
    fail(mark, "lists and maps nested too deeply",
         "at most " + std::to_string(kDeepest) + " levels");
  }

  bool expectsKey() const {
    return !open_.empty() && !open_.back().has_key &&
           std::holds_alternative<Tree::Map>(open_.back().part.tree.value);
  }

  void count(const YAML::Mark& mark, std::size_t values) {
    values_ += values;
    if (values_ > kMostValues) {
      fail(mark, "too many values",
           "at most " + std::to_string(kMostValues) + ", aliases included");
    }
  }

  void open(const YAML::Mark& mark, const std::string& tag, const std::string& own_tag,
            YAML::anchor_t anchor, Tree tree) {
    if (!tag.empty() && tag != "?" && tag != own_tag) failTag(mark, tag);
    if (open_.size() + 1 > kDeepest) failDepth(mark);
    open_.push_back({{std::move(tree), 1, 1}, anchor, mark, "", false, false, {}});
  }

  void closeInnermost() {
    Open innermost = std::move(open_.back());
    open_.pop_back();
    close(innermost.mark, std::move(innermost.part), innermost.anchor);
  }

  /// Takes a finished value to where it belongs.
  void close(const YAML::Mark& mark, Part part, YAML::anchor_t anchor) {
    count(mark, 1);
    if (anchor != YAML::NullAnchor) {
      count(mark, part.values);
      anchored_[anchor] = part;
    }
    if (open_.empty()) {
      root_ = std::move(part.tree);
      return;
    }
    Open& parent = open_.back();
    if (expectsKey()) {
      // Not thrown at once: a bracket that is never closed also looks like this to the parser, and
      // it will say so in the end.
      parent.key = "?";
      parent.has_key = true;
      problems_.add(path(), "no string as a key in line " + std::to_string(mark.line + 1),
                    "a string");
      return;
    }
    parent.part.values += part.values;
    parent.part.levels = std::max(parent.part.levels, part.levels + 1);
    if (auto* list = std::get_if<Tree::List>(&parent.part.tree.value)) {
      list->push_back(std::move(part.tree));
    } else {
      parent.has_key = false;
      if (parent.merges) {
        merge(mark, std::move(part.tree));
      } else {
        auto& map = std::get<Tree::Map>(parent.part.tree.value);
        const bool first = map.emplace(parent.key, std::move(part.tree)).second;
        if (!first) {
          problems_.add(path(), "this key again in line " + std::to_string(mark.line + 1),
                        "each key once");
        }
      }
    }
  }

  void merge(const YAML::Mark& mark, Tree tree) {
    const auto take = [&](Tree& source) {
      auto* map = std::get_if<Tree::Map>(&source.value);
      if (map == nullptr) fail(mark, describe(source) + " for <<", "a map or a list of maps");
      open_.back().merged.push_back(std::move(*map));
    };
    if (auto* list = std::get_if<Tree::List>(&tree.value)) {
      for (Tree& element : *list) take(element);
    } else {
      take(tree);
    }
  }

  /// Of the innermost key.
  std::string path() const {
    std::string path;
    for (const Open& level : open_) {
      const auto* list = std::get_if<Tree::List>(&level.part.tree.value);
      path = list == nullptr ? childPath(path, level.key) : elementPath(path, list->size());
    }
    return path;
  }

  std::string name_;
  Tree root_;
  Problems problems_;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, Part> anchored_;
  std::size_t values_ = 0;
  int documents_ = 0;
};

bool isText(const std::string& bytes) {
  return std::none_of(bytes.begin(), bytes.end(), [](unsigned char c) {
    return c < 0x20 && c != '\t' && c != '\n' && c != '\r';
  });
}

void refuseLarge(const std::string& name, std::size_t bytes) {
  if (bytes <= kMostYamlBytes) return;
  refuse(name, "too large a file", "at most " + std::to_string(kMostYamlBytes >> 20) + " MiB");
}

}  // namespace

Tree readYamlText(const std::string& text, const std::string& name) {
  refuseLarge(name, text.size());
  if (!isText(text)) refuse(name, "binary data", "YAML");
  TreeBuilder builder(name);
  std::istringstream stream(text);
  try {
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const YAML::Exception& error) {
    refuse(name,
           "an error in line " + std::to_string(error.mark.line + 1) + ", column " +
               std::to_string(error.mark.column + 1) + " (" + error.msg + ")",
           "YAML");
  }
  builder.problems().throwIfAny();
  return builder.tree();
}

Tree readYamlFile(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) refuse(path, "a directory", "a file");
  std::ifstream file(path, std::ios::binary);
  if (!file) refuse(path, std::generic_category().message(errno), "a YAML file");
  // No more is read than the limit, so that endless files end here too.
  std::string text(kMostYamlBytes + 1, '\0');
  file.read(&text[0], static_cast<std::streamsize>(text.size()));
  if (file.bad()) refuse(path, "a file that cannot be read", "a YAML file");
  text.resize(static_cast<std::size_t>(file.gcount()));
  return readYamlText(text, path);
}

}  // namespace mass_spring

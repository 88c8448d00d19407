// Steps scenes (as YAML), each beside another one in the same process, or beside none where that is
// an empty text: for callgrind, which counts what countedSteps() executes.
//   counted_steps_test OTHER SCENE [OTHER SCENE]...
// Prints for each pair, of the scene but for the second,
//   NONZEROS OTHER_NONZEROS BYTES ALLOCATIONS ITERATIONS EFFECT...
// the scalars in both step matrices, the memory that the simulation holds, what was allocated and
// the linear iterations in the counted steps, and its effects.
#include <malloc.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <functional>
#include <iostream>
#include <memory>
#include <string>

#include "mass_spring_sim/scene_reader.h"
#include "mass_spring_sim/simulation.h"

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* pointer, std::size_t size);
void __libc_free(void* pointer);
}

namespace {

using namespace mass_spring;

/// What the counted simulation has its memory from, block after block: how many instructions it
/// takes to copy one to another depends on how they lie, which nothing else may change.
class Arena {
 public:
  void clear() {
    used_ = held_ = 0;
    allocations_ = 0;
  }
  void* take(std::size_t size) {
    const std::size_t whole = (size + kAlignment - 1) / kAlignment * kAlignment + kAlignment;
    if (whole > sizeof(memory_) - used_) return nullptr;
    char* const block = memory_ + used_ + kAlignment;
    used_ += whole;
    sizeOf(block) = size;
    held_ += size;
    ++allocations_;
    return block;
  }
  bool has(const void* pointer) const {
    return !std::less<const void*>()(pointer, memory_) &&
           std::less<const void*>()(pointer, memory_ + sizeof(memory_));
  }
  void giveBack(void* block) { held_ -= sizeOf(block); }
  /// Of a block: lies before it.
  static std::size_t& sizeOf(void* block) {
    return *reinterpret_cast<std::size_t*>(static_cast<char*>(block) - kAlignment);
  }
  std::size_t held() const { return held_; }
  int allocations() const { return allocations_; }

 private:
  static constexpr std::size_t kAlignment = 64;
  alignas(4096) char memory_[1 << 26];
  std::size_t used_, held_;
  int allocations_;
};
Arena arena;
bool from_arena = false;

Scene scene(const char* yaml) { return readScene(readYamlText(yaml, "counted scene"), ""); }

}  // namespace

extern "C" {
void* malloc(std::size_t size) { return from_arena ? arena.take(size) : __libc_malloc(size); }
void* calloc(std::size_t count, std::size_t size) {
  if (!from_arena) return __libc_calloc(count, size);
  void* const block = arena.take(count * size);
  return block ? std::memset(block, 0, count * size) : nullptr;
}
void free(void* pointer) {
  if (arena.has(pointer)) {
    arena.giveBack(pointer);
  } else {
    __libc_free(pointer);
  }
}
void* realloc(void* pointer, std::size_t size) {
  if (!from_arena && !arena.has(pointer)) return __libc_realloc(pointer, size);
  void* const block = malloc(size);
  if (block && pointer) {
    const std::size_t before =
        arena.has(pointer) ? Arena::sizeOf(pointer) : malloc_usable_size(pointer);
    std::memcpy(block, pointer, std::min(size, before));
    free(pointer);
  }
  return block;
}

/// Not inlined, and with a name that callgrind is told.
__attribute__((noinline)) void countedSteps(Simulation& simulation) {
  for (int n = 0; n < 5; ++n) simulation.step();
}
}

int main(int argc, char** argv) {
  for (int a = 1; a + 1 < argc; a += 2) {
    std::unique_ptr<Simulation> other;
    if (*argv[a] != '\0') {
      other = std::make_unique<Simulation>(scene(argv[a]));
      for (int n = 0; n < 3; ++n) other->step();
    }
    Simulation(scene(argv[a + 1])).step();  // has made whatever is made once
    arena.clear();
    from_arena = true;
    Simulation simulation(scene(argv[a + 1]));
    for (int n = 0; n < 3; ++n) simulation.step();
    const auto iterations = simulation.totals().linear_iterations;
    const int allocations = arena.allocations();
    countedSteps(simulation);
    from_arena = false;
    std::cout << simulation.matrixNonzeros() << ' ' << (other ? other->matrixNonzeros() : 0) << ' '
              << arena.held() << ' ' << arena.allocations() - allocations << ' '
              << simulation.totals().linear_iterations - iterations;
    for (const std::string& name : simulation.model().effectNames()) std::cout << ' ' << name;
    std::cout << '\n';
  }
}

// Steps a scene, beside another one in the same process if a second is given (both as YAML): for
// callgrind, which counts what countedSteps() executes. Prints
//   ITERATIONS OTHER_NONZEROS NONZEROS BYTES EFFECT...
// of the counted steps, of both step matrices, the memory that the simulation holds, its effects.
#include <cstddef>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <utility>

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

/// Memory for the list of what is held, which is not listed itself.
template <typename T>
struct Unlisted {
  using value_type = T;
  Unlisted() = default;
  template <typename U>
  Unlisted(const Unlisted<U>&) {}
  T* allocate(std::size_t count) { return static_cast<T*>(__libc_malloc(count * sizeof(T))); }
  void deallocate(T* pointer, std::size_t) { __libc_free(pointer); }
  bool operator==(const Unlisted&) const { return true; }
  bool operator!=(const Unlisted&) const { return false; }
};
using Sizes =
    std::map<void*, std::size_t, std::less<void*>, Unlisted<std::pair<void* const, std::size_t>>>;
Sizes* listed = nullptr;  // what has been allocated and not freed since it was set

void* list(void* pointer, std::size_t size) {
  if (listed && pointer) (*listed)[pointer] = size;
  return pointer;
}

void unlist(void* pointer) {
  if (listed) listed->erase(pointer);
}

Scene scene(const char* yaml) { return readScene(readYamlText(yaml, "counted scene"), ""); }

}  // namespace

extern "C" {
void* malloc(std::size_t size) { return list(__libc_malloc(size), size); }
void* calloc(std::size_t count, std::size_t size) {
  return list(__libc_calloc(count, size), count * size);
}
void* realloc(void* pointer, std::size_t size) {
  unlist(pointer);
  return list(__libc_realloc(pointer, size), size);
}
void free(void* pointer) {
  unlist(pointer);
  __libc_free(pointer);
}

/// Not inlined, and with a name that callgrind is told.
__attribute__((noinline)) void countedSteps(Simulation& simulation) {
  for (int n = 0; n < 5; ++n) simulation.step();
}
}

int main(int argc, char** argv) {
  std::unique_ptr<Simulation> other;
  if (argc > 2) {
    other = std::make_unique<Simulation>(scene(argv[2]));
    for (int n = 0; n < 3; ++n) other->step();
  }
  Simulation(scene(argv[1])).step();  // has made whatever is made once
  Sizes sizes;
  listed = &sizes;
  Simulation simulation(scene(argv[1]));
  for (int n = 0; n < 3; ++n) simulation.step();
  const auto before = simulation.totals().linear_iterations;
  countedSteps(simulation);
  listed = nullptr;
  std::size_t bytes = 0;
  for (const auto& [pointer, size] : sizes) bytes += size;
  std::cout << simulation.totals().linear_iterations - before << ' '
            << (other ? other->matrixNonzeros() : 0) << ' ' << simulation.matrixNonzeros() << ' '
            << bytes;
  for (const std::string& name : simulation.model().effectNames()) std::cout << ' ' << name;
  std::cout << '\n';
}

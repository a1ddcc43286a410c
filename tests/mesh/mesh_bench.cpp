// Reading, writing and topology. The meshes are jittered Kuhn cubes of about 10k, 100k, 1M tets, and 4M with
// PALPATE_BENCH_LARGE=1. Counters: tets/s, and the bytes a tet that were allocated at the peak of one call.
#include <benchmark/benchmark.h>
#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <new>

#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "tests/support/scratch_folder.h"

namespace {

std::atomic<std::size_t> bytes_now{0};
std::atomic<std::size_t> bytes_peak{0};

void* allocate(std::size_t size) {
  void* block = std::malloc(size);
  if (block == nullptr) throw std::bad_alloc();
  const std::size_t now = bytes_now += malloc_usable_size(block);
  if (now > bytes_peak) bytes_peak = now;
  return block;
}

void release(void* block) {
  if (block == nullptr) return;
  bytes_now -= malloc_usable_size(block);
  std::free(block);
}

}  // namespace

void* operator new(std::size_t size) {
  return allocate(size);
}
void operator delete(void* block) noexcept {
  release(block);
}
void operator delete(void* block, std::size_t /*size*/) noexcept {
  release(block);
}

namespace palpate {
namespace {

/// Runs `work` for the benchmark, and counts tets and memory: the peak above what was allocated before.
template <typename Work>
void measure(benchmark::State& state, std::size_t tets, Work&& work) {
  std::size_t most = 0;
  for (auto _ : state) {
    const std::size_t before = bytes_now;
    bytes_peak = before;
    work();
    most = std::max(most, bytes_peak - before);
  }
  const auto count = static_cast<double>(tets);
  state.counters["tets"] = count;
  state.counters["tets/s"] = benchmark::Counter(count, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["bytes/tet"] = static_cast<double>(most) / count;
}

TetMesh mesh_for(const benchmark::State& state) {
  return build_kuhn_cube(static_cast<int>(state.range(0)), 0.3, 1);
}

void add_file_rate(benchmark::State& state, const std::filesystem::path& path) {
  const auto size = static_cast<double>(std::filesystem::file_size(path));
  state.counters["file_MB"] = benchmark::Counter(size * 1e-6, benchmark::Counter::kIsIterationInvariantRate);
}

void bm_read_medit(benchmark::State& state) {
  const test::ScratchFolder folder;
  const TetMesh mesh = mesh_for(state);
  write_medit(folder / "a.mesh", mesh);
  measure(state, mesh.tets.size(), [&] { benchmark::DoNotOptimize(read_medit(folder / "a.mesh")); });
  add_file_rate(state, folder / "a.mesh");
}

void bm_write_medit(benchmark::State& state) {
  const test::ScratchFolder folder;
  const TetMesh mesh = mesh_for(state);
  measure(state, mesh.tets.size(), [&] { write_medit(folder / "a.mesh", mesh); });
  add_file_rate(state, folder / "a.mesh");
}

template <auto Build>
void bm_topology(benchmark::State& state) {
  const TetMesh mesh = mesh_for(state);
  measure(state, mesh.tets.size(), [&] {
    if constexpr (std::is_invocable_v<decltype(Build), const TetMesh&>) {
      benchmark::DoNotOptimize(Build(mesh));
    } else {
      benchmark::DoNotOptimize(Build(mesh, 1));  // on one thread
    }
  });
}

void bm_build_jittered_cube(benchmark::State& state) {
  const std::size_t tets = mesh_for(state).tets.size();
  measure(state, tets, [&] { benchmark::DoNotOptimize(mesh_for(state)); });
}

void with_sizes(benchmark::internal::Benchmark* bench) {
  bench->ArgName("cells")->Unit(benchmark::kMillisecond)->Arg(12)->Arg(26)->Arg(55);
  const char* large = std::getenv("PALPATE_BENCH_LARGE");
  if (large != nullptr && *large == '1') bench->Arg(87);
}

BENCHMARK(bm_read_medit)->Apply(with_sizes)->UseRealTime();
BENCHMARK(bm_write_medit)->Apply(with_sizes)->UseRealTime();
BENCHMARK_TEMPLATE(bm_topology, build_vertex_stars)->Name("bm_build_vertex_stars")->Apply(with_sizes);
BENCHMARK_TEMPLATE(bm_topology, build_edges)->Name("bm_build_edges")->Apply(with_sizes);
BENCHMARK_TEMPLATE(bm_topology, build_faces)->Name("bm_build_faces")->Apply(with_sizes);
BENCHMARK_TEMPLATE(bm_topology, build_boundary)->Name("bm_build_boundary")->Apply(with_sizes);
BENCHMARK(bm_build_jittered_cube)->Apply(with_sizes);

}  // namespace
}  // namespace palpate

// libFuzzer target: any bytes are a valid mesh or one InputError, and a mesh that was read comes back to the
// bit.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/base/error.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/orientation.h"

namespace {

void check(bool condition) {
  if (!condition) std::abort();
}

std::filesystem::path scratch_file() {
  std::string name = (std::filesystem::temp_directory_path() / "palpate-fuzz-XXXXXX").string();
  check(::mkdtemp(name.data()) != nullptr);
  return std::filesystem::path(name) / "any.mesh";
}

void check_mesh(const palpate::TetMesh& mesh) {
  const auto& p = mesh.points;
  check(!mesh.tets.empty());
  check(std::all_of(p.begin(), p.end(), palpate::is_finite));
  for (const palpate::Tet& t : mesh.tets) {
    for (const palpate::Index v : t) check(v < p.size());
    check(palpate::orientation(p[t[0]], p[t[1]], p[t[2]], p[t[3]]) == 1);
  }
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): the name that libFuzzer calls
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::filesystem::path path = scratch_file();
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  palpate::TetMesh mesh;
  try {
    mesh = palpate::read_medit(path).mesh;
  } catch (const palpate::InputError&) {
    return 0;
  }
  check_mesh(mesh);
  palpate::write_medit(path, mesh);
  check(palpate::read_medit(path).mesh == mesh);
  return 0;
}

// Built with gmsh, GPL: this program is distributed under GPL-3.0-or-later.
#include <gmsh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string_view>
#include <unordered_map>

#include "core/base/error.h"
#include "reference/gmsh/gmsh_tools.h"
#include "reference/gmsh/msh_numbers.h"

namespace palpate::reference {
namespace {

constexpr int kLineType = 1;
constexpr int kPointType = 15;

/// Refuses every element kind but linear tets; simpler kinds that bound them are left out, and noted.
void check_kinds(const std::string& where, std::vector<std::string>& notes) {
  std::vector<int> kinds;
  gmsh::model::mesh::getElementTypes(kinds);
  bool has_tets = false;
  for (const int kind : kinds) {
    std::string name;
    int dimension = 0;
    int order = 0;
    int nodes = 0;
    int primary_nodes = 0;
    std::vector<double> local;
    gmsh::model::mesh::getElementProperties(kind, name, dimension, order, nodes, local, primary_nodes);
    if (kind == kTetType) {
      has_tets = true;
    } else if (kind == kPointType || kind == kLineType || kind == kTriangleType) {
      if (kind != kTriangleType) notes.push_back("elements of kind \"" + name + "\" are left out");
    } else {
      throw InputError(where, 0, "linear tetrahedra and triangles only", "elements of kind \"" + name + "\"");
    }
  }
  if (!has_tets) throw InputError(where, 0, "tetrahedra", "none");
}

/// gmsh takes any file that does not start as a mesh does for a script of its own language, and runs it:
/// SystemCall is a statement of it. So only what it takes for a mesh gets there.
void check_is_msh(const std::filesystem::path& path) {
  constexpr std::array<std::string_view, 3> kStarts{"$MeshFormat", "$NOD", "$Comments"};
  std::ifstream file(path, std::ios::binary);
  std::string line;
  std::getline(file, line);
  const bool is_msh = std::any_of(kStarts.begin(), kStarts.end(),
                                  [&](std::string_view start) { return line.rfind(start, 0) == 0; });
  if (!is_msh)
    throw InputError(path.string(), 1, "a .msh file, which starts with $MeshFormat", "something else");
}

/// The file under a name that nobody else knows: beside the file itself gmsh would look for NAME.opt, and run
/// that.
class PrivateName {
 public:
  PrivateName(const std::filesystem::path& path, const std::filesystem::path& scratch) {
    std::string folder = (scratch / "palpate-msh-XXXXXX").string();
    if (::mkdtemp(folder.data()) == nullptr) throw UnavailableError("cannot make a folder " + folder);
    folder_ = folder;
    std::filesystem::create_symlink(std::filesystem::absolute(path), name());
  }
  ~PrivateName() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  PrivateName(const PrivateName&) = delete;
  PrivateName& operator=(const PrivateName&) = delete;

  std::filesystem::path name() const { return folder_ / "read.msh"; }

 private:
  std::filesystem::path folder_;
};

}  // namespace

TetMesh read_msh(const std::filesystem::path& path, const std::filesystem::path& scratch,
                 std::vector<std::string>& notes) {
  const std::string where = path.string();
  check_is_msh(path);
  check_numbers_differ(path);
  const PrivateName own(path, scratch);
  try {
    gmsh::merge(own.name().string());
  } catch (...) {  // 4.8 throws integers, strings or exceptions
    throw InputError(where, 0, "a .msh file that gmsh can read", "something else");
  }
  check_kinds(where, notes);
  std::vector<std::size_t> tags;
  std::vector<double> coordinates;
  std::vector<double> parameters;
  gmsh::model::mesh::getNodes(tags, coordinates, parameters);
  TetMesh mesh;
  std::unordered_map<std::size_t, Index> index_of;
  for (std::size_t i = 0; i < tags.size(); ++i) {
    const Vec3 p{coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]};
    if (!is_finite(p)) throw InputError(where, 0, "finite coordinates", "NaN or infinity");
    if (index_of.emplace(tags[i], static_cast<Index>(mesh.points.size())).second) mesh.points.push_back(p);
  }
  std::vector<std::size_t> element_tags;
  std::vector<std::size_t> corners;
  gmsh::model::mesh::getElementsByType(kTetType, element_tags, corners);
  for (std::size_t i = 0; i + 3 < corners.size(); i += 4) {
    Tet tet{};
    for (std::size_t k = 0; k < 4; ++k) {
      const auto found = index_of.find(corners[i + k]);
      if (found == index_of.end()) {
        throw InputError(where, 0, "the vertices of each tetrahedron",
                         "a missing node " + std::to_string(corners[i + k]));
      }
      tet[k] = found->second;
    }
    mesh.tets.push_back(tet);
  }
  return mesh;
}

}  // namespace palpate::reference

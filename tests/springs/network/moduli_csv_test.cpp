#include "core/springs/network/moduli_csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/scratch_folder.h"

namespace palpate::springs {
namespace {

using testing::HasSubstr;

TEST(ModuliCsv, ReadsBackToTheSameBits) {
  const test::ScratchFolder folder;
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 1);
  for (const bool at_vertices : {true, false}) {
    DilatationModuli moduli{at_vertices, {}};
    const std::size_t count = at_vertices ? mesh.points.size() : mesh.tets.size();
    for (std::size_t i = 0; i < count; ++i) moduli.modulus_pa.push_back(1.0 / (3.0 + static_cast<double>(i)));
    write_moduli_csv(folder / "m.csv", moduli);
    const DilatationModuli back = read_moduli_csv(folder / "m.csv", mesh);
    EXPECT_EQ(back.at_vertices, at_vertices);
    EXPECT_EQ(back.modulus_pa, moduli.modulus_pa);
  }
}

TEST(ModuliCsv, RefusesWhatDoesNotMatchTheMesh) {
  const test::ScratchFolder folder;
  const TetMesh mesh = build_kuhn_cube(1, 0.0, 1);  // 8 vertices
  const auto complaint = [&](const std::string& text) -> std::string {
    try {
      read_moduli_csv(folder.add("m.csv", text), mesh);
    } catch (const InputError& error) {
      return error.what();
    }
    return "nothing";
  };
  const std::string good = "vertex,modulus_pa\n0,1\n1,1\n2,1\n3,1\n4,1\n5,1\n6,1\n7,1\n";
  EXPECT_EQ(complaint(good), "nothing");
  EXPECT_THAT(complaint(good + "8,1\n"), HasSubstr("of another mesh"));
  EXPECT_THAT(complaint("vertex,modulus_pa\n0,1\n"), HasSubstr("of another mesh"));
  EXPECT_THAT(complaint("node,modulus_pa\n0,1\n"), HasSubstr("tet,modulus_pa"));
  for (const char* row : {"1,1", "0,-1", "0,nan", "0,inf", "0;1", "0,1x", "0,", ""})
    EXPECT_THAT(complaint(std::string("vertex,modulus_pa\n") + row + "\n"), HasSubstr("m.csv:2")) << row;
  EXPECT_THROW(read_moduli_csv(folder / "nowhere.csv", mesh), InputError);
  EXPECT_THROW(read_moduli_csv(folder.path(), mesh), InputError);
}

}  // namespace
}  // namespace palpate::springs

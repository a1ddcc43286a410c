// Makes a mesh of two tets that share a face, builds its edges and prints what it found.
#include <cstdio>

#include "core/mesh/topology.h"

int main() {
  palpate::TetMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.tets = {{0, 1, 2, 3}, {0, 2, 1, 4}};
  const std::size_t edges = palpate::build_edges(mesh).size();
  const std::size_t boundary_faces = palpate::build_boundary(mesh).size();
  std::printf("edges %zu boundary_faces %zu\n", edges, boundary_faces);
  return edges == 9 && boundary_faces == 6 ? 0 : 1;
}

// A scene as text, part by part, for tests that change one of them.
#pragma once

#include <string>

namespace palpate::test {

/// Lines 1 to 6 of the file are schema, mesh, material, clamp, load (where these take one line) and analysis.
struct SceneText {
  std::string mesh = "{file: cube.mesh, length_m: 0.1}";
  std::string material = "{young_modulus_pa: 10000, poisson_ratio: 0.25, density_kg_m3: 1000}";
  std::string clamp = "[{half_space: {normal: [0, 0, 1], offset_m: 0}}]";
  std::string load = "[{gravity_m_s2: [0, 0, -9.81]}]";
  std::string analysis = "static";
  std::string rest;

  std::string yaml() const {
    return "schema: palpate/scene/1\nmesh: " + mesh + "\nmaterial: " + material + "\nclamp: " + clamp +
           "\nload: " + load + "\nanalysis: " + analysis + "\n" + rest;
  }
};

}  // namespace palpate::test

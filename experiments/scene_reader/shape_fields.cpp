#include "experiments/scene_reader/shape_fields.h"

#include <algorithm>

#include "core/base/error.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

/// What the shape says of a key's value, with the key's line.
void check_key(const YamlValue& value, const ShapeRequest& shape) {
  const std::string complaint = shape_complaint(shape);
  if (!complaint.empty()) value.fail(complaint);
}

MeshSize read_size(const YamlFields& fields) {
  MeshSize size;
  const auto vertices = fields.find("vertices");
  const auto edge_length = fields.find("edge_length");
  if (vertices && edge_length) edge_length->fail("a mesh takes \"vertices\" or \"edge_length\", not both");
  if (vertices) size.vertices = static_cast<std::uint64_t>(vertices->integer(4, kMostVertices));
  if (edge_length) size.edge_length = edge_length->number(1e-9, 1e9);
  return size;
}

}  // namespace

const std::vector<std::string>& shape_keys() {
  static const std::vector<std::string> keys{"vertices", "edge_length", "skin", "seed", "jitter"};
  return keys;
}

std::vector<std::string> with_shape_keys(std::vector<std::string> more) {
  more.insert(more.end(), shape_keys().begin(), shape_keys().end());
  return more;
}

ShapeRequest read_shape_fields(const YamlFields& fields, const YamlValue& make) {
  ShapeRequest shape;
  shape.name = make.text();
  std::vector<std::string> known;
  for (const ShapeInfo& info : list_shapes()) known.push_back(info.name);
  if (std::find(known.begin(), known.end(), shape.name) == known.end())
    make.fail("unknown shape \"" + shape.name + "\"" + nearest_hint(shape.name, known));
  shape.size = read_size(fields);
  if (const auto skin = fields.find("skin")) {
    const auto kind = kSkinKinds.find(skin->text());
    if (!kind) skin->fail_expected(kSkinKinds.known());
    shape.skin = *kind;
    check_key(*skin, shape);
  }
  if (const auto seed = fields.find("seed")) {
    shape.seed = static_cast<std::uint64_t>(seed->integer(0, kLargestSeed));
    check_key(*seed, shape);
  }
  if (const auto jitter = fields.find("jitter")) {
    shape.jitter = jitter->number(0.0, 0.5);
    check_key(*jitter, shape);
  }
  return shape;
}

MeshSize read_surface_size(const YamlFields& fields) {
  for (const char* key : {"skin", "seed", "jitter"}) {
    if (const auto extra = fields.find(key))
      extra->fail("\"" + std::string(key) + "\" belongs to \"make\", not to the file of a surface");
  }
  return read_size(fields);
}

void refuse_shape_keys(const YamlFields& fields) {
  for (const std::string& key : shape_keys()) {
    if (const auto extra = fields.find(key))
      extra->fail("\"" + key + "\" belongs to \"make\", not to a file");
  }
}

}  // namespace palpate::experiments

#include "experiments/live/live_page.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <tuple>
#include <utility>

#include "core/base/error.h"
#include "experiments/files/places.h"
#include "experiments/files/plain_file.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

/// Arrays in one run of bytes.
class Packer {
 public:
  template <typename Item>
  json add(const char* type, const std::vector<Item>& items) {
    bytes_.resize((bytes_.size() + 7) / 8 * 8, '\0');
    json out{{"type", type}, {"at", bytes_.size()}, {"count", items.size()}};
    const std::size_t at = bytes_.size();
    bytes_.resize(at + items.size() * sizeof(Item));
    if (!items.empty()) std::memcpy(bytes_.data() + at, items.data(), items.size() * sizeof(Item));
    return out;
  }

  /// Arrays of a few numbers each, one behind the other.
  template <typename Number, typename Item>
  json add_flat(const char* type, const std::vector<Item>& items) {
    std::vector<Number> flat;
    flat.reserve(items.size() * std::tuple_size_v<Item>);
    for (const Item& item : items) flat.insert(flat.end(), item.begin(), item.end());
    return add(type, flat);
  }

  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

json pack_points(const std::vector<Vec3>& points, Packer& packer) {
  std::vector<double> flat;
  for (const Vec3& p : points) flat.insert(flat.end(), {p.x, p.y, p.z});
  return packer.add("f64", flat);
}

json pack_level(const LiveLevel& level, Packer& packer) {
  json out{{"removed_ratio", level.removed_ratio},
           {"points", pack_points(level.mesh.points, packer)},
           {"tets", packer.add_flat<std::uint32_t>("u32", level.mesh.tets)},
           {"spring_ends", packer.add_flat<std::uint32_t>("u32", level.springs.springs)},
           {"spring_rest_m", packer.add("f64", level.springs.rest_length_m)},
           {"spring_n_per_m", packer.add("f64", level.springs.stiffness_n_per_m)},
           {"given_number", packer.add("u32", level.given_number)},
           {"supports", json::array()},
           {"held", json::array()}};
  for (const ElasticSupport& support : level.holding.supports)
    out["supports"].push_back({{"faces", packer.add_flat<std::uint32_t>("u32", support.patch.faces)},
                               {"weights", packer.add("f64", support.patch.weight)},
                               {"stiffness_pa_per_m", support.stiffness_pa_per_m}});
  for (const HeldFaces& held : level.holding.held)
    out["held"].push_back(
        {{"faces", packer.add_flat<std::uint32_t>("u32", held.faces)},
         {"axes", (held.axes[0] ? 1 : 0) + (held.axes[1] ? 2 : 0) + (held.axes[2] ? 4 : 0)}});
  return out;
}

std::string part(const char* name, const char* what) {
  const auto bytes = read_bytes(page_folder() / name);
  if (!bytes)
    throw UnavailableError(std::string("this build has no ") + what + " for live pages (page/" + name +
                           "): it takes the packages emscripten, nodejs and npm, and a new build");
  return *bytes;
}

std::string escape_html(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

}  // namespace

std::string base64_of(const std::string& bytes) {
  static constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = bytes.size() - i;
    const auto byte = [&](std::size_t k) {
      return k < left ? static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i + k])) : 0U;
    };
    const std::uint32_t three = byte(0) << 16U | byte(1) << 8U | byte(2);
    out += kDigits[three >> 18U];
    out += kDigits[(three >> 12U) & 63U];
    out += left > 1 ? kDigits[(three >> 6U) & 63U] : '=';
    out += left > 2 ? kDigits[three & 63U] : '=';
  }
  return out;
}

std::string escape_for_script(std::string text, bool is_json) {
  // JSON has "<" in strings alone. A script has "</" and "<!--" there alone, and "\/" is "/" in it.
  const auto replace = [&](const char* what, const char* with) {
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 2))
      text.replace(at, std::strlen(what), with);
  };
  if (is_json) {
    replace("<", "\\u003c");
  } else {
    replace("</", "<\\/");
    replace("<!--", "<\\!--");
  }
  return text;
}

LiveBytes pack_live(const LiveBodyData& body) {
  Packer packer;
  LiveBytes out;
  out.description = {{"schema", "palpate/live/1"},
                     {"title", body.title},
                     {"kind", body.kind},
                     {"young_modulus_pa", body.material.young_modulus_pa},
                     {"poisson_ratio", body.material.poisson_ratio},
                     {"density_kg_m3", body.material.density_kg_m3},
                     {"damping_stiffness_s", body.damping_stiffness_s},
                     {"damping_mass_per_s", body.damping_mass_per_s},
                     {"pad_radius_m", body.pad_radius_m},
                     {"pad_pa_per_m", body.pad_pa_per_m},
                     {"start", body.start},
                     {"spring_source", body.spring_source},
                     {"notes", body.notes},
                     {"levels", json::array()},
                     {"table", nullptr},
                     {"no_table", body.no_table}};
  for (const LiveLevel& level : body.levels) out.description["levels"].push_back(pack_level(level, packer));
  if (body.table)
    out.description["table"] = {{"vertices", packer.add("u32", body.table->vertices)},
                                {"skin", packer.add("f32", body.table->skin)},
                                {"field", packer.add("f32", body.table->field)}};
  out.bytes = packer.take();
  return out;
}

void check_live_parts() {
  for (const char* name : {"live_engine.js", "live.js", "live_worker.js", "live.css"}) part(name, "part");
}

std::string write_live_page(const LiveBodyData& body) {
  const std::string engine = part("live_engine.js", "engine");
  const std::string script = part("live.js", "script");
  const std::string worker = part("live_worker.js", "script");
  const std::string style = part("live.css", "style");
  const LiveBytes packed = pack_live(body);
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      // Nothing is fetched from anywhere: the page may run what is in it, and no more.
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline' "
      "'wasm-unsafe-eval' blob:; worker-src blob:; style-src 'unsafe-inline'; img-src data: "
      "blob:\">\n"
      "<link rel=\"icon\" href=\"data:,\">\n";
  out += "<title>" + escape_html(body.title) + " under the finger</title>\n<style>\n" + style +
         "</style>\n</head>\n";
  out +=
      "<body>\n<main id=\"live\"></main>\n<noscript>This page is a program: it needs "
      "JavaScript.</noscript>\n";
  out += "<script type=\"application/json\" id=\"live-body\">" +
         escape_for_script(packed.description.dump(), true) + "</script>\n";
  out += "<script type=\"text/plain\" id=\"live-arrays\">" + base64_of(packed.bytes) + "</script>\n";
  out += "<script type=\"text/plain\" id=\"live-engine\">" +
         escape_for_script(engine + "\n" + worker, false) + "</script>\n";
  out += "<script>" + escape_for_script(script, false) + "</script>\n</body>\n</html>\n";
  return out;
}

}  // namespace palpate::experiments

// What palpate live writes and serves: the body's bytes, texts that stand inside of scripts, tables, the
// server's answers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <future>
#include <thread>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "experiments/judging/judge_record.h"
#include "experiments/live/live_page.h"
#include "experiments/live/live_prepare.h"
#include "experiments/live/live_request.h"
#include "experiments/live/live_server.h"
#include "experiments/live/live_table.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using testing::HasSubstr;

/// RFC 4648, section 10.
TEST(LivePage, Base64IsThatOfTheStandard) {
  EXPECT_EQ(base64_of(""), "");
  EXPECT_EQ(base64_of("f"), "Zg==");
  EXPECT_EQ(base64_of("fo"), "Zm8=");
  EXPECT_EQ(base64_of("foo"), "Zm9v");
  EXPECT_EQ(base64_of("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64_of("\xff\xfe\xfd"), "//79");
}

TEST(LivePage, TextsInScriptsCannotEndThem) {
  const nlohmann::json text{{"title", "</script><script>alert(1)</script><!-- \\ \" "}};
  const std::string escaped = escape_for_script(text.dump(), true);
  EXPECT_EQ(escaped.find('<'), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(escaped), text);
  const std::string script = escape_for_script("a = '</script>' + '<!--'; if (1 < 2) b();", false);
  EXPECT_EQ(script, "a = '<\\/script>' + '<\\!--'; if (1 < 2) b();");
}

/// Arrays come back from the bytes where the description says.
TEST(LivePage, PackedArraysAreWhereTheDescriptionSays) {
  LiveBodyData body;
  body.levels.push_back({0.0, build_kuhn_cube(2, 0.1, 3), {}, {}, {}});
  LiveLevel& level = body.levels.front();
  level.springs = {{{0, 1}, {0, 2}, {1, 2}}, {1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}};
  level.holding.supports.push_back({{{{0, 1, 2}}, {0.25}}, 1e6, {}});
  body.table = LiveTable{{1, 2, 3}, {1.5F}, {2.5F, 3.5F}};
  const LiveBytes packed = pack_live(body);
  const nlohmann::json& described = packed.description.at("levels")[0];
  const auto number = [&](const nlohmann::json& place, std::size_t k) {
    EXPECT_EQ(place.at("at").get<std::size_t>() % 8, 0u);
    double out = 0.0;
    std::memcpy(&out, packed.bytes.data() + place.at("at").get<std::size_t>() + 8 * k, 8);
    return out;
  };
  EXPECT_EQ(number(described.at("points"), 3 * 5 + 1), level.mesh.points[5].y);
  EXPECT_EQ(number(described.at("spring_n_per_m"), 2), 6.0);
  EXPECT_EQ(number(described.at("supports")[0].at("weights"), 0), 0.25);
  Index tet = 0;
  std::memcpy(&tet, packed.bytes.data() + described.at("tets").at("at").get<std::size_t>() + 4 * (4 * 7 + 3),
              4);
  EXPECT_EQ(tet, level.mesh.tets[7][3]);
  EXPECT_EQ(packed.description.at("table").at("field").at("count"), 2);
}

/// Simplified levels keep the supports' faces in space and their area; a scene's own model starts.
TEST(LivePrepare, LevelsShareSkinAndSupports) {
  const test::ScratchFolder folder;
  TetMesh cube = build_kuhn_cube(9, 0.2, 3);
  for (Vec3& p : cube.points) p = 60.0 * p;
  write_medit(folder.path() / "cube.mesh", cube);
  LiveWish wish;
  wish.source = folder.path() / "cube.mesh";
  wish.unit_m = 0.001;
  wish.with_table = false;
  const LiveBodyData body = prepare_live(wish, load_registry());
  ASSERT_GE(body.levels.size(), 2u);
  EXPECT_EQ(body.kind, "mesh");
  const auto support_moment = [](const LiveLevel& level) {
    Vec3 sum;
    for (const ElasticSupport& support : level.holding.supports) {
      for (std::size_t f = 0; f < support.patch.faces.size(); ++f) {
        const auto [a, b, c] = support.patch.faces[f];
        const std::vector<Vec3>& p = level.mesh.points;
        const double area = 0.5 * support.patch.weight[f] * length(cross(p[b] - p[a], p[c] - p[a]));
        sum = sum + area * (p[a] + p[b] + p[c]);
      }
    }
    return sum;
  };
  const LiveLevel& whole = body.levels.front();
  EXPECT_GT(length(support_moment(whole)), 0.0);
  for (const LiveLevel& level : body.levels) {
    EXPECT_EQ(support_moment(level), support_moment(whole)) << level.removed_ratio;
    EXPECT_FALSE(level.springs.springs.empty());
    EXPECT_LE(static_cast<double>(level.mesh.tets.size()),
              (1.0 - level.removed_ratio) * static_cast<double>(whole.mesh.tets.size()) + 1.0);
    for (const Edge& ends : level.springs.springs) EXPECT_LT(ends[1], level.mesh.points.size());
  }
  EXPECT_EQ(body.no_table, "it was not asked for");
}

/// Whatever order the vertices of a body have, it is still the same body, and each knows its number.
TEST(LivePrepare, VerticesKnowTheirNumbersInTheMeshThatWasGiven) {
  const test::ScratchFolder folder;
  TetMesh cube = build_kuhn_cube(5, 0.2, 3);
  for (Vec3& p : cube.points) p = 0.06 * p;
  write_medit(folder.path() / "cube.mesh", cube);
  LiveWish wish;
  wish.source = folder.path() / "cube.mesh";
  wish.unit_m = 1.0;
  wish.with_table = false;
  const LiveBodyData body = prepare_live(wish, load_registry());
  const LiveLevel& whole = body.levels.front();
  ASSERT_EQ(whole.given_number.size(), cube.points.size());
  const auto sorted = [](const TetMesh& mesh, const auto& number) {
    std::vector<Tet> tets = mesh.tets;
    for (Tet& tet : tets) {
      for (Index& v : tet) v = number(v);
      std::sort(tet.begin(), tet.end());
    }
    std::sort(tets.begin(), tets.end());
    return tets;
  };
  EXPECT_EQ(sorted(whole.mesh, [&](Index v) { return whole.given_number[v]; }),
            sorted(cube, [](Index v) { return v; }));
  bool is_moved = false;
  for (std::size_t v = 0; v < cube.points.size(); ++v) {
    EXPECT_EQ(whole.mesh.points[v], cube.points[whole.given_number[v]]);
    is_moved = is_moved || whole.given_number[v] != v;
  }
  EXPECT_TRUE(is_moved);
  for (std::size_t k = 1; k < body.levels.size(); ++k) EXPECT_TRUE(body.levels[k].given_number.empty());
  EXPECT_TRUE(judge_mesh(whole.mesh).violations.empty());
}

/// The folder of a fit starts with the model that its scene names; a scene that moves, with its damping and
/// step.
TEST(LivePrepare, AFitStartsWithWhatWasChosen) {
  const test::ScratchFolder folder;
  TetMesh cube = build_kuhn_cube(4, 0.2, 3);
  for (Vec3& p : cube.points) p = 0.06 * p;
  write_medit(folder.path() / "organ.mesh", cube);
  const std::string body =
      "schema: palpate/scene/1\nmesh: {file: organ.mesh, unit_m: 1}\n"
      "material: {young_modulus_pa: 5000, poisson_ratio: 0.3, density_kg_m3: 1000}\n"
      "clamp: [{half_space: {normal: [0, 0, 1], share: 0.1}, elastic_pa_per_m: 1.0e6}]\n"
      "load: [{gravity_m_s2: [0, 0, -9.81]}]\n";
  const auto write = [&](const std::string& rest) {
    std::ofstream(folder.path() / "scene.yaml") << body << rest;
    LiveWish wish;
    wish.source = folder.path();
    wish.with_table = false;
    return prepare_live(wish, load_registry());
  };
  std::ofstream(folder.path() / "fit.json") << "{}";
  const LiveBodyData fit = write("model: {smoothed: blend, theta: 0.6}\nanalysis: static\n");
  EXPECT_EQ(fit.kind, "fit");
  EXPECT_EQ(fit.start.at("model"), "smoothed");
  EXPECT_EQ(fit.start.at("theta"), 0.6);
  EXPECT_EQ(fit.start.at("rest"), "tet");
  EXPECT_EQ(fit.start.at("law"), "corotated");
  EXPECT_EQ(fit.material.young_modulus_pa, 5000.0);
  EXPECT_EQ(fit.spring_source.at("method"), "springs.isotropy_patch");
  const LiveBodyData moving = write(
      "model: {springs: van_gelder, volume: node_average}\n"
      "analysis: {dynamic: {integrator: bdf2, time_step_s: 0.002, duration_s: 1, damping: {mass_per_s: "
      "7}}}\n");
  EXPECT_EQ(moving.start.at("model"), "springs");
  EXPECT_EQ(moving.start.at("volume"), "node_average");
  EXPECT_EQ(moving.start.at("integrator"), "bdf2");
  EXPECT_EQ(moving.start.at("step_s"), 0.002);
  EXPECT_EQ(moving.start.at("law"), "linear");
  EXPECT_EQ(moving.damping_mass_per_s, 7.0);
  EXPECT_EQ(moving.spring_source.at("method"), "springs.van_gelder");
  const LiveBodyData other = write("model: {finite_elements: p2}\nanalysis: static\n");
  EXPECT_EQ(other.start.at("model"), "smoothed");
  EXPECT_THAT(other.notes, testing::Contains(HasSubstr("fem.p2, does not move live")));
  const LiveBodyData linear = write("model: {finite_elements: p1}\nanalysis: static\n");
  EXPECT_EQ(linear.start.at("model"), "smoothed");
  EXPECT_EQ(linear.start.at("domain"), "tet");
  EXPECT_EQ(linear.start.at("theta"), 1.0);
  EXPECT_THAT(linear.notes, testing::Contains(HasSubstr("the same elements")));
}

/// Quadratic elements stand in a page as the table of their answers.
TEST(LivePrepare, QuadraticElementsStartAsTheirTable) {
  if (!load_registry().find("reduced.compliance")) GTEST_SKIP() << "no contestant reduced.compliance";
  const test::ScratchFolder folder;
  TetMesh cube = build_kuhn_cube(3, 0.2, 3);
  for (Vec3& p : cube.points) p = 0.06 * p;
  write_medit(folder.path() / "organ.mesh", cube);
  LiveWish wish;
  wish.source = folder.path() / "scene.yaml";
  for (const std::string model : {"{finite_elements: p2}", "{reduced: compliance}"}) {
    std::ofstream(wish.source)
        << "schema: palpate/scene/1\nmesh: {file: organ.mesh, unit_m: 1}\n"
           "material: {young_modulus_pa: 5000, poisson_ratio: 0.3, density_kg_m3: 1000}\nclamp: "
           "[{half_space: {normal: [0, 0, 1], share: 0.1}, elastic_pa_per_m: 1.0e6}]\n"
           "load: [{gravity_m_s2: [0, 0, -9.81]}]\nanalysis: static\nmodel: "
        << model << "\n";
    const LiveBodyData body = prepare_live(wish, load_registry());
    ASSERT_TRUE(body.table) << body.no_table;
    EXPECT_EQ(body.start.at("model"), "reduced") << model;
    EXPECT_EQ(body.spring_source.at("method"), "springs.isotropy_patch");
  }
}

TEST(LivePrepare, RefusesWhatIsNoSource) {
  const test::ScratchFolder folder;
  LiveWish wish;
  const Registry registry = load_registry();
  wish.source = folder.path() / "nothing.mesh";
  EXPECT_THROW(prepare_live(wish, registry), InputError);
  wish.source = folder.path();  // a folder without fit.json
  EXPECT_THROW(prepare_live(wish, registry), InputError);
}

/// A table of two vertices of the skin out of three, as docs/reduced.md lays it out.
std::string small_table(const std::string& precision) {
  std::string out =
      "palpate/compliance_table/1\nbody 7\nelements 2\nrefine 0\nreactions 1\npoisson_ratio "
      "0.45\nprecision " +
      precision + "\nmidpoints 0\nrows 3\nskin_vertices 2\nskin_edges 0\nend\n";
  const auto add = [&](const auto& value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (const std::uint32_t v : {1U, 2U, 0U}) add(v);
  for (int k = 0; k < 36; ++k) add(static_cast<float>(k));
  for (int k = 0; k < 54; ++k) add(static_cast<float>(100 + k));
  return out;
}

TEST(LiveTableFile, GivesTheSkinsPart) {
  const LiveTable table = read_live_table(small_table("single"), "t");
  EXPECT_EQ(table.vertices, (std::vector<std::uint32_t>{1, 2}));
  ASSERT_EQ(table.skin.size(), 36u);
  EXPECT_EQ(table.skin.back(), 35.0F);
  ASSERT_EQ(table.field.size(), 36u);
  EXPECT_EQ(table.field.front(), 100.0F);
  EXPECT_EQ(table.field.back(), 135.0F);
}

TEST(LiveTableFile, RefusesOthers) {
  EXPECT_THROW(read_live_table("", "t"), InputError);
  EXPECT_THROW(read_live_table(small_table("double"), "t"), InputError);
  std::string cut = small_table("single");
  cut.resize(cut.size() - 100);
  EXPECT_THROW(read_live_table(cut, "t"), InputError);
}

int status(const std::string& head) {
  return answer_live_request(head, 8123, 10).status;
}

TEST(LiveServer, AnswersItsOwnHostAlone) {
  EXPECT_EQ(status("GET / HTTP/1.1\r\nHost: 127.0.0.1:8123\r\n\r\n"), 200);
  EXPECT_EQ(status("GET / HTTP/1.1\r\nhost: LOCALHOST:8123\r\nOrigin: http://localhost:8123\r\n\r\n"), 200);
  EXPECT_EQ(status("HEAD / HTTP/1.1\r\nHost: 127.0.0.1:8123\r\n\r\n"), 200);
  EXPECT_EQ(status("GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"), 403);
  EXPECT_EQ(status("GET / HTTP/1.1\r\nHost: 127.0.0.1:8124\r\n\r\n"), 403);
  EXPECT_EQ(status("GET / HTTP/1.1\r\nHost: rebound.example:8123\r\n\r\n"), 403);
  EXPECT_EQ(status("GET / HTTP/1.1\r\nHost: 127.0.0.1:8123\r\nOrigin: http://evil.example\r\n\r\n"), 403);
  EXPECT_EQ(status("GET / HTTP/1.1\r\nHost: 127.0.0.1:8123\r\nOrigin: null\r\n\r\n"), 403);
  EXPECT_EQ(status("GET / HTTP/1.1\r\nHost: 127.0.0.1:8123\r\nHost: evil.example\r\n\r\n"), 400);
  EXPECT_EQ(status("GET / HTTP/1.1\r\n\r\n"), 400);
  EXPECT_EQ(status("GET /x HTTP/1.1\r\nHost: 127.0.0.1:8123\r\n\r\n"), 404);
  EXPECT_EQ(status("GET /../etc/passwd HTTP/1.1\r\nHost: 127.0.0.1:8123\r\n\r\n"), 404);
  EXPECT_EQ(status("GET http://127.0.0.1:8123/ HTTP/1.1\r\nHost: 127.0.0.1:8123\r\n\r\n"), 404);
  EXPECT_EQ(status("POST / HTTP/1.1\r\nHost: 127.0.0.1:8123\r\n\r\n"), 405);
  EXPECT_EQ(status("nonsense\r\n\r\n"), 400);
  EXPECT_EQ(status(std::string("\0\0\r\n\r\n", 6)), 400);
  EXPECT_FALSE(answer_live_request("HEAD / HTTP/1.1\r\nHost: 127.0.0.1:8123\r\n\r\n", 8123, 10).sends_page);
}

volatile std::sig_atomic_t stop_serving = 0;

/// All that a server says to these bytes.
std::string talk(std::uint16_t port, const std::string& words) {
  const int fd = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string out;
  if (::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) {
    EXPECT_EQ(::send(fd, words.data(), words.size(), MSG_NOSIGNAL), static_cast<ssize_t>(words.size()));
    std::array<char, 65536> buffer{};
    for (ssize_t got = 0; (got = ::recv(fd, buffer.data(), buffer.size(), 0)) > 0;)
      out.append(buffer.data(), static_cast<std::size_t>(got));
  }
  ::close(fd);
  return out;
}

TEST(LiveServer, ServesItsPageWholeWhileOthersSayNothing) {
  const std::string page(3'000'000, 'p');
  std::promise<std::uint16_t> ready;
  stop_serving = 0;
  std::thread server(
      [&] { serve_live_page(page, 0, stop_serving, [&](std::uint16_t port) { ready.set_value(port); }); });
  const std::uint16_t port = ready.get_future().get();
  const int silent = ::socket(AF_INET, SOCK_STREAM, 0);  // a visitor that never asks
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::connect(silent, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  const std::string host = "Host: 127.0.0.1:" + std::to_string(port) + "\r\n\r\n";
  const std::string answer = talk(port, "GET / HTTP/1.1\r\n" + host);
  EXPECT_THAT(answer, testing::StartsWith("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(answer, testing::EndsWith("\r\n\r\n" + page));
  EXPECT_THAT(talk(port, "GET /other HTTP/1.1\r\n" + host), testing::StartsWith("HTTP/1.1 404"));
  EXPECT_EQ(talk(port, std::string(40000, 'x')).substr(0, 12), "") << "a head without an end";
  EXPECT_THROW(serve_live_page(page, port, stop_serving, [](std::uint16_t) {}), UnavailableError) << "taken";
  stop_serving = 1;
  server.join();
  ::close(silent);
}

/// A server of a small page within bounds, in a thread of its own.
class SmallServer {
 public:
  explicit SmallServer(const LiveBounds& bounds) {
    stop_serving = 0;
    std::promise<std::uint16_t> ready;
    std::future<std::uint16_t> port = ready.get_future();
    looks_ = std::async(std::launch::async, [bounds, told = std::move(ready)]() mutable {
      return serve_live_page(
          "page", 0, stop_serving, [&](std::uint16_t own) { told.set_value(own); }, bounds);
    });
    port_ = port.get();
  }
  /// How often it looked for something to do.
  std::size_t end() {
    stop_serving = 1;
    return looks_.get();
  }
  std::uint16_t port() const { return port_; }

  /// A connection that says nothing yet.
  int connect() const {
    const int fd = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port_);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    return fd;
  }

 private:
  std::future<std::size_t> looks_;
  std::uint16_t port_ = 0;
};

TEST(LiveServer, SleepsWhileItHasItsMostConnectionsAndOthersWait) {
  LiveBounds bounds;
  bounds.connections = 2;
  SmallServer server(bounds);
  const std::array<int, 4> silent{server.connect(), server.connect(), server.connect(), server.connect()};
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  for (const int fd : silent) ::close(fd);
  const std::string host = "Host: 127.0.0.1:" + std::to_string(server.port()) + "\r\n\r\n";
  EXPECT_THAT(talk(server.port(), "GET / HTTP/1.1\r\n" + host), testing::EndsWith("\r\n\r\npage"));
  EXPECT_LT(server.end(), 100U) << "every 200 ms, and when something comes";
}

TEST(LiveServer, ARequestThatComesInDropByDropIsNotWaitedForWithoutEnd) {
  LiveBounds bounds;
  bounds.request = std::chrono::milliseconds(300);
  SmallServer server(bounds);
  const int slow = server.connect();
  bool is_closed = false;
  for (int drop = 0; drop < 2000 && !is_closed; ++drop) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    char answer = 0;
    is_closed = ::send(slow, "x", 1, MSG_NOSIGNAL) < 0 || ::recv(slow, &answer, 1, MSG_DONTWAIT) == 0;
  }
  EXPECT_TRUE(is_closed);
  ::close(slow);
  server.end();
}

}  // namespace
}  // namespace palpate::experiments

#include "reference/door/adapter.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <iostream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "reference/door/contest_files.h"
#include "reference/door/json_file.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

json read_request(const std::filesystem::path& path) {
  json value = read_json_file(path);
  if (!value.is_object()) throw InputError(path.string(), 0, "a JSON object", "something else");
  return value;
}

template <typename T>
T field(const json& object, const char* key, const std::string& where) {
  if (!object.contains(key)) throw InputError(where, 0, std::string("the key \"") + key + "\"", "none");
  try {
    return object.at(key).get<T>();
  } catch (const json::exception&) {
    throw InputError(where, 0, std::string("another type for \"") + key + "\"", object.at(key).dump());
  }
}

void check_tuned(const json& tuned, const std::string& where) {
  const bool numbers = tuned.is_object() && std::all_of(tuned.begin(), tuned.end(), [](const json& value) {
                         return value.is_number() && std::isfinite(value.get<double>());
                       });
  if (!numbers) throw InputError(where, 0, "numbers by name in \"tuned\"", tuned.dump());
}

Request parse_request(const std::filesystem::path& path) {
  const json object = read_request(path);
  const std::string where = path.string();
  if (field<std::string>(object, "schema", where) != "palpate/request/1") {
    throw InputError(where, 0, "schema palpate/request/1", object.at("schema").dump());
  }
  Request request;
  request.contest = field<std::string>(object, "contest", where);
  request.method = field<std::string>(object, "method", where);
  request.input = field<std::string>(object, object.contains("surface_in") ? "surface_in" : "mesh_in", where);
  const ContestFiles files = contest_files(request.contest);
  request.output = field<std::string>(object, files.output_key, where);
  if (files.has_problem) request.problem = field<std::string>(object, "problem_in", where);
  if (object.contains("folder_out")) request.folder = field<std::string>(object, "folder_out", where);
  request.stop = object.value("stop", json::object());
  request.options = object.value("options", json::object());
  request.threads = object.value("threads", 1);
  request.tuned = object.value("tuned", json::object());
  check_tuned(request.tuned, where);
  if (object.contains("keep")) request.keep = field<std::vector<std::string>>(object, "keep", where);
  return request;
}

void write_json(const std::filesystem::path& path, const json& value) {
  // A message may quote bytes of a file that are no UTF-8.
  write_file_atomically(path, value.dump(2, ' ', false, json::error_handler_t::replace) + "\n");
}

int write_failure(const std::filesystem::path& path, const char* status, const std::string& message,
                  int code) {
  std::cerr << message << '\n';
  try {
    write_json(path, {{"schema", "palpate/response/1"}, {"status", status}, {"message", message}});
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 3;
  }
  return code;
}

}  // namespace

int run_adapter(int argc, char** argv, const std::function<Response(const Request&)>& kernel,
                TakesKeep takes_keep) {
  if (argc != 3) {
    std::cerr << "usage: " << (argc > 0 ? argv[0] : "adapter") << " REQUEST.json RESPONSE.json\n";
    return 2;
  }
  const std::filesystem::path response_path = argv[2];
  try {
    const Request request = parse_request(argv[1]);
    if (!request.keep.empty() && takes_keep == TakesKeep::kNo)
      throw InputError("keep", 0, "no region (" + request.method + " keeps none)", request.keep.front());
    const Response response = kernel(request);
    json answer = {{"schema", "palpate/response/1"},
                   {"status", "ok"},
                   {"kernel_s", response.kernel_s},
                   {"report", response.report},
                   {"notes", response.notes}};
    if (!response.tuned.empty()) answer["tuned"] = response.tuned;
    write_json(response_path, answer);
    return 0;
  } catch (const NoRoomError& error) {
    return write_failure(response_path, "error", error.what(), 3);
  } catch (const InputError& error) {
    return write_failure(response_path, "bad_input", error.what(), 2);
  } catch (const std::exception& error) {
    return write_failure(response_path, "error", error.what(), 3);
  }
}

}  // namespace palpate::reference

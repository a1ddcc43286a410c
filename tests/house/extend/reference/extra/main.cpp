// The least adapter: the input is the answer.

#include "core/base/stopwatch.h"
#include "core/mesh/io/medit.h"
#include "reference/door/adapter.h"
#include "reference/door/request_options.h"

namespace {

palpate::reference::Response copy_mesh(const palpate::reference::Request& request) {
  palpate::reference::require_all_taken(request.options);
  const palpate::MeditFile file = palpate::read_medit(request.input);
  const palpate::Stopwatch watch;
  palpate::write_medit(request.output, file.mesh);
  palpate::reference::Response response;
  response.kernel_s = watch.seconds();
  response.report = {{"tets_out", file.mesh.tets.size()}};
  return response;
}

}  // namespace

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, copy_mesh);
}

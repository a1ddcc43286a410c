// The VTK program: organ surfaces out of labelled images and by marching cubes ("mesh") and .vtk / .vtu files
// ("convert").
#include <vtkObject.h>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/io/off.h"
#include "reference/door/adapter.h"
#include "reference/vtk/vtk_tools.h"

namespace palpate::reference {
namespace {

template <typename T>
T option(const Request& request, const char* key) {
  if (!request.options.contains(key) || !request.options[key].is_number()) {
    throw InputError("request", 0, std::string("the option ") + key, "none");
  }
  return request.options[key].get<T>();
}

Response answer(const Request& request) {
  vtkObject::GlobalWarningDisplayOff();
  Response response;
  const Stopwatch watch;
  if (request.contest == "mesh" && request.method == "vtk.organ_surface") {
    const OrganSurface organ =
        extract_organ(request.input, {option<int>(request, "label"), option<double>(request, "smoothing"),
                                      option<double>(request, "spacing")});
    write_off(request.output, organ.surface);
    response.report = {{"voxel_volume", organ.voxel_volume},
                       {"centroid", {organ.centroid.x, organ.centroid.y, organ.centroid.z}}};
  } else if (request.contest == "mesh" && request.method == "vtk.march") {
    write_off(request.output, march_surface(read_off(request.input), option<double>(request, "spacing"),
                                            option<std::uint64_t>(request, "seed")));
  } else if (request.contest == "convert" && request.method == "vtk.read") {
    write_medit(request.output, read_grid(request.input, response.notes));
  } else if (request.contest == "convert" && request.method == "vtk.write") {
    write_vtu(request.output, read_medit(request.input, ReadOrientation::kKeep).mesh);
  } else {
    throw InputError("request", 0,
                     "mesh vtk.organ_surface, mesh vtk.march, convert vtk.read or convert vtk.write",
                     request.contest + " " + request.method);
  }
  response.kernel_s = watch.seconds();
  return response;
}

}  // namespace
}  // namespace palpate::reference

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::answer);
}

// Built with gmsh, GPL: this program is distributed under GPL-3.0-or-later.
#include <gmsh.h>

#include "reference/gmsh/gmsh_tools.h"

namespace palpate::reference {

GmshSession::GmshSession() {
  gmsh::initialize(0, nullptr, false);
  gmsh::option::setNumber("General.Terminal", 0);
  gmsh::option::setNumber("General.NumThreads", 1);
}

GmshSession::~GmshSession() {
  gmsh::finalize();
}

}  // namespace palpate::reference

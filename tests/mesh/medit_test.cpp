#include "core/mesh/medit.h"

#include <gtest/gtest.h>

#pragma once

// Moved: include core/geometry/mesh_data.h. This file goes once nothing includes it.
#include "core/geometry/mesh_data.h"

#pragma once

// Moved: include core/geometry/domain.h. This file goes once nothing includes it.
#include "core/geometry/domain.h"

#pragma once

#include <algorithm>
#include <vector>

namespace pliant {

/// Puts values in ascending order, each once.
template <class T>
void SortUnique(std::vector<T>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace pliant

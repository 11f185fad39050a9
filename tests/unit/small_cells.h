#pragma once

#include <string>

#include "harness/store.h"

namespace occlab {

inline CellKey numbered_key(int number) {
  CellKey key;
  key.add("number", std::to_string(number));
  return key;
}

/// What is stored as fast as anything is.
inline Layers small_layers() {
  Layers layers;
  layers.add("radiance", Image(2, 2, 3, 0.5f));
  return layers;
}

}  // namespace occlab

#pragma once

#include <string>

#include "harness/workbench.h"
#include "renderers/methods/method.h"

namespace occlab::bench {

// The frame of the S3HO study.
inline constexpr int width = 1280;
inline constexpr int height = 720;
inline constexpr float d_max_world = 0.5f;

inline Workbench& gallery() {
  static Workbench bench({.scene = "gallery",
                          .view = "main",
                          .width = width,
                          .height = height,
                          .probe = ProbeSettings{.source = "cathedral", .prefilter_degrees = 8.0f}},
                         "surfaceless");
  return bench;
}

inline ParameterSet study_parameters(const std::string& method, long samples) {
  ParameterSet parameters(find_method(method).parameters);
  parameters.set("samples", samples);
  parameters.set("d_max_world", double(d_max_world));
  return parameters;
}

}  // namespace occlab::bench

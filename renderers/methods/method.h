#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "renderers/methods/parameters.h"
#include "renderers/scene/image_io.h"

namespace occlab {

struct Frame;
struct Representation;

/// One way of shading a view with occlusion. An instance belongs to one graphics context and keeps
/// what it compiled between frames.
class OcclusionMethod {
 public:
  virtual ~OcclusionMethod() = default;

  /// Runs all passes and leaves the result where it is made: this is what is timed, pass by pass,
  /// by frame.clock.
  virtual void render(const Frame& frame, const ParameterSet& parameters) = 0;

  /// render(), then the result: `radiance` L_o = rho E / pi (after the filter, if there is one),
  /// `radiance_unfiltered` where a filter ran, and the method's own layers (MethodInfo::layers).
  /// Pixels that show no surface are 0. Facts worth keeping (negative pixels, path taken) go to
  /// `facts`.
  virtual Layers evaluate(const Frame& frame, const ParameterSet& parameters, Metadata& facts) = 0;
};

struct MethodInfo {
  std::string name;
  std::string title;  ///< as the tables print it
  std::string paper;
  std::vector<Parameter> parameters;
  std::vector<std::string> layers;        ///< beside radiance and radiance_unfiltered
  std::vector<std::string> shaders = {};  ///< fragment shaders: part of a cell's identity
  /// What a screen-space method accumulates, on the CPU; nullptr if it cannot.
  const Representation* representation = nullptr;
  std::function<std::unique_ptr<OcclusionMethod>()> make = {};
  std::string truth = "rtdo";  ///< the method that traces what this one approximates
};

/// Every method, in the order of the tables (registry.cpp).
const std::vector<MethodInfo>& methods();

/// Throws InputError with the accepted names.
const MethodInfo& find_method(const std::string& name);

}  // namespace occlab

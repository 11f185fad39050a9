#include "harness/lobe_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "harness/figures/canvas.h"
#include "harness/figures/figures.h"
#include "harness/figures/lobes.h"
#include "harness/workbench.h"
#include "renderers/methods/lighting.h"
#include "renderers/methods/method.h"
#include "renderers/scene/data_root.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

using nlohmann::json;

constexpr double largest_relighting_error = 0.01;

Sh4 coefficients_at(const Image& image, int x, int y) {
  const std::span<const float> v = image.pixel(x, y);
  return sh4(vec4(v[0], v[1], v[2], v[3]), vec4(v[4], v[5], v[6], v[7]),
             vec4(v[8], v[9], v[10], v[11]), vec4(v[12], v[13], v[14], v[15]));
}

/// c[Lin] in view space, the same at every point [S3HO eq. 4].
ShRgb incoming_light(const Lighting& lighting, float hanning_width, const std::string& where) {
  ShRgb light = lighting.sh_view();
  const vec4 window = sh_hanning_window(hanning_width);
  for (const PunctualLight& punctual : lighting.lights_view()) {
    if (int(punctual.position_and_type.w) != light_directional) {
      throw InputError(where +
                       ": found a light at a point; accepted are suns, whose light comes "
                       "from one direction everywhere");
    }
    const IncidentLight incident = incident_light(punctual, vec3(0.0f));
    const Sh4 lobe = sh_scale_bands(sh_basis(incident.direction), window);
    light.r = sh_add_scaled(light.r, lobe, incident.irradiance.x);
    light.g = sh_add_scaled(light.g, lobe, incident.irradiance.y);
    light.b = sh_add_scaled(light.b, lobe, incident.irradiance.z);
  }
  return light;
}

/// The lights with two of them in each other's places.
std::vector<Light> switched_lights(std::vector<Light> lights, const std::vector<std::string>& names,
                                   const std::string& where) {
  std::vector<Light*> found;
  std::vector<std::string> known;
  for (const Light& light : lights) known.push_back(light.name);
  for (const std::string& name : names) {
    const auto light = std::ranges::find(lights, name, &Light::name);
    if (light == lights.end()) {
      throw InputError(
          fmt::format("{}: unknown light '{}'{}", where, name, accepted_words(name, known)));
    }
    found.push_back(&*light);
  }
  std::swap(found[0]->position_world, found[1]->position_world);
  std::swap(found[0]->direction_world, found[1]->direction_world);
  return lights;
}

glm::vec3 one_albedo(const Scene& scene, const std::string& where) {
  for (const Material& material : scene.materials) {
    if (material.albedo_texture || material.albedo != scene.materials.front().albedo) {
      throw InputError(
          fmt::format("{}: {} has several albedos; accepted is a scene of one, where "
                      "the picture is to be lit again",
                      where, scene.path.string()));
    }
  }
  return scene.materials.front().albedo;
}

/// L_o = rho E / pi where there is a surface.
Image lit(const Image& coefficients, const ShRgb& light, const glm::vec3& albedo,
          const Image& mask) {
  Image radiance(coefficients.width(), coefficients.height(), 3);
  for (int y = 0; y < radiance.height(); ++y) {
    for (int x = 0; x < radiance.width(); ++x) {
      if (mask.at(x, y) <= 0.5f) continue;
      const glm::vec3 E = sh_dot_rgb(light, coefficients_at(coefficients, x, y));
      for (int c = 0; c < 3; ++c) {
        radiance.at(x, y, c) = std::max(0.0f, albedo[c] * E[c] * std::numbers::inv_pi_v<float>);
      }
    }
  }
  return radiance;
}

/// RMS over the surface, in its mean luminances.
double relative_difference(const Image& a, const Image& b, const Image& mask) {
  double squares = 0.0;
  double luminance = 0.0;
  std::size_t pixels = 0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      if (mask.at(x, y) <= 0.5f) continue;
      ++pixels;
      const auto rgb = b.pixel(x, y);
      luminance += 0.2126 * double(rgb[0]) + 0.7152 * double(rgb[1]) + 0.0722 * double(rgb[2]);
      for (int c = 0; c < 3; ++c)
        squares += std::pow(double(a.at(x, y, c)) - double(rgb[c]), 2) / 3.0;
    }
  }
  return std::sqrt(squares / double(pixels)) / (luminance / double(pixels));
}

json vector_json(const glm::vec3& v) { return {v.x, v.y, v.z}; }

std::string vector_text(const glm::vec3& v) {
  return fmt::format("({:.3g}, {:.3g}, {:.3g})", v.x, v.y, v.z);
}

/// What blockers add at one point [S3HO eq. 5].
struct BounceFacts {
  ShRgb transfer;  ///< c[SSGI], three vectors
  glm::vec3 irradiance;
  /// E_ind under light of irradiance 1 from one side, as the camera sees it.
  glm::vec3 from_left;
  glm::vec3 from_right;
};

/// What is drawn and said of one point.
struct PointFacts {
  FigurePoint point;
  Sh4 visibility;
  glm::vec3 irradiance;  ///< with the bounce, where its coefficients are stored
  std::optional<glm::vec3> switched;
  std::optional<BounceFacts> bounce;
};

/// Nine coefficients of red, then of green and of blue: bands 0 to 2.
BounceFacts bounce_at(const Image& image, const FigurePoint& point, const ShRgb& light) {
  const std::span<const float> v = image.pixel(point.x, point.y);
  const auto vector = [&](std::size_t first) {
    const auto* const c = &v[first];
    return sh4(vec4(c[0], c[1], c[2], c[3]), vec4(c[4], c[5], c[6], c[7]), vec4(c[8], 0, 0, 0),
               vec4(0));
  };
  BounceFacts facts{{vector(0), vector(9), vector(18)}, {}, {}, {}};
  const ShRgb& f = facts.transfer;
  facts.irradiance = {sh_dot(light.r, f.r), sh_dot(light.g, f.g), sh_dot(light.b, f.b)};
  facts.from_left = sh_dot_rgb(f, sh_basis(vec3(-1, 0, 0)));
  facts.from_right = sh_dot_rgb(f, sh_basis(vec3(1, 0, 0)));
  return facts;
}

/// c[S3HO] + c[SSGI], for each colour.
ShRgb with_visibility(const PointFacts& facts) {
  ShRgb sum = facts.bounce->transfer;
  sum.r = sh_add_scaled(sum.r, facts.visibility, 1.0f);
  sum.g = sh_add_scaled(sum.g, facts.visibility, 1.0f);
  sum.b = sh_add_scaled(sum.b, facts.visibility, 1.0f);
  return sum;
}

json point_json(const PointFacts& facts, const Image& coefficients) {
  const auto values = coefficients.pixel(facts.point.x, facts.point.y);
  json object = {{"label", facts.point.label},
                 {"pixel", {facts.point.x, facts.point.y}},
                 {"sh_visibility", std::vector<float>(values.begin(), values.begin() + 16)},
                 {"ambient_occlusion", 1.1283791671 * double(values[0])},
                 {"irradiance", vector_json(facts.irradiance)}};
  if (facts.switched) object["irradiance_switched"] = vector_json(*facts.switched);
  if (facts.bounce) {
    object["irradiance_indirect"] = vector_json(facts.bounce->irradiance);
    object["indirect_of_light_from_the_left"] = vector_json(facts.bounce->from_left);
    object["indirect_of_light_from_the_right"] = vector_json(facts.bounce->from_right);
  }
  return object;
}

Image swatch(const Image& displayed, const FigurePoint& point, int width, int height) {
  const auto rgb = displayed.pixel(point.x, point.y);
  return framed(blank(width, height, {rgb[0], rgb[1], rgb[2]}), 1, ink);
}

/// The two pictures, displayed; the second one only where lights are switched.
struct Pictures {
  Image lit;
  Image switched;
};

SpherePanel point_panel(const PointFacts& facts, const Pictures& pictures, double reach, int size) {
  std::vector<Image> swatches = {swatch(pictures.lit, facts.point, size / 3, size / 8)};
  std::string note = fmt::format("E = {}", vector_text(facts.irradiance));
  if (facts.switched) {
    swatches.push_back(swatch(pictures.switched, facts.point, size / 3, size / 8));
    note += fmt::format("; switched {}", vector_text(*facts.switched));
  }
  return {fmt::format("{}: visibility and cosine", facts.point.label),
          stack({draw_lobe(facts.visibility, reach, size), beside(swatches, size / 12)}, size / 24,
                Placement::centre),
          note};
}

/// The bounce at a point on its own, enlarged, and with what is open (Fig. 4).
std::vector<SpherePanel> bounce_panels(const PointFacts& facts, double reach, int size) {
  const BounceFacts& bounce = *facts.bounce;
  const double own = colour_lobe_reach(bounce.transfer);
  const ShRgb sum = with_visibility(facts);
  return {
      {fmt::format("{}: c[SSGI]", facts.point.label), draw_colour_lobe(bounce.transfer, own, size),
       fmt::format("enlarged {:.3g} times; light from the left adds {}, from the right {}",
                   reach / own, vector_text(bounce.from_left), vector_text(bounce.from_right))},
      {fmt::format("{}: c[S3HO] + c[SSGI]", facts.point.label),
       draw_colour_lobe(sum, std::max(reach, colour_lobe_reach(sum)), size),
       fmt::format("indirect E = {}", vector_text(bounce.irradiance))}};
}

std::vector<MarkedPoint> marks(const FigureSettings& settings) {
  std::vector<MarkedPoint> points;
  for (const FigurePoint& point : settings.points) {
    points.push_back({point.label, point.x, point.y});
  }
  return points;
}

/// The light of the scene, the same with two of its lights in each other's places, and what it
/// falls on.
struct SceneLight {
  ShRgb light;
  std::optional<ShRgb> switched;
  glm::vec3 albedo = glm::vec3(0.0f);  ///< only where lights are switched
};

SceneLight scene_light(const FigureSettings& settings, const LobeSource& source,
                       const std::string& where) {
  const BenchSettings& bench = source.experiment.benches[settings.bench];
  const SceneSettings& wanted = bench.scene;
  const Scene scene = load_scene(scene_path(wanted.source));
  const View view{find_camera(scene, wanted.view), wanted.width, wanted.height};
  const ViewSettings looked{.scene = wanted.source,
                            .view = wanted.view,
                            .width = wanted.width,
                            .height = wanted.height,
                            .probe = bench.probe};
  const ProbeSettings probe = probe_of(looked, scene);
  const Environment environment =
      probe.source.empty() ? constant_environment(glm::vec3(0.0f)) : load_environment(probe);
  const float window = source.cell.parameters.real32("hanning_width");
  const auto incoming = [&](const std::vector<Light>& lights) {
    return incoming_light(Lighting(environment, lights, view), window, where);
  };
  SceneLight found{incoming(scene.lights), std::nullopt};
  if (settings.switched.empty()) return found;
  found.albedo = one_albedo(scene, where);
  found.switched = incoming(switched_lights(scene.lights, settings.switched, where));
  return found;
}

/// All that is computed before anything is drawn.
struct Lit {
  SceneLight light;
  std::optional<Image> switched;  ///< radiance
  double relighting_error = 0.0;
};

Lit light_up(const FigureSettings& settings, const LobeSource& source, const std::string& where) {
  Lit result{scene_light(settings, source, where), std::nullopt};
  if (!result.light.switched) return result;
  const Image& coefficients = source.layers.at("sh_visibility");
  const glm::vec3& albedo = result.light.albedo;
  result.relighting_error =
      relative_difference(lit(coefficients, result.light.light, albedo, source.mask),
                          source.layers.at("radiance"), source.mask);
  if (!(result.relighting_error <= largest_relighting_error)) {
    throw InputError(fmt::format(
        "{}: the stored coefficients under the scene's lights differ from the stored picture by "
        "{:.2g} mean luminances (RMS); accepted is {:g}",
        where, result.relighting_error, largest_relighting_error));
  }
  result.switched = lit(coefficients, *result.light.switched, albedo, source.mask);
  return result;
}

std::vector<PointFacts> point_facts(const FigureSettings& settings, const LobeSource& source,
                                    const Lit& light, const std::string& where) {
  std::vector<PointFacts> all;
  for (const FigurePoint& point : settings.points) {
    if (source.mask.at(point.x, point.y) <= 0.5f) {
      throw InputError(fmt::format("{}: point '{}' shows no surface", where, point.label));
    }
    const Sh4 c = coefficients_at(source.layers.at("sh_visibility"), point.x, point.y);
    PointFacts facts{point, c, sh_dot_rgb(light.light.light, c), {}, {}};
    if (const auto& switched = light.light.switched) {
      facts.switched = sh_dot_rgb(*switched, c);
    }
    if (const Image* bounce = source.layers.find("sh_bounce")) {
      facts.bounce = bounce_at(*bounce, point, light.light.light);
      facts.irradiance += facts.bounce->irradiance;
    }
    all.push_back(facts);
  }
  return all;
}

}  // namespace

DrawnLobes draw_lobes(const FigureSettings& settings, const LobeSource& source) {
  const std::string where =
      fmt::format("{}: figure '{}'", source.experiment.file.string(), settings.name);
  const Lit light = light_up(settings, source, where);
  const std::vector<PointFacts> points = point_facts(settings, source, light, where);
  Pictures pictures;
  pictures.lit = tone_map(source.layers.at("radiance"), source.exposure, source.mask);
  if (light.switched) pictures.switched = tone_map(*light.switched, source.exposure, source.mask);

  double reach = 0.0;
  for (const PointFacts& facts : points) reach = std::max(reach, lobe_reach(facts.visibility));
  const double white = light_reach(light.light.light);
  const int size = std::clamp(source.mask.width() / 5, 120, 360);
  LobeFigure figure;
  figure.title = settings.title;
  const std::string title = find_method(source.cell.method).title;
  figure.panels.push_back({light.switched ? title : title + ", lit as the scene is", source.colour,
                           draw_points(pictures.lit, marks(settings))});
  const auto add_point = [&](const PointFacts& facts) {
    figure.spheres.push_back(point_panel(facts, pictures, reach, size));
    if (!facts.bounce) return;
    std::ranges::move(bounce_panels(facts, reach, size), std::back_inserter(figure.spheres));
  };
  add_point(points.front());
  figure.spheres.push_back(
      {"incoming light", draw_light_sphere(light.light.light, white, size), ""});
  if (light.switched) {
    figure.panels.front().label += ", lights as they are";
    figure.panels.push_back({title + ", lights switched", source.colour,
                             draw_points(pictures.switched, marks(settings))});
    figure.spheres.push_back(
        {"switched", draw_light_sphere(*light.light.switched, white, size), ""});
  }
  if (points.size() > 1) add_point(points[1]);
  figure.caption = fmt::format(
      "{}{}Lobes: distance from the middle is |c[S3HO] . y(d)|, red where positive, blue where "
      "negative; the grey circle is {:.3g}. {}Spheres: c[Lin] . y(d), as seen from the camera. "
      "Colour "
      "fields: the picture at the point{}. E: irradiance (R, G, B).{}",
      settings.caption, settings.caption.empty() ? "" : "\n", reach,
      points.front().bounce ? "Of the bounce, three vectors: their own colour. " : "",
      light.switched ? ", and with the lights switched" : "",
      light.switched ? fmt::format(" The switched picture is the stored coefficients under the "
                                   "other light; under the lights as they are these differ from "
                                   "the picture by {:.2g} mean luminances (RMS).",
                                   light.relighting_error)
                     : "");
  DrawnLobes result{lobe_figure(figure), json::object()};
  result.numbers = {{"figure", settings.name}, {"points", json::array()}, {"lobe_circle", reach}};
  for (const PointFacts& facts : points) {
    result.numbers["points"].push_back(point_json(facts, source.layers.at("sh_visibility")));
  }
  if (light.switched) {
    result.numbers["switched"] = settings.switched;
    result.numbers["relighting_rms_in_mean_luminances"] = light.relighting_error;
  }
  return result;
}

}  // namespace occlab

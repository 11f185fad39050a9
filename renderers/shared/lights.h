// Punctual lights [KHR_lights_punctual].
#pragma once
#include "renderers/shared/glsl.h"

SHARED_BEGIN

// The order of LightType.
const int light_point = 0;
const int light_directional = 1;
const int light_spot = 2;

// Laid out for std140: vec4s only, one space for all (world or view).
struct PunctualLight {
  vec4 position_and_type;    // xyz: point and spot
  vec4 direction_and_outer;  // xyz: where the light travels; w: cosine of the outer cone angle
  vec4 intensity_and_inner;  // rgb: I (W/sr) or, directional, E_perp (W/m^2); w: cos of the inner
};

// A light as it arrives at a point.
struct IncidentLight {
  vec3 direction;   // unit, toward the light
  vec3 irradiance;  // E_perp, on a surface that faces the light
  float distance;   // to the light; huge for a directional one
};

SHARED IncidentLight incident_from(vec3 direction, vec3 irradiance, float d) {
  IncidentLight incident;
  incident.direction = direction;
  incident.irradiance = irradiance;
  incident.distance = d;
  return incident;
}

SHARED IncidentLight incident_light(PunctualLight light, vec3 p) {
  const vec3 travel = vec3(light.direction_and_outer);
  const vec3 intensity = vec3(light.intensity_and_inner);
  const int type = int(light.position_and_type.w);
  if (type == light_directional) return incident_from(-travel, intensity, 1e30f);
  const vec3 to_light = vec3(light.position_and_type) - p;
  const float squared = max(dot(to_light, to_light), 1e-12f);
  const float d = sqrt(squared);
  const vec3 direction = to_light / d;
  float falloff = 1.0f;
  if (type == light_spot) {
    // The extension's recommended cone: the square of a ramp in the cosine.
    const float outer = light.direction_and_outer.w;
    const float inner = light.intensity_and_inner.w;
    const float ramp =
        clamp((dot(-direction, travel) - outer) / max(inner - outer, 1e-4f), 0.0f, 1.0f);
    falloff = ramp * ramp;
  }
  return incident_from(direction, intensity * (falloff / squared), d);
}

SHARED_END

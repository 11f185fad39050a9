// A surface's colour at a point: its material's factors and texture. Passes with gbuffer.vert.
#pragma once
#include "renderers/shared/surface_texture.h"

in vec2 texture_uv;

uniform vec3 material_albedo;
uniform float material_alpha;
#ifdef TEXTURED
uniform int wrap_u;
uniform int wrap_v;
uniform int nearest_texel;
layout(binding = 0) uniform sampler2D albedo_texture;
#endif
#ifdef MASKED
uniform float alpha_cutoff;
#endif

// rgb: reflectance; a: alpha.
vec4 surface_color() {
  vec4 factor = vec4(material_albedo, material_alpha);
#ifdef TEXTURED
  TextureFootprint at = texture_footprint(texture_uv, textureSize(albedo_texture, 0),
                                          ivec2(wrap_u, wrap_v), nearest_texel != 0);
  vec4 top = mix(texelFetch(albedo_texture, at.low, 0),
                 texelFetch(albedo_texture, ivec2(at.high.x, at.low.y), 0), at.share.x);
  vec4 bottom = mix(texelFetch(albedo_texture, ivec2(at.low.x, at.high.y), 0),
                    texelFetch(albedo_texture, at.high, 0), at.share.x);
  return factor * mix(top, bottom, at.share.y);
#else
  return factor;
#endif
}

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "renderers/scene/gltf_parts.h"
#include "renderers/scene/image_headers.h"
#include "renderers/scene/image_size.h"
#include "renderers/scene/limits.h"
#include "renderers/shared/surface_texture.h"

namespace occlab {
namespace {

/// IEC 61966-2-1.
float linear_from_srgb(float value) {
  return value <= 0.04045f ? value / 12.92f : std::pow((value + 0.055f) / 1.055f, 2.4f);
}

std::string image_format(const JsonValue& place, std::span<const std::byte> bytes) {
  const auto starts_with = [&](std::string_view magic) {
    return bytes.size() >= magic.size() &&
           std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
  };
  if (starts_with("\x89PNG\r\n\x1a\n")) return "png";
  if (starts_with("\xff\xd8\xff")) return "jpeg";
  place.fail("not a PNG or JPEG image; only these are accepted");
}

/// A base colour texture as linear RGB, and alpha if the file has one. glTF 2.0 section 3.9.2:
/// colour textures are sRGB. Grey ones and those of 16 bits are read as they are meant.
/// `textures_bytes` is what the textures before it take in memory, and then also this one.
Image decode_color_texture(const JsonValue& place, std::span<const std::byte> bytes,
                           std::uint64_t& textures_bytes) {
  OIIO::Filesystem::IOMemReader reader(const_cast<std::byte*>(bytes.data()), bytes.size());
  OIIO::Filesystem::IOProxy* proxy = &reader;
  OIIO::ImageSpec config;
  config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
  config.attribute("oiio:UnassociatedAlpha", 1);  // alpha must not darken the colour
  const std::string format = image_format(place, bytes);
  if (format == "png") check_png_chunks(bytes_in_memory(bytes), place.where());
  const auto input = OIIO::ImageInput::create(format);
  OIIO::ImageSpec opened;
  if (!input) place.fail(fmt::format("the image is unreadable: {}", OIIO::geterror()));
  const auto fail = [&] {
    const std::string reason = input->geterror();
    place.fail("the image is damaged: " + reason);
  };
  if (!input->open(format, opened, config)) fail();
  const OIIO::ImageSpec& spec = input->spec();
  require_image_size(spec, bytes.size(), Limit::texture_pixels, place.where());
  const int channels = spec.nchannels;
  const bool has_alpha = channels == 2 || channels == 4;
  const int kept = has_alpha ? 4 : 3;
  textures_bytes =
      saturating_add(textures_bytes, spec.image_pixels() * std::uint64_t(kept) * sizeof(float));
  require_within(Limit::texture_bytes, textures_bytes, "bytes of textures in memory",
                 place.where());
  std::vector<float> values(std::size_t(spec.width) * std::size_t(spec.height) *
                            std::size_t(channels));
  if (!input->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, values.data())) fail();
  Image image(spec.width, spec.height, kept);
  for (std::size_t p = 0; p < image.pixel_count(); ++p) {
    const float* from = &values[p * std::size_t(channels)];
    float* to = &image.values()[p * std::size_t(kept)];
    for (int c = 0; c < 3; ++c) {
      to[c] = linear_from_srgb(from[channels >= 3 ? c : 0]);  // grey, or grey and alpha
    }
    if (has_alpha) to[3] = from[channels - 1];
  }
  return image;
}

int wrap_mode(const JsonValue& sampler, const char* key) {
  constexpr std::uint64_t repeat = 10497;
  constexpr std::uint64_t mirrored_repeat = 33648;
  constexpr std::uint64_t clamp_to_edge = 33071;
  const std::uint64_t found = sampler.unsigned_or(key, repeat);
  if (found == repeat) return wrap_repeat;
  if (found == mirrored_repeat) return wrap_mirrored_repeat;
  if (found == clamp_to_edge) return wrap_clamp_to_edge;
  sampler.at(key).fail(
      fmt::format("found {}; accepted: {} (repeat), {} (mirrored repeat), {} (clamp to edge)",
                  found, repeat, mirrored_repeat, clamp_to_edge));
}

/// Of glTF's filters only that for magnification is used: no smaller levels are read.
TextureSampling texture_sampling(const JsonValue& sampler) {
  constexpr std::uint64_t nearest = 9728;
  constexpr std::uint64_t linear = 9729;
  const std::uint64_t filter = sampler.unsigned_or("magFilter", linear);
  if (filter != nearest && filter != linear) {
    sampler.at("magFilter")
        .fail(
            fmt::format("found {}; accepted: {} (nearest), {} (linear)", filter, nearest, linear));
  }
  return {wrap_mode(sampler, "wrapS"), wrap_mode(sampler, "wrapT"), filter == nearest};
}

/// KHR_texture_transform: uv' = T R S uv, where R turns so that rotation pi/2 with offset (0, 1)
/// and scale 1/2 covers the image's lower left quadrant, the extension's own example.
glm::mat3 uv_transform(const JsonValue& extension) {
  std::vector<double> offset{0.0, 0.0};
  std::vector<double> scale{1.0, 1.0};
  if (const auto found = extension.find("offset")) offset = found->numbers(2);
  if (const auto found = extension.find("scale")) scale = found->numbers(2);
  const double angle = extension.number_or("rotation", 0.0);
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {glm::vec3(c * scale[0], -s * scale[0], 0.0), glm::vec3(s * scale[1], c * scale[1], 0.0),
          glm::vec3(offset[0], offset[1], 1.0)};
}

}  // namespace

int MaterialTable::material(const std::optional<JsonValue>& primitive_material) {
  if (!primitive_material) {
    if (!default_material_) {
      default_material_ = int(scene_->materials.size());
      Material surface;
      surface.name = "default";
      scene_->materials.push_back(surface);
      uv_sources_.emplace_back();
      scene_->warnings.push_back(
          fmt::format("surfaces without a material get Blender's default surface, albedo {}",
                      surface.albedo.x));
    }
    return *default_material_;
  }
  const auto& list = file_->list("materials");
  const std::size_t index = primitive_material->index(list.size(), "materials");
  const auto [entry, is_new] = loaded_materials_.try_emplace(index, int(scene_->materials.size()));
  if (is_new) read(list[index]);
  return entry->second;
}

void MaterialTable::read(const JsonValue& json) {
  Material material;
  material.name = json.text_or("name", fmt::format("material {}", uv_sources_.size()));
  material.albedo = glm::vec3(1.0f);
  UvSource uv;
  const auto warn = [&](const std::string& text) {
    scene_->warnings.push_back(fmt::format("material '{}': {}", material.name, text));
  };

  double metallic = 1.0;  // the specification's default
  if (const auto pbr = json.find("pbrMetallicRoughness")) {
    metallic = pbr->number_or("metallicFactor", 1.0);
    if (const auto factor = pbr->find("baseColorFactor")) {
      const std::vector<double> rgba = factor->numbers(4);
      if (std::ranges::any_of(rgba, [](double v) { return !(v >= 0.0 && v <= 1.0); })) {
        factor->fail("found a value outside 0 to 1");
      }
      material.albedo = glm::vec3(rgba[0], rgba[1], rgba[2]);
      material.alpha = float(rgba[3]);
    }
    if (const auto info = pbr->find("baseColorTexture")) {
      const std::size_t gltf_texture =
          info->at("index").index(file_->list("textures").size(), "textures");
      material.albedo_texture = texture(gltf_texture, material);
      std::uint64_t set = info->unsigned_or("texCoord", 0);
      const auto extensions = info->find("extensions");
      if (const auto transform =
              extensions ? extensions->find("KHR_texture_transform") : std::nullopt) {
        uv.transform = uv_transform(*transform);
        set = transform->unsigned_or("texCoord", set);
      }
      uv.attribute = fmt::format("TEXCOORD_{}", set);
    }
  }
  if (metallic > 0.0) {
    warn(fmt::format("metallic {:g} is not used; every surface is Lambertian", metallic));
  }
  const std::string alpha_mode = json.text_or("alphaMode", "OPAQUE");
  if (alpha_mode == "MASK") {
    material.alpha_cutoff = json.real_or("alphaCutoff", 0.5f);
    if (*material.alpha_cutoff < 0.0f) {
      json.at("alphaCutoff")
          .fail(fmt::format("found {}; accepted: at least 0", *material.alpha_cutoff));
    }
  } else if (alpha_mode == "BLEND") {
    warn("alphaMode BLEND is not used; the surface is opaque");
  } else if (alpha_mode != "OPAQUE") {
    json.at("alphaMode").fail(fmt::format("found '{}'; accepted: OPAQUE, MASK, BLEND", alpha_mode));
  }
  if (const auto emissive = json.find("emissiveFactor")) {
    const std::vector<double> rgb = emissive->numbers(3);
    if (std::ranges::any_of(rgb, [](double v) { return v > 0.0; })) {
      warn("emission is not used; the surface does not light others");
    }
  }
  if (json.find("normalTexture")) warn("the normal texture is not used");
  scene_->materials.push_back(std::move(material));
  uv_sources_.push_back(std::move(uv));
}

int MaterialTable::texture(std::size_t gltf_texture, Material& material) {
  const JsonValue& json = file_->list("textures")[gltf_texture];
  if (const auto sampler = json.find("sampler")) {
    const auto& samplers = file_->list("samplers");
    material.sampling = texture_sampling(samplers[sampler->index(samplers.size(), "samplers")]);
  }
  if (!json.find("source")) {
    json.fail(
        fmt::format("material '{}': has no source; accepted: PNG and JPEG images, not those "
                    "of extensions",
                    material.name));
  }
  const auto& images = file_->list("images");
  const std::size_t image_index = json.at("source").index(images.size(), "images");
  const auto [entry, is_new] =
      loaded_images_.try_emplace(image_index, int(scene_->textures.size()));
  if (is_new) {
    const JsonValue& image = images[image_index];
    if (const auto uri = image.find("uri")) {
      scene_->textures.push_back(
          decode_color_texture(image, file_->read_uri(*uri), textures_bytes_));
    } else {
      const std::size_t view =
          image.at("bufferView").index(file_->list("bufferViews").size(), "bufferViews");
      scene_->textures.push_back(
          decode_color_texture(image, file_->view_bytes(view), textures_bytes_));
    }
  }
  return entry->second;
}

}  // namespace occlab

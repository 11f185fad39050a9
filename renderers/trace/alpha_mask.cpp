#include "renderers/trace/alpha_mask.h"

#include <map>

#include "renderers/scene/surface_texture.h"

namespace occlab {
namespace {

/// Takes back the hits that fall into holes, so that the ray goes on.
void drop_hits_in_holes(const RTCFilterFunctionNArguments* arguments) {
  const auto& mask = *static_cast<const AlphaMask*>(arguments->geometryUserPtr);
  for (unsigned i = 0; i < arguments->N; ++i) {
    if (arguments->valid[i] != -1) continue;
    const unsigned triangle = RTCHitN_primID(arguments->hit, arguments->N, i);
    const float second = RTCHitN_u(arguments->hit, arguments->N, i);
    const float third = RTCHitN_v(arguments->hit, arguments->N, i);
    if (!mask.surface_at(triangle, second, third)) arguments->valid[i] = 0;
  }
}

std::shared_ptr<const Image> alpha_channel(const Image& texture) {
  if (texture.channels() < 4) return nullptr;
  auto alpha = std::make_shared<Image>(texture.width(), texture.height(), 1);
  for (std::size_t p = 0; p < texture.pixel_count(); ++p) {
    alpha->values()[p] = texture.values()[4 * p + 3];
  }
  return alpha;
}

}  // namespace

AlphaMask::AlphaMask(const Mesh& mesh, const Material& material, std::shared_ptr<const Image> alpha)
    : alpha_(std::move(alpha)),
      sampling_(material.sampling),
      factor_(material.alpha),
      cutoff_(*material.alpha_cutoff) {
  if (!alpha_) return;
  corner_uvs_.reserve(mesh.indices.size() / 3);
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    corner_uvs_.push_back(
        {mesh.uvs[mesh.indices[i]], mesh.uvs[mesh.indices[i + 1]], mesh.uvs[mesh.indices[i + 2]]});
  }
}

void AlphaMask::attach_to(RTCGeometry geometry) const {
  rtcSetGeometryUserData(geometry, const_cast<AlphaMask*>(this));
  rtcSetGeometryIntersectFilterFunction(geometry, drop_hits_in_holes);
  rtcSetGeometryOccludedFilterFunction(geometry, drop_hits_in_holes);
}

bool AlphaMask::surface_at(std::size_t triangle, float second, float third) const {
  if (!alpha_) return factor_ >= cutoff_;
  const std::array<glm::vec2, 3>& uvs = corner_uvs_[triangle];
  const glm::vec2 uv = (1.0f - second - third) * uvs[0] + second * uvs[1] + third * uvs[2];
  return factor_ * texture_at(*alpha_, sampling_, uv).x >= cutoff_;
}

std::vector<std::unique_ptr<const AlphaMask>> alpha_masks(const Scene& scene) {
  std::map<int, std::shared_ptr<const Image>> channels;  // by texture
  std::vector<std::unique_ptr<const AlphaMask>> masks(scene.meshes.size());
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const Material& material = scene.materials[std::size_t(scene.meshes[i].material)];
    if (!material.alpha_cutoff) continue;
    std::shared_ptr<const Image> alpha;
    if (material.albedo_texture) {
      const auto [entry, is_new] = channels.try_emplace(*material.albedo_texture);
      if (is_new) {
        entry->second = alpha_channel(scene.textures[std::size_t(*material.albedo_texture)]);
      }
      alpha = entry->second;
    }
    masks[i] = std::make_unique<const AlphaMask>(scene.meshes[i], material, std::move(alpha));
  }
  return masks;
}

}  // namespace occlab

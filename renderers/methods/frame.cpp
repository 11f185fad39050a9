#include "renderers/methods/frame.h"

namespace occlab {

const GBuffer& Frame::gbuffer(GBufferBits bits) const {
  auto& gbuffer = made.gbuffers[std::size_t(bits)];
  if (!gbuffer) gbuffer.emplace(render_gbuffer(scene, gpu_scene, view, bits, programs));
  return *gbuffer;
}

const GBufferImages& Frame::surface(GBufferBits bits) const {
  auto& surface = made.surfaces[std::size_t(bits)];
  if (!surface) surface.emplace(download(gbuffer(bits)));
  return *surface;
}

const TracedScene& Frame::traced() const {
  if (!made.traced) made.traced.emplace(scene);
  return *made.traced;
}

}  // namespace occlab

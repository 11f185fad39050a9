#include "renderers/methods/frame.h"

#include <algorithm>

namespace occlab {
namespace {

Frame::MadeHidden& made_hidden(const Frame& frame, const HiddenSettings& settings) {
  std::list<Frame::MadeHidden>& made = frame.made.hidden;
  const auto known = std::ranges::find_if(
      made, [&](const Frame::MadeHidden& one) { return one.surfaces.settings() == settings; });
  if (known != made.end()) {
    made.splice(made.begin(), made, known);
    return made.front();
  }
  if (made.size() == Frame::most_hidden) made.pop_back();
  const GBuffer& first = frame.gbuffer(settings.bits);
  made.push_front({HiddenSurfaces(frame.scene, frame.view, first, settings), std::nullopt});
  made.front().surfaces.draw(frame.scene, frame.gpu_scene, frame.view, first, frame.programs);
  return made.front();
}

}  // namespace

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

const HiddenSurfaces& Frame::hidden(const HiddenSettings& settings) const {
  return made_hidden(*this, settings).surfaces;
}

const HiddenImages& Frame::hidden_images(const HiddenSettings& settings) const {
  MadeHidden& hidden = made_hidden(*this, settings);
  if (!hidden.images) hidden.images.emplace(download(hidden.surfaces));
  return *hidden.images;
}

}  // namespace occlab

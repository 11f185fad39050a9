#include "renderers/trace/traced_scene.h"

#include <fmt/format.h>

#include <glm/gtc/type_ptr.hpp>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

void check_device(RTCDevice device, const char* what) {
  const RTCError error = rtcGetDeviceError(device);
  if (error != RTC_ERROR_NONE) {
    throw DeviceError(fmt::format("Embree failed in {}: error {}", what, int(error)));
  }
}

/// Takes its own copies, so the Scene may go. `mask`: null if the mesh has no holes.
void attach_triangles(RTCDevice device, RTCScene scene, const Mesh& mesh, const AlphaMask* mask,
                      const glm::mat4& scene_from_object) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.positions.size()));
  auto* indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(std::uint32_t), mesh.indices.size() / 3));
  if (!vertices || !indices) throw DeviceError("Embree has no memory for the scene's triangles");
  for (const glm::vec3& position : mesh.positions) {
    const glm::vec3 p(scene_from_object * glm::vec4(position, 1.0f));
    for (int axis = 0; axis < 3; ++axis) *vertices++ = p[axis];
  }
  std::copy(mesh.indices.begin(), mesh.indices.end(), indices);
  if (mask) mask->attach_to(geometry);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

void attach_instance(RTCDevice device, RTCScene scene, RTCScene prototype,
                     const glm::mat4& world_from_object) {
  RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(instance, prototype);
  rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR,
                          glm::value_ptr(world_from_object));
  rtcCommitGeometry(instance);
  rtcAttachGeometry(scene, instance);
  rtcReleaseGeometry(instance);
}

RTCDevice new_device() {
  const RTCDevice device = rtcNewDevice(nullptr);
  if (!device) {
    throw DeviceError(
        fmt::format("Embree cannot start: error {}", int(rtcGetDeviceError(nullptr))));
  }
  return device;
}

}  // namespace

TracedScene::TracedScene(const Scene& scene)
    : masks_(alpha_masks(scene)),
      device_(new_device()),
      bounding_radius_(scene.bounding_radius()),
      tree_(device_.get(), scene) {
  scene_.reset(rtcNewScene(device_.get()));
  rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_HIGH);

  std::vector<int> uses(scene.meshes.size(), 0);
  for (const Instance& instance : scene.instances) ++uses[std::size_t(instance.mesh)];

  std::vector<std::unique_ptr<RTCSceneTy, Release>> prototypes(scene.meshes.size());
  for (const Instance& instance : scene.instances) {
    const auto index = std::size_t(instance.mesh);
    const Mesh& mesh = scene.meshes[index];
    if (uses[index] == 1) {
      attach_triangles(device_.get(), scene_.get(), mesh, masks_[index].get(),
                       instance.world_from_object);
      continue;
    }
    if (!prototypes[index]) {
      prototypes[index].reset(rtcNewScene(device_.get()));
      rtcSetSceneBuildQuality(prototypes[index].get(), RTC_BUILD_QUALITY_HIGH);
      attach_triangles(device_.get(), prototypes[index].get(), mesh, masks_[index].get(),
                       glm::mat4(1.0f));
      rtcCommitScene(prototypes[index].get());
    }
    attach_instance(device_.get(), scene_.get(), prototypes[index].get(),
                    instance.world_from_object);
  }
  rtcCommitScene(scene_.get());
  check_device(device_.get(), "building the scene");
}

}  // namespace occlab

#include "renderers/gl/context.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <fmt/format.h>

#include <charconv>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr const char* surfaceless = "surfaceless";

/// OpenGL 4.5 core. With `tells_resets` a context that the device had to reset says so instead of
/// drawing nothing (check_gl); not every driver offers that.
EGLContext create_context(EGLDisplay display, bool tells_resets) {
  std::vector<EGLint> attributes = {
      EGL_CONTEXT_MAJOR_VERSION,       4,
      EGL_CONTEXT_MINOR_VERSION,       5,
      EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT};
  if (tells_resets) {
    attributes.insert(attributes.end(),
                      {EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY, EGL_LOSE_CONTEXT_ON_RESET});
  }
  attributes.push_back(EGL_NONE);
  return eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
}

std::vector<EGLDeviceEXT> egl_devices() {
  if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration") &&
      !epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_base")) {
    return {};
  }
  EGLint count = 0;
  if (!eglQueryDevicesEXT(0, nullptr, &count)) return {};
  std::vector<EGLDeviceEXT> devices(std::size_t(count), nullptr);
  if (!eglQueryDevicesEXT(count, devices.data(), &count)) return {};
  return devices;
}

EGLDisplay surfaceless_display() {
  if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")) {
    return EGL_NO_DISPLAY;
  }
  return eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
}

bool is_software(const std::string& renderer) {
  for (const char* name : {"llvmpipe", "softpipe", "SWR", "swrast", "SwiftShader"}) {
    if (renderer.find(name) != std::string::npos) return true;
  }
  return false;
}

std::string gl_text(GLenum name) { return reinterpret_cast<const char*>(glGetString(name)); }

EGLDisplay display_of(const std::string& device) {
  if (device == surfaceless) return surfaceless_display();
  const auto devices = egl_devices();
  std::size_t index = 0;
  const auto [rest, error] = std::from_chars(device.data(), device.data() + device.size(), index);
  if (error != std::errc() || rest != device.data() + device.size() || index >= devices.size()) {
    throw InputError(fmt::format(
        "--device {}: unknown; accepted: auto, surfaceless, or an index below {} (see 'occlab list "
        "devices')",
        device, devices.size()));
  }
  return eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[index], nullptr);
}

const char* reset_reason(GLenum status) {
  if (status == GL_GUILTY_CONTEXT_RESET) return "by what this program drew";
  if (status == GL_INNOCENT_CONTEXT_RESET) return "by another program";
  return "the driver does not say why";
}

std::string choose_device(const std::string& device) {
  if (device != "auto") return device;
  for (const DeviceInfo& info : list_devices()) {
    if (!info.software) return info.id;
  }
  return surfaceless;
}

}  // namespace

Context::Context(const std::string& device) {
  info_.id = choose_device(device);
  const auto fail = [&](const char* what) {
    if (display_) eglTerminate(display_);
    throw DeviceError(
        fmt::format("device {}: {} (EGL error 0x{:x})", info_.id, what, eglGetError()));
  };
  display_ = display_of(info_.id);
  if (display_ == EGL_NO_DISPLAY)
    fail("EGL has no such display; is Mesa's libegl-mesa0 installed?");
  if (!eglInitialize(display_, nullptr, nullptr)) {
    display_ = nullptr;
    fail("EGL cannot be initialised; is Mesa's libegl-mesa0 installed?");
  }
  if (!eglBindAPI(EGL_OPENGL_API)) fail("EGL offers no desktop OpenGL");
  context_ = create_context(display_, true);
  if (context_ == EGL_NO_CONTEXT) context_ = create_context(display_, false);
  if (context_ == EGL_NO_CONTEXT) fail("no OpenGL 4.5 core context");
  if (!eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_)) {
    fail("the context cannot be made current without a surface");
  }
  info_.vendor = gl_text(GL_VENDOR);
  info_.renderer = gl_text(GL_RENDERER);
  info_.version = gl_text(GL_VERSION);
  info_.software = is_software(info_.renderer);
}

Context::~Context() {
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
  eglTerminate(display_);
}

std::vector<DeviceInfo> list_devices() {
  std::vector<std::string> ids = {surfaceless};
  for (std::size_t i = 0; i < egl_devices().size(); ++i) ids.push_back(std::to_string(i));
  std::vector<DeviceInfo> usable;
  for (const std::string& id : ids) {
    try {
      usable.push_back(Context(id).info());
    } catch (const DeviceError&) {
      // A device that gives no context is not usable; the list is of those that are.
    }
  }
  return usable;
}

void check_gl(const char* what) {
  if (const GLenum status = glGetGraphicsResetStatus(); status != GL_NO_ERROR) {
    throw DeviceError(fmt::format(
        "the graphics context was lost in {} ({}); finished cells are kept, the same command goes "
        "on from there",
        what, reset_reason(status)));
  }
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR) return;
  throw DeviceError(fmt::format("OpenGL failed in {}: error 0x{:04x}{}", what, error,
                                error == GL_OUT_OF_MEMORY ? " (out of memory)" : ""));
}

}  // namespace occlab

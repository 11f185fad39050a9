#pragma once

#include <string>
#include <vector>

namespace occlab {

/// What renders: one entry of `occlab list devices`.
struct DeviceInfo {
  std::string id;  ///< what --device takes: "surfaceless", or the index of an EGL device
  std::string vendor;
  std::string renderer;
  std::string version;    ///< of OpenGL, with the driver's
  bool software = false;  ///< a software rasteriser: its times say nothing about a GPU
};

/// An OpenGL 4.5 core context without a window, current on the thread that made it.
class Context {
 public:
  /// `device`: "auto" (the first hardware EGL device, else surfaceless), "surfaceless", or an index
  /// of list_devices(). Throws InputError for an unknown device, DeviceError if EGL or OpenGL 4.5
  /// is not to be had.
  explicit Context(const std::string& device);
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  const DeviceInfo& info() const { return info_; }

 private:
  void* display_ = nullptr;
  void* context_ = nullptr;
  DeviceInfo info_;
};

/// The devices on which a context could be made; empty if there is none.
std::vector<DeviceInfo> list_devices();

/// Throws DeviceError naming `what` if OpenGL has recorded an error or the device has reset the
/// context, after which nothing that was drawn can be believed.
void check_gl(const char* what);

}  // namespace occlab

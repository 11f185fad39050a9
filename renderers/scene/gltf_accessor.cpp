// Accessors: glTF 2.0 specification, section 3.6. Every offset is checked against its buffer.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "renderers/scene/gltf_file.h"

namespace occlab {
namespace {

enum ComponentType : std::uint64_t {
  type_i8 = 5120,
  type_u8 = 5121,
  type_i16 = 5122,
  type_u16 = 5123,
  type_u32 = 5125,
  type_f32 = 5126,
};

/// An accessor without a buffer view reads no bytes that would bound its size.
constexpr std::uint64_t max_virtual_elements = 1u << 22;

std::size_t component_size(const JsonValue& place, std::uint64_t type) {
  switch (type) {
    case type_i8:
    case type_u8:
      return 1;
    case type_i16:
    case type_u16:
      return 2;
    case type_u32:
    case type_f32:
      return 4;
    default:
      place.fail(
          fmt::format("componentType {}; accepted: 5120, 5121, 5122, 5123, 5125 and 5126", type));
  }
}

template <typename T>
T load(const std::byte* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

template <typename T>
float load_float(const std::byte* bytes, bool normalized) {
  const float value = float(load<T>(bytes));
  if (!normalized) return value;
  return std::max(value / float(std::numeric_limits<T>::max()), -1.0f);
}

float component_as_float(const std::byte* bytes, std::uint64_t type, bool normalized) {
  switch (type) {
    case type_i8:
      return load_float<std::int8_t>(bytes, normalized);
    case type_u8:
      return load_float<std::uint8_t>(bytes, normalized);
    case type_i16:
      return load_float<std::int16_t>(bytes, normalized);
    case type_u16:
      return load_float<std::uint16_t>(bytes, normalized);
    case type_u32:
      return float(load<std::uint32_t>(bytes));
    default:
      return load<float>(bytes);
  }
}

std::uint32_t component_as_index(const std::byte* bytes, std::uint64_t type) {
  if (type == type_u8) return load<std::uint8_t>(bytes);
  if (type == type_u16) return load<std::uint16_t>(bytes);
  return load<std::uint32_t>(bytes);
}

/// `count` elements of `element_size` bytes, `stride` bytes apart, all inside the buffer.
struct Elements {
  const std::byte* first = nullptr;
  std::size_t stride = 0;
  std::size_t count = 0;
};

Elements locate(const GltfFile& file, const JsonValue& place, std::uint64_t count,
                std::size_t element_size) {
  const auto& views = file.list("bufferViews");
  const std::size_t view_index = place.at("bufferView").index(views.size(), "bufferViews");
  const std::span<const std::byte> bytes = file.view_bytes(view_index);
  const std::uint64_t stride = views[view_index].unsigned_or("byteStride", element_size);
  if (stride < element_size || stride > 252) {
    views[view_index].fail(fmt::format("byteStride {}; accepted: {} (the element's size) to 252",
                                       stride, element_size));
  }
  const std::uint64_t offset = place.unsigned_or("byteOffset", 0);
  const bool fits = offset <= bytes.size() && element_size <= bytes.size() - offset &&
                    count - 1 <= (bytes.size() - offset - element_size) / stride;
  if (!fits) {
    place.fail(
        fmt::format("{} elements of {} bytes, {} apart from byte {} on, pass the end of "
                    "bufferViews[{}], which has {} bytes",
                    count, element_size, stride, offset, view_index, bytes.size()));
  }
  return {bytes.data() + offset, stride, count};
}

std::uint64_t count_of(const JsonValue& place) {
  const std::uint64_t count = place.at("count").unsigned_integer();
  if (count == 0 || count > std::numeric_limits<std::uint32_t>::max()) {
    place.fail(fmt::format("count {}; accepted: 1 to {}", count,
                           std::numeric_limits<std::uint32_t>::max()));
  }
  return count;
}

std::size_t component_count(const JsonValue& accessor) {
  const std::string type = accessor.at("type").text();
  if (type == "SCALAR") return 1;
  if (type == "VEC2") return 2;
  if (type == "VEC3") return 3;
  if (type == "VEC4") return 4;
  accessor.fail(fmt::format("type '{}'; accepted here: SCALAR, VEC2, VEC3, VEC4", type));
}

std::size_t index_size(const JsonValue& place, std::uint64_t type) {
  if (type != type_u8 && type != type_u16 && type != type_u32) {
    place.fail(fmt::format("componentType {}; accepted for indices: 5121, 5123, 5125", type));
  }
  return component_size(place, type);
}

std::vector<std::uint32_t> load_indices(const Elements& elements, std::uint64_t type) {
  std::vector<std::uint32_t> indices(elements.count);
  if (type == type_u32 && elements.stride == 4) {
    std::memcpy(indices.data(), elements.first, indices.size() * 4);
    return indices;
  }
  for (std::size_t i = 0; i < indices.size(); ++i) {
    indices[i] = component_as_index(elements.first + i * elements.stride, type);
  }
  return indices;
}

}  // namespace

std::span<const std::byte> GltfFile::view_bytes(std::size_t buffer_view) const {
  const JsonValue& view = list("bufferViews")[buffer_view];
  const std::span<const std::byte> buffer =
      buffers_[view.at("buffer").index(buffers_.size(), "buffers")];
  const std::uint64_t offset = view.unsigned_or("byteOffset", 0);
  const std::uint64_t length = view.at("byteLength").unsigned_integer();
  if (offset > buffer.size() || length > buffer.size() - offset) {
    view.fail(fmt::format("bytes {} to {} pass the end of its buffer, which has {} bytes", offset,
                          offset + length, buffer.size()));
  }
  return buffer.subspan(offset, length);
}

std::uint64_t GltfFile::element_count(std::size_t accessor) const {
  return count_of(list("accessors")[accessor]);
}

std::vector<float> GltfFile::read_floats(std::size_t accessor, int components) const {
  const JsonValue& place = list("accessors")[accessor];
  const std::uint64_t count = count_of(place);
  const std::size_t width = component_count(place);
  if (width != std::size_t(components)) {
    place.fail(fmt::format("has {} components an element; {} are needed", width, components));
  }
  const std::uint64_t type = place.at("componentType").unsigned_integer();
  const std::size_t size = component_size(place, type);
  const auto normalized_member = place.find("normalized");
  const bool normalized = normalized_member && normalized_member->boolean();
  const auto sparse = place.find("sparse");

  std::vector<float> values;
  const auto load_element = [&](const std::byte* bytes, float* target) {
    for (std::size_t c = 0; c < width; ++c) {
      target[c] = component_as_float(bytes + c * size, type, normalized);
    }
  };
  if (place.find("bufferView")) {
    const Elements elements = locate(*this, place, count, width * size);
    values.resize(count * width);
    if (type == type_f32 && elements.stride == width * size) {
      std::memcpy(values.data(), elements.first, values.size() * sizeof(float));
    } else {
      for (std::size_t i = 0; i < count; ++i) {
        load_element(elements.first + i * elements.stride, &values[i * width]);
      }
    }
  } else {
    if (!sparse) place.fail("has neither a bufferView nor sparse values");
    if (count > max_virtual_elements) {
      place.fail(fmt::format("count {} without a bufferView; accepted: up to {}", count,
                             max_virtual_elements));
    }
    values.resize(count * width);
  }
  if (sparse) {
    const std::uint64_t sparse_count = count_of(*sparse);
    const JsonValue index_place = sparse->at("indices");
    const std::uint64_t index_type = index_place.at("componentType").unsigned_integer();
    const std::vector<std::uint32_t> indices = load_indices(
        locate(*this, index_place, sparse_count, index_size(index_place, index_type)), index_type);
    const Elements elements = locate(*this, sparse->at("values"), sparse_count, width * size);
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (indices[i] >= count) {
        index_place.fail(
            fmt::format("index {} is {}; the accessor has {} elements", i, indices[i], count));
      }
      load_element(elements.first + i * elements.stride, &values[indices[i] * width]);
    }
  }
  return values;
}

std::vector<std::uint32_t> GltfFile::read_indices(std::size_t accessor) const {
  const JsonValue& place = list("accessors")[accessor];
  const std::uint64_t count = count_of(place);
  if (component_count(place) != 1) place.fail("indices must be of type SCALAR");
  if (place.find("sparse")) place.fail("sparse indices are not accepted");
  const std::uint64_t type = place.at("componentType").unsigned_integer();
  return load_indices(locate(*this, place, count, index_size(place, type)), type);
}

}  // namespace occlab

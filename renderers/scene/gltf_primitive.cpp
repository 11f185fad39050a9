#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "renderers/scene/gltf_parts.h"
#include "renderers/scene/limits.h"

namespace occlab {
namespace {

template <typename Vector>
std::vector<Vector> read_vectors(const GltfFile& file, const JsonValue& accessor) {
  const std::size_t index = accessor.index(file.list("accessors").size(), "accessors");
  const std::vector<float> values = file.read_floats(index, Vector::length());
  std::vector<Vector> vectors(values.size() / std::size_t(Vector::length()));
  static_assert(sizeof(Vector) == sizeof(float) * std::size_t(Vector::length()));
  std::memcpy(static_cast<void*>(vectors.data()), values.data(), values.size() * sizeof(float));
  return vectors;
}

/// Fails if a component of a vector is NaN or infinite.
template <typename Vector>
void require_finite(const JsonValue& accessor, const std::vector<Vector>& vectors,
                    std::string_view what, const std::string& mesh_name) {
  const auto bad = [](const Vector& v) {
    for (int c = 0; c < Vector::length(); ++c) {
      if (!std::isfinite(v[c])) return true;
    }
    return false;
  };
  const auto first = std::ranges::find_if(vectors, bad);
  if (first == vectors.end()) return;
  accessor.fail(fmt::format("{} of {} {} of mesh '{}' are NaN or infinite, the first at vertex {}",
                            std::count_if(first, vectors.end(), bad), vectors.size(), what,
                            mesh_name, first - vectors.begin()));
}

void require_count(const JsonValue& accessor, std::size_t found, std::size_t vertices) {
  if (found != vertices) {
    accessor.fail(fmt::format("has {} elements for {} vertices", found, vertices));
  }
}

/// Unit normals. Exported and quantised normals are off by rounding; zero has no direction.
void normalize_normals(const JsonValue& accessor, Mesh& mesh, std::vector<std::string>& warnings) {
  constexpr float tolerance = 1e-2f;
  std::size_t off = 0;
  for (std::size_t v = 0; v < mesh.normals.size(); ++v) {
    const float length = glm::length(mesh.normals[v]);
    if (!(length > 1e-6f && std::isfinite(length))) {
      accessor.fail(
          fmt::format("the normal of vertex {} of mesh '{}' has length {}", v, mesh.name, length));
    }
    if (std::abs(length - 1.0f) > tolerance) ++off;
    mesh.normals[v] /= length;
  }
  if (off > 0) {
    warnings.push_back(fmt::format("mesh '{}': {} of {} normals were not unit; normalised",
                                   mesh.name, off, mesh.normals.size()));
  }
}

/// Three vertices a triangle with its face normal: glTF 2.0 section 3.7.2.1, "when normals are not
/// specified, client implementations MUST calculate flat normals".
void make_flat(Mesh& mesh) {
  Mesh flat;
  const std::size_t corners = mesh.indices.size();
  flat.positions.resize(corners);
  flat.normals.resize(corners);
  if (!mesh.uvs.empty()) flat.uvs.resize(corners);
  for (std::size_t i = 0; i < corners; ++i) {
    flat.positions[i] = mesh.positions[mesh.indices[i]];
    if (!mesh.uvs.empty()) flat.uvs[i] = mesh.uvs[mesh.indices[i]];
  }
  for (std::size_t i = 0; i < corners; i += 3) {
    const glm::dvec3 a = flat.positions[i];
    const glm::dvec3 normal =
        glm::cross(glm::dvec3(flat.positions[i + 1]) - a, glm::dvec3(flat.positions[i + 2]) - a);
    const double length = glm::length(normal);
    // A triangle without area is never seen; any direction will do.
    const glm::vec3 unit = length > 0.0 ? glm::vec3(normal / length) : glm::vec3(0.0f, 1.0f, 0.0f);
    for (std::size_t k = 0; k < 3; ++k) flat.normals[i + k] = unit;
  }
  mesh.positions = std::move(flat.positions);
  mesh.normals = std::move(flat.normals);
  mesh.uvs = std::move(flat.uvs);
  std::iota(mesh.indices.begin(), mesh.indices.end(), 0u);
}

void read_triangle_indices(const GltfFile& file, const JsonValue& primitive, Mesh& mesh) {
  if (const auto accessor = primitive.find("indices")) {
    const std::size_t index = accessor->index(file.list("accessors").size(), "accessors");
    mesh.indices = file.read_indices(index);
    const auto largest = std::ranges::max_element(mesh.indices);
    if (*largest >= mesh.positions.size()) {
      accessor->fail(fmt::format("index {} of mesh '{}' is {}; it has {} vertices",
                                 largest - mesh.indices.begin(), mesh.name, *largest,
                                 mesh.positions.size()));
    }
  } else {
    mesh.indices.resize(mesh.positions.size());
    std::iota(mesh.indices.begin(), mesh.indices.end(), 0u);
  }
  if (mesh.indices.size() % 3 != 0) {
    primitive.fail(fmt::format("{} indices are no whole number of triangles", mesh.indices.size()));
  }
}

/// From what the accessors say of themselves: one of them may serve thousands of primitives.
void count_geometry(const GltfFile& file, const JsonValue& primitive, GeometryTotals& totals) {
  const auto count = [&](const JsonValue& accessor) {
    return file.element_count(accessor.index(file.list("accessors").size(), "accessors"));
  };
  const JsonValue attributes = primitive.at("attributes");
  const std::uint64_t positions = count(attributes.at("POSITION"));
  const auto indices = primitive.find("indices");
  const std::uint64_t corners = indices ? count(*indices) : positions;
  // Flat normals need a vertex for each corner.
  const std::uint64_t vertices =
      attributes.find("NORMAL") ? positions : std::max(positions, corners);
  totals.vertices = saturating_add(totals.vertices, vertices);
  totals.triangles = saturating_add(totals.triangles, corners / 3);
  require_within(Limit::vertices, totals.vertices, "vertices, with those before",
                 primitive.where());
  require_within(Limit::triangles, totals.triangles, "triangles, with those before",
                 primitive.where());
}

}  // namespace

std::optional<Mesh> load_primitive(const GltfFile& file, const JsonValue& primitive,
                                   const std::string& mesh_name, MaterialTable& materials,
                                   GeometryTotals& totals, std::vector<std::string>& warnings) {
  constexpr std::uint64_t triangles = 4;
  const std::uint64_t mode = primitive.unsigned_or("mode", triangles);
  if (mode < triangles) {
    warnings.push_back(fmt::format("mesh '{}': points and lines are not drawn", mesh_name));
    return std::nullopt;
  }
  if (mode != triangles) {
    primitive.at("mode").fail(fmt::format("found {}; accepted: 4 (triangles)", mode));
  }
  const auto extensions = primitive.find("extensions");
  if (extensions && extensions->find("KHR_draco_mesh_compression")) {
    extensions->fail("Draco compression is not accepted; export without it");
  }

  count_geometry(file, primitive, totals);
  Mesh mesh;
  mesh.name = mesh_name;
  mesh.material = materials.material(primitive.find("material"));
  const JsonValue attributes = primitive.at("attributes");
  const JsonValue position = attributes.at("POSITION");
  mesh.positions = read_vectors<glm::vec3>(file, position);
  require_finite(position, mesh.positions, "positions", mesh_name);
  read_triangle_indices(file, primitive, mesh);

  const UvSource& source = materials.uv_source(mesh.material);
  if (!source.attribute.empty()) {
    const JsonValue uv = attributes.at(source.attribute.c_str());
    mesh.uvs = read_vectors<glm::vec2>(file, uv);
    require_count(uv, mesh.uvs.size(), mesh.positions.size());
    require_finite(uv, mesh.uvs, "texture coordinates", mesh_name);
    if (source.transform != glm::mat3(1.0f)) {
      for (glm::vec2& value : mesh.uvs) value = source.transform * glm::vec3(value, 1.0f);
      require_finite(uv, mesh.uvs, "transformed texture coordinates", mesh_name);
    }
  }
  if (const auto normal = attributes.find("NORMAL")) {
    mesh.normals = read_vectors<glm::vec3>(file, *normal);
    require_count(*normal, mesh.normals.size(), mesh.positions.size());
    require_finite(*normal, mesh.normals, "normals", mesh_name);
    normalize_normals(*normal, mesh, warnings);
  } else {
    make_flat(mesh);
    warnings.push_back(fmt::format("mesh '{}' has no normals; flat ones are used", mesh_name));
  }
  if (attributes.find("COLOR_0")) {
    warnings.push_back(fmt::format("mesh '{}': vertex colours are not used", mesh_name));
  }
  if (primitive.find("targets")) {
    warnings.push_back(
        fmt::format("mesh '{}': morph targets are not used; it keeps its base shape", mesh_name));
  }
  return mesh;
}

}  // namespace occlab

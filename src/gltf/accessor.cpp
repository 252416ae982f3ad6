#include "accessor.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace coppice::gltf {
namespace {

static_assert(std::endian::native == std::endian::little,
              "glTF buffers are little-endian and are read in place");

template <class T>
T load(const unsigned char* p) {
  T value;
  std::memcpy(&value, p, sizeof value);
  return value;
}

template <class T>
float integer(const unsigned char* p, bool normalized) {
  const float value = float(load<T>(p));
  return normalized ? std::max(value / float(std::numeric_limits<T>::max()), -1.0f) : value;
}

std::size_t component_size(int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      return 0;
  }
}

std::size_t component_count(int type) {
  const int count = tinygltf::GetNumComponentsInType(std::uint32_t(type));
  return count > 0 ? std::size_t(count) : 0;
}

Elements checked_elements(const Document& document, int accessor, int type, const std::string& owner) {
  if (!has_item(document.model.accessors, accessor))
    document.fail(owner, "there is no accessor " + std::to_string(accessor));
  const tinygltf::Accessor& source = document.model.accessors[std::size_t(accessor)];
  const std::string item = owner + ", " + item_name("accessor", std::size_t(accessor), source.name);
  if (source.sparse.isSparse)
    document.fail(item, "sparse accessors are not supported", "export the file without them");
  if (source.type != type) document.fail(item, "it has another type than this attribute allows");
  const std::size_t component = component_size(source.componentType);
  if (component == 0)
    document.fail(item, "component type " + std::to_string(source.componentType) + " is not allowed");
  const auto bytes = view_bytes(document, source.bufferView, item);
  const std::size_t given = document.model.bufferViews[std::size_t(source.bufferView)].byteStride;
  const std::size_t element = component * component_count(type), stride = given > 0 ? given : element;
  if (stride < element) document.fail(item, "its stride is shorter than its elements");
  const bool fits = source.count == 0 ||
                    (source.byteOffset <= bytes.size() && element <= bytes.size() - source.byteOffset &&
                     source.count - 1 <= (bytes.size() - source.byteOffset - element) / stride);
  if (!fits)
    document.fail(item, "its " + std::to_string(source.count) + " elements reach beyond its buffer view");
  const unsigned char* first = source.count > 0 ? bytes.data() + source.byteOffset : nullptr;
  return {first, source.count, stride, source.componentType, source.normalized};
}

}  // namespace

std::span<const unsigned char> view_bytes(const Document& document, int view, const std::string& item) {
  const tinygltf::Model& model = document.model;
  if (!has_item(model.bufferViews, view))
    document.fail(item, "there is no buffer view " + std::to_string(view));
  const tinygltf::BufferView& source = model.bufferViews[std::size_t(view)];
  const std::string name = item + ", " + item_name("buffer view", std::size_t(view), source.name);
  if (!has_item(model.buffers, source.buffer))
    document.fail(name, "there is no buffer " + std::to_string(source.buffer));
  const std::vector<unsigned char>& bytes = model.buffers[std::size_t(source.buffer)].data;
  if (source.byteOffset > bytes.size() || source.byteLength > bytes.size() - source.byteOffset)
    document.fail(name, "it reaches beyond its buffer of " + std::to_string(bytes.size()) + " bytes");
  return std::span(bytes).subspan(source.byteOffset, source.byteLength);
}

float Elements::component(std::size_t i, std::size_t c) const {
  const unsigned char* p = data + i * stride + c * component_size(component_type);
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return integer<std::int8_t>(p, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return integer<std::uint8_t>(p, normalized);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return integer<std::int16_t>(p, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return integer<std::uint16_t>(p, normalized);
    default:
      return load<float>(p);
  }
}

std::uint32_t Elements::index(std::size_t i) const {
  const unsigned char* p = data + i * stride;
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return *p;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return load<std::uint16_t>(p);
    default:
      return load<std::uint32_t>(p);
  }
}

Elements attribute_elements(const Document& document, int accessor, int type, const std::string& item) {
  const Elements elements = checked_elements(document, accessor, type, item);
  if (elements.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
    document.fail(item, "32-bit integers are not allowed in an attribute");
  return elements;
}

Elements index_elements(const Document& document, int accessor, const std::string& item) {
  const Elements elements = checked_elements(document, accessor, TINYGLTF_TYPE_SCALAR, item);
  const int type = elements.component_type;
  if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
      type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
    document.fail(item, "indices must be unsigned integers");
  return elements;
}

}  // namespace coppice::gltf

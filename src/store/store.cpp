#include <coppice/store/store.hpp>

#include "encode.hpp"
#include "envelope.hpp"
#include "file.hpp"
#include "refusal.hpp"

namespace coppice {

template <Quantised Value>
void write_store(const std::filesystem::path& path, const StoredVisibility<Value>& visibility) {
  store::naming(path, [&] { store::write_whole(path, store::to_file(store::encode(visibility))); });
}

template <Quantised Value>
StoredVisibility<Value> read_store(const std::filesystem::path& path) {
  return store::naming(path, [&] {
    const store::Bytes file = store::read_bytes(path);
    store::Hdf5Reader reader(store::unseal(file));
    return store::decode<Value>(reader);
  });
}

Settings read_settings(const std::filesystem::path& path) {
  return store::naming(path, [&] {
    const store::Bytes file = store::read_bytes(path);
    store::Hdf5Reader reader(store::unseal(file));
    return store::decode_settings(reader);
  });
}

template void write_store(const std::filesystem::path&, const StoredVisibility<std::uint8_t>&);
template void write_store(const std::filesystem::path&, const StoredVisibility<std::uint16_t>&);
template StoredVisibility<std::uint8_t> read_store(const std::filesystem::path&);
template StoredVisibility<std::uint16_t> read_store(const std::filesystem::path&);

}  // namespace coppice

#include <coppice/store/room_store.hpp>

#include "encode.hpp"
#include "envelope.hpp"
#include "file.hpp"
#include "refusal.hpp"
#include "room.hpp"

namespace coppice {

void write_room(const std::filesystem::path& path, const StoredRoom& room) {
  store::naming(path,
                [&] { store::write_whole(path, store::to_file(store::encode(room), store::Kind::room)); });
}

StoredRoom read_room(const std::filesystem::path& path) {
  return store::naming(path, [&] {
    const store::Bytes file = store::read_bytes(path);
    store::Hdf5Reader reader(store::unseal(file, store::Kind::room));
    return store::decode_room(reader);
  });
}

Settings read_room_settings(const std::filesystem::path& path) {
  return store::naming(path, [&] {
    const store::Bytes file = store::read_bytes(path);
    store::Hdf5Reader reader(store::unseal(file, store::Kind::room));
    return store::decode_settings(reader);
  });
}

}  // namespace coppice

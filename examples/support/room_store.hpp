// --store: a prepared room that one run of a program leaves for the next.
#pragma once

#include <coppice/store/room_store.hpp>
#include <optional>
#include <support/pca_room.hpp>
#include <support/store_note.hpp>

namespace coppice::program {

/// The file of --store. Without one nothing is read or written.
class RoomStore {
 public:
  RoomStore(std::filesystem::path file, const PcaRoomOptions& options, const Scene& scene, const vec3& eye);

  /// What the file holds, where it was made from the same scene and settings. Otherwise stderr tells why
  /// not. Throws InputError where the file is damaged or no store of a room.
  std::optional<StoredRoom> read();

  /// Completes the room by settings and samples, and writes it. Precondition: is_used().
  void write(const ClusteredSamples& samples, StoredRoom& room) const;

  bool is_used() const { return !file_.empty(); }
  /// For the report: what was done with the store and why; empty without one.
  const std::string& note() const { return note_.text(); }

 private:
  std::filesystem::path file_;
  Settings settings_;
  std::size_t triangles_;
  StoreNote note_;
};

}  // namespace coppice::program

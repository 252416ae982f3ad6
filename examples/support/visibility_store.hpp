// --store: visibility that one run of a program leaves for the next.
#pragma once

#include <coppice/relight/local_relighting.hpp>
#include <coppice/store/store.hpp>
#include <optional>
#include <string>
#include <support/store_note.hpp>
#include <support/system.hpp>

namespace coppice::program {

/// The file of --store, and beside it one for each further set of lights. Without --store nothing is read or
/// written.
class VisibilityStore {
 public:
  VisibilityStore(const SystemOptions& options, const Inputs& in);

  /// What the file of `part` (empty: the file of --store itself) holds, where there is one that was made from
  /// the same scene and settings and from lights of this fingerprint. Otherwise stderr tells why not. Throws
  /// InputError where the file is damaged or no store, so that nobody's file is lost.
  template <Quantised Value>
  std::optional<StoredVisibility<Value>> read(const std::string& part, const std::string& lights);

  template <Quantised Value>
  void write(const std::string& part, const std::string& lights, StoredVisibility<Value> visibility);

  /// For the report: what was done with the store and why; empty without one.
  const std::string& note() const { return note_.text(); }

 private:
  std::filesystem::path path(const std::string& part) const;
  Settings settings(const std::string& lights) const;

  std::filesystem::path path_;
  Settings settings_;
  StoreNote note_;
};

/// Of places and directions of lights, whatever their intensities.
std::string fingerprint_of(std::span<const LocalLight> lights);
std::string fingerprint_of(std::span<const vec3> directions);

}  // namespace coppice::program

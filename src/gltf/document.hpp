// A glTF file in memory, and the ways to complain about it.
#pragma once

#include <tiny_gltf.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace coppice::gltf {

/// Things worth telling that are not errors, counted by kind, in the order of their first occurrence.
class Warnings {
 public:
  /// `what` follows the count: "zero-area triangles dropped".
  void count(std::string_view what, std::size_t times = 1);
  void add(std::string line) { lines_.push_back(std::move(line)); }
  std::vector<std::string> lines() const;

 private:
  std::vector<std::pair<std::string, std::size_t>> counts_;
  std::vector<std::string> lines_;
};

/// The parsed file. Images hold their encoded bytes, or none where those lie in a buffer view.
struct Document {
  std::filesystem::path file;
  tinygltf::Model model;
  std::string animation_complaint;  ///< about a part of an animation that could not be parsed, or empty

  /// Throws InputError about an item of this file: "FILE, ITEM: PROBLEM; REMEDY".
  [[noreturn]] void fail(const std::string& item, const std::string& problem,
                         const std::string& remedy = "export the file again as valid glTF 2.0") const;
};

/// Reads and parses the file with its buffers. Throws InputError; trusts no length before it is checked.
Document read_document(const std::filesystem::path& file, Warnings& warnings);

/// `kind index "name"`, in one short printable line.
std::string item_name(std::string_view kind, std::size_t index, std::string_view name = {});

/// Text of a file's own, made fit for one line of a message.
std::string one_line(std::string_view text, std::size_t longest = 200);

/// Whether `index` is one of `items`; glTF indices come as int.
template <class Item>
bool has_item(const std::vector<Item>& items, int index) {
  return index >= 0 && std::size_t(index) < items.size();
}

}  // namespace coppice::gltf

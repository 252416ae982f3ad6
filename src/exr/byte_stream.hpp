// OpenEXR's streams, over bytes in memory: files are read and written by our own code, which sees every
// error.
#pragma once

#include <OpenEXR/Iex.h>
#include <OpenEXR/ImfIO.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace coppice::exr {

class InputBytes : public Imf::IStream {
 public:
  explicit InputBytes(std::string_view bytes) : Imf::IStream("image"), bytes_(bytes) {}

  bool read(char* to, int count) override {
    if (count < 0 || position_ > bytes_.size() || std::size_t(count) > bytes_.size() - position_)
      throw Iex::InputExc("the file ends too early");
    std::memcpy(to, bytes_.data() + position_, std::size_t(count));
    position_ += std::size_t(count);
    return position_ < bytes_.size();
  }
  std::uint64_t tellg() override { return position_; }
  void seekg(std::uint64_t position) override { position_ = std::size_t(position); }

 private:
  std::string_view bytes_;
  std::size_t position_ = 0;
};

class OutputBytes : public Imf::OStream {
 public:
  OutputBytes() : Imf::OStream("image") {}

  void write(const char* from, int count) override {
    const std::size_t end = position_ + std::size_t(count);
    if (end > bytes.size()) bytes.resize(end);
    std::memcpy(bytes.data() + position_, from, std::size_t(count));
    position_ = end;
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = std::size_t(position); }

  std::string bytes;

 private:
  std::size_t position_ = 0;
};

}  // namespace coppice::exr

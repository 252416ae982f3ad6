#include "envelope.hpp"

#include <libdeflate.h>

#include <array>
#include <bit>
#include <coppice/core/config.hpp>

#include "refusal.hpp"

namespace coppice::store {
namespace {

static_assert(std::endian::native == std::endian::little, "stores are little-endian, and read as they are");

struct Header {
  std::array<char, 16> magic;
  std::uint32_t version;
  std::uint32_t checksum;       ///< CRC-32 of all bytes of the file but these four
  std::uint64_t payload_bytes;  ///< behind the envelope
  std::uint32_t kind;
  std::uint32_t unused;
};
static_assert(sizeof(Header) == 40 && offsetof(Header, checksum) == 20 && offsetof(Header, kind) == 32);

constexpr std::array<char, 16> magic{'\x89', 'C', 'O', 'P', 'P', 'I', 'C',  'E',
                                     ' ',    'S', 'T', 'O', 'R', 'E', '\r', '\n'};

std::uint32_t checksum_of(std::span<const std::byte> file) {
  constexpr std::size_t begin = offsetof(Header, checksum), end = begin + 4;
  const std::uint32_t head = libdeflate_crc32(0, file.data(), begin);
  return libdeflate_crc32(head, file.data() + end, file.size() - end);
}

const char* name_of(Kind kind) { return kind == Kind::visibility ? "visibility" : "a room"; }

void require_kind(std::uint32_t found, Kind kind) {
  if (found == std::uint32_t(kind)) return;
  const char* held = found == std::uint32_t(Kind::visibility) ? name_of(Kind::visibility)
                     : found == std::uint32_t(Kind::room)     ? name_of(Kind::room)
                                                              : "something of an unknown kind";
  throw Refusal(std::string("is a store of ") + held + ", and not of " + name_of(kind), "name another file");
}

Header header_of(std::span<const std::byte> file) {
  Header header;
  std::memcpy(&header, file.data(), sizeof header);
  return header;
}

}  // namespace

void seal(std::span<std::byte> file, Kind kind) {
  COPPICE_ASSERT(file.size() >= envelope_size);
  Header header{magic, format_version, 0, file.size() - envelope_size, std::uint32_t(kind), 0};
  std::memset(file.data(), 0, envelope_size);
  std::memcpy(file.data(), &header, sizeof header);
  header.checksum = checksum_of(file);
  std::memcpy(file.data(), &header, sizeof header);
}

std::span<const std::byte> unseal(std::span<const std::byte> file, Kind kind) {
  if (file.size() < magic.size() || std::memcmp(file.data(), magic.data(), magic.size()) != 0)
    throw Refusal(std::string("is no store of ") + name_of(kind), "name a file that was written as one");
  if (file.size() < envelope_size) throw Refusal("is truncated: it ends in its header");
  const Header header = header_of(file);
  require_kind(header.kind, kind);
  if (header.version != format_version)
    throw Refusal("has format version " + std::to_string(header.version) +
                  ", and this program reads version " + std::to_string(format_version));
  const std::size_t payload = file.size() - envelope_size;
  if (header.payload_bytes != payload)
    throw Refusal("is truncated or damaged: its header tells of " + std::to_string(header.payload_bytes) +
                  " bytes of data, and " + std::to_string(payload) + " are there");
  if (header.checksum != checksum_of(file)) throw Refusal("is damaged: its checksum does not match");
  return file.subspan(envelope_size);
}

}  // namespace coppice::store

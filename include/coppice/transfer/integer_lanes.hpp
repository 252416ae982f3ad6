// Small integers from memory as Lanes.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <cstdint>

namespace coppice::detail::inline HWY_NAMESPACE {

/// `width` signed integers as floats, from any alignment.
inline Lanes load_integers(const std::int8_t* from) {
  const hn::RebindToSigned<Lanes::Tag> integers;
  const hn::Rebind<std::int8_t, Lanes::Tag> bytes;
  return Lanes(hn::ConvertTo(Lanes::Tag(), hn::PromoteTo(integers, hn::LoadU(bytes, from))));
}
inline Lanes load_integers(const std::int16_t* from) {
  const hn::RebindToSigned<Lanes::Tag> integers;
  const hn::Rebind<std::int16_t, Lanes::Tag> shorts;
  return Lanes(hn::ConvertTo(Lanes::Tag(), hn::PromoteTo(integers, hn::LoadU(shorts, from))));
}

}  // namespace coppice::detail::inline HWY_NAMESPACE

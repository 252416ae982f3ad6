// What an OpenEXR file claims of its layout, checked against its size before the library takes memory for it.
#pragma once

#include <string_view>

namespace coppice::exr {

/// Refuses a file whose attributes, offset tables, windows or pixels its bytes cannot hold; the library
/// itself believes these numbers. Throws Refusal, or the library's exception where a header cannot be parsed.
void check_exr_layout(std::string_view bytes);

}  // namespace coppice::exr

// What a host may set before it includes Coppice.
#pragma once

/// Checks a precondition. A host with its own way to fail defines COPPICE_ASSERT(condition) before it
/// includes any header of Coppice; otherwise this is the assert of <cassert>, which NDEBUG removes.
#ifndef COPPICE_ASSERT
#include <cassert>
#define COPPICE_ASSERT(condition) assert(condition)
#endif

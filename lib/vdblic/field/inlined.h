#pragma once

/// For functions called in hot loops: always inlined, so that they are compiled for their caller's instruction set.
#define VDBLIC_INLINE [[gnu::always_inline]] inline

#pragma once

namespace vdblic::cli {

/// Occupy the descriptors of standard streams that the caller has closed (`>&-`), so that no file gets one of them and
/// receives printed text. Reading or writing such a stream fails. Call it before any file is opened.
void holdStandardStreams();

} // namespace vdblic::cli

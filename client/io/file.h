#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"

namespace pliant::io {

/// The bytes of a file. Fails with kFileNotFound, kFileUnreadable (a folder, no permission, an
/// error of the device) or kTooLarge (more than 16 GiB).
[[nodiscard]] Result<std::string> ReadFile(const std::string& path);

/// Replaces the file in one step: whoever reads `path` sees the old bytes or the new ones, never a
/// part, also after a crash of this program. Fails with kFileUnwritable and leaves nothing behind.
[[nodiscard]] Status WriteFileAtomically(const std::string& path, std::string_view bytes);

[[nodiscard]] bool FileExists(const std::string& path);

/// The part of the last path component from its last dot on, in lower case: ".mesh"; empty if none.
[[nodiscard]] std::string Extension(const std::string& path);

/// The path without its Extension().
[[nodiscard]] std::string WithoutExtension(const std::string& path);

}  // namespace pliant::io

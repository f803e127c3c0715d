#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>

#include "core/base/bytes.h"
#include "core/base/result.h"
#include "server/saved_state.h"

/// A session as one file, to be kept elsewhere or to go on with on another server. server/README.md
/// has the layout.
namespace pliant::server {

/// A file whose seal was right; its contents may be anything.
struct SessionFile {
  std::map<std::string, std::string> labels = {};
  std::span<const std::byte> memory = {};  ///< Inside the bytes that were opened.
};

/// Of a session at its last commit: everything but its diffs for resuming and the revisions that
/// nobody has saved. Errors: those of WriteMemory; kTooLarge for a file that could not be imported.
/// @par Cost O(mesh)
[[nodiscard]] Result<Bytes> WriteSessionFile(const std::map<std::string, std::string>& labels,
                                             SessionMemory memory);

/// Errors: kDataCorrupt, also for one that is cut off; kDataVersion. Their field is "file".
/// @par Cost O(bytes), for the checksum
[[nodiscard]] Result<SessionFile> OpenSessionFile(std::span<const std::byte> bytes);

/// The session in a file that came from outside: neither its mesh nor that of any saved revision is
/// taken on trust.
/// @param vertices_max  the session may have, and may grow to, so many.
/// Errors: kDataCorrupt, kDataVersion, kTooLarge. @par Cost O(mesh) for each saved revision
[[nodiscard]] Result<SessionMemory> ReadSessionFile(const SessionFile& file,
                                                    const SessionMakers& makers,
                                                    std::int32_t vertices_max);

}  // namespace pliant::server

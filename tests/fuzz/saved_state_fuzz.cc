// Goal: no bytes crash, hang or leave their memory when they are read as a snapshot or as a
// revision record, with or without a right checksum, and a session that is read from a snapshot
// whose mesh is valid works. Method: libFuzzer under AddressSanitizer and UBSan. The first byte
// chooses what the others are; a seal is put around them, because no mutation finds a checksum.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "core/base/bytes.h"
#include "core/base/check.h"
#include "core/mesh/validate.h"
#include "core/pliant/remesher.h"
#include "tests/support/session_script.h"

namespace {

using pliant::Bytes;
using pliant::Remesher;

constexpr pliant::Seal kSnapshotSeal{.kind = 0x53534c50, .version = 2};
constexpr pliant::Seal kDeltaSeal{.kind = 0x44524c50, .version = 2};
constexpr std::size_t kSealBytes = 24;

struct Examples {
  Bytes snapshot;  ///< Of revision 2, without its seal.
  Bytes delta;     ///< From it to revision 3, without its seal.
  Bytes state;     ///< The same snapshot, sealed.
};

const Examples& Known() {
  static const Examples examples = [] {
    const pliant::testing::SessionScript script(4);
    const auto session = script.Start();
    (void)script.Run(*session, 1);
    (void)script.Run(*session, 2);
    Examples made;
    made.state = *session->Save();
    made.snapshot.assign(made.state.begin() + kSealBytes, made.state.end());
    (void)script.Run(*session, 3);
    const Bytes delta = *pliant::WriteDelta(session->InverseOf(*session->TakeUndo()));
    made.delta.assign(delta.begin() + kSealBytes, delta.end());
    return made;
  }();
  return examples;
}

/// The known bytes with others written over them: pairs of a position (three bytes) and a value.
Bytes Patched(Bytes bytes, std::span<const std::uint8_t> patches) {
  for (std::size_t i = 0; i + 3 < patches.size(); i += 4) {
    const std::size_t at = patches[i] + 256 * (patches[i + 1] + std::size_t{256} * patches[i + 2]);
    bytes[at % bytes.size()] = static_cast<std::byte>(patches[i + 3]);
  }
  return bytes;
}

void TrySnapshot(std::span<const std::byte> bytes) {
  const auto loaded = Remesher::Load(bytes);
  if (!loaded.ok() || !pliant::Validate((*loaded)->mesh()).empty()) return;
  PLIANT_CHECK((*loaded)->Save().ok());
}

void TryDelta(std::span<const std::byte> bytes) {
  const auto session = *Remesher::Load(Known().state);
  const auto delta = session->ReadDelta(bytes);
  if (!delta.ok()) return;
  const auto applied = session->Apply(*delta, delta->revision);
  if (applied.ok()) (void)pliant::Validate(session->mesh());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span<const std::uint8_t> rest(data + 1, size - 1);
  switch (data[0] % 4) {
    case 0:
      TrySnapshot(std::as_bytes(rest));
      break;
    case 1:
      TryDelta(std::as_bytes(rest));
      break;
    case 2:
      TrySnapshot(pliant::SealBytes(kSnapshotSeal, Patched(Known().snapshot, rest)));
      break;
    default:
      TryDelta(pliant::SealBytes(kDeltaSeal, Patched(Known().delta, rest)));
  }
  return 0;
}

#pragma once

namespace pliant {

/// Gives the system back what was freed and the allocator keeps, as far as whole pages are free: a
/// large build frees tens of megabytes in pieces between which small ones live on.
///
/// Does nothing where the allocator has no such call. *Threads*: any.
/// @par Cost milliseconds at most, and pages that must be asked for again
void ReturnFreedMemory();

}  // namespace pliant

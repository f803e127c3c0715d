#include "core/base/freed_memory.h"

#ifdef __linux__
#include <malloc.h>
#endif

namespace pliant {

void ReturnFreedMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace pliant

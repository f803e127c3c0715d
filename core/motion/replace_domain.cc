#include "core/motion/replace_domain.h"

#include "core/motion/domain_swap.h"

namespace pliant {

Result<DomainReport> ReplaceDomain(Remesher& remesher, const Domain& domain) {
  if (remesher.revision() == Revision::kNone) {
    return Error{ErrorCode::kRevisionNotFound,
                 "there is no revision yet whose domain could be replaced: create the session with "
                 "this domain, or advance first",
                 "domain"};
  }
  DomainSwap swap(domain);
  PLIANT_RETURN_IF_ERROR(remesher.Apply(swap));
  return swap.report();
}

}  // namespace pliant
